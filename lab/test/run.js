// Runs the cases on the built page.
import { readdirSync } from 'node:fs';

import { closeBrowser, serve } from './browser.js';

const [, , only, named] = process.argv;
const folder = new URL('./widgets/', import.meta.url);
const server = await serve();
const cases = [];
for (const file of readdirSync(folder).filter((name) => only === undefined || name.includes(only)).sort()) {
  const { default: those } = await import(new URL(file, folder).href);
  const asked = Object.entries(those).filter(([name]) => named === undefined || name.includes(named));
  cases.push(...asked.map(([name, run]) => ({ name: `${file.replace('.js', '')}: ${name}`, run })));
}

/** Runs waiting cases until none is left. */
async function work() {
  for (let one = cases.shift(); one !== undefined; one = cases.shift()) {
    const start = Date.now();
    try {
      await one.run(server.address);
      console.log(`ok      ${one.name} (${Date.now() - start} ms)`);
    } catch (error) {
      failures += 1;
      console.log(`FAILED  ${one.name}\n${error.stack}`);
    }
  }
}

// Cases mostly wait, so three run in parallel, each in its own session.
let failures = 0;
await Promise.all([work(), work(), work()]);
await closeBrowser();
await server.close();
if (failures > 0) {
  console.log(`${failures} failed`);
  process.exit(1);
}
