// Pictures of every experiment in light, dark and phone layout, for inspection by eye.
import { mkdirSync } from 'node:fs';

import { asOnACard, closeBrowser, openPage, serve } from './browser.js';

const only = process.argv[2];
const views = [
  ['light', { width: 1280, height: 900 }, 'light'],
  ['dark', { width: 1280, height: 900 }, 'dark'],
  ['phone', { width: 390, height: 844 }, 'light'],
];
mkdirSync('screenshots', { recursive: true });
const server = await serve();
for (const [name, viewport, colorScheme] of views) {
  const { page, close } = await openPage(server.address, { before: asOnACard, viewport, colorScheme });
  await page.screenshot({ path: `screenshots/top-${name}.png` });
  const ids = await page.$$eval('section.widget', (sections) => sections.map((section) => section.id));
  for (const id of ids.filter((id) => only === undefined || id === only)) {
    const section = page.locator(`#${id}`);
    await section.scrollIntoViewIfNeeded();
    const play = section.getByRole('button', { name: 'Play', exact: true });
    if (await play.isVisible()) await play.click();
    await page.waitForTimeout(id === 'integrator-race' ? 6000 : 1500);
    await section.screenshot({ path: `screenshots/${id}-${name}.png` });
  }
  await close();
}
await closeBrowser();
await server.close();
