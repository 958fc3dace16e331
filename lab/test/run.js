// Drives the built page as a person would and asserts the numbers it shows.
import { readdirSync } from 'node:fs';

import { closeBrowser, serve } from './browser.js';

const [, , only, named] = process.argv;
const folder = new URL('./widgets/', import.meta.url);
const server = await serve();
let failures = 0;
for (const file of readdirSync(folder).filter((name) => only === undefined || name.includes(only)).sort()) {
  const { default: cases } = await import(new URL(file, folder).href);
  for (const [name, run] of Object.entries(cases).filter(([name]) => named === undefined || name.includes(named))) {
    const start = Date.now();
    try {
      await run(server.address);
      console.log(`ok      ${file.replace('.js', '')}: ${name} (${Date.now() - start} ms)`);
    } catch (error) {
      failures += 1;
      console.log(`FAILED  ${file.replace('.js', '')}: ${name}\n${error.stack}`);
    }
  }
}
await closeBrowser();
await server.close();
if (failures > 0) {
  console.log(`${failures} failed`);
  process.exit(1);
}
