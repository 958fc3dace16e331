import { readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';

import { AxeBuilder } from '@axe-core/playwright';

import { openPage } from '../browser.js';
import { assert, opened } from '../person.js';

const dist = new URL('../../dist/', import.meta.url);

async function accessible(page) {
  const { violations } = await new AxeBuilder({ page }).analyze();
  assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map((node) => node.html).join(' ')}`), []);
}

const cases = {
  'first load is under 200 kB, compressed': async (address) => {
    const { page, close } = await openPage(address);
    const fetched = await page.evaluate(() => performance.getEntriesByType('resource').map((entry) => entry.name));
    await close();
    const files = ['index.html', ...fetched.filter((name) => name.startsWith(address)).map((name) => name.slice(address.length))];
    const total = files.reduce((sum, name) => sum + gzipSync(readFileSync(new URL(`site/${name}`, dist)), { level: 9 }).length, 0);
    console.log(`        first load ${(total / 1000).toFixed(0)} kB in ${files.length} files`);
    assert.ok(files.some((name) => name.endsWith('.wasm')) && total < 200_000, `${total} bytes`);
    assert.ok(!files.some((name) => name.includes('robots')), 'the module for robots waits until someone comes to one');
  },
  'every self-check agrees': (address) =>
    opened(address, {}, async (page) => {
      await page.locator('#self-checks').scrollIntoViewIfNeeded();
      await page.waitForSelector('#self-checks[data-failed]');
      assert.equal(await page.getAttribute('#self-checks', 'data-failed'), '0');
      assert.ok((await page.locator('#self-checks tbody tr').count()) > 35);
    }),
  'reduced motion starts paused': (address) =>
    opened(address, {}, async (page) => {
      assert.equal(await page.getByRole('button', { name: 'Pause', exact: true }).count(), 0);
    }),
  'the single file opens without a server': async () => {
    const file = new URL('single/index.html', dist).href;
    await opened(file, {}, async (page) => {
      assert.ok((await page.locator('section.widget').count()) > 1);
    });
  },
  'nothing is wider than a phone': (address) =>
    opened(address, { viewport: { width: 360, height: 740 } }, async (page) => {
      const wide = await page.evaluate(() =>
        [...document.querySelectorAll('body *')]
          .filter((element) => element.getBoundingClientRect().right > 361 && !element.closest('.table, .math, svg'))
          .map((element) => `${element.tagName}.${element.className}`),
      );
      assert.deepEqual(wide, []);
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
    }),
};
for (const [name, options] of Object.entries({
  light: { colorScheme: 'light' },
  dark: { colorScheme: 'dark' },
  phone: { viewport: { width: 390, height: 844 } },
})) {
  cases[`no accessibility violation (${name})`] = (address) => opened(address, options, accessible);
}
export default cases;
