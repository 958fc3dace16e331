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
  'the page takes 150 kB, its physics 250 kB, three dimensions 400 kB, compressed, at the most': async (address) => {
    const { page, close } = await openPage(address, { hash: '#opening' });
    const fetched = async () => {
      const names = await page.evaluate(() => performance.getEntriesByType('resource').map((entry) => entry.name));
      return new Set(names.filter((name) => name.startsWith(address)).map((name) => name.slice(address.length)));
    };
    const weighed = (name) => gzipSync(readFileSync(new URL(`site/${name}`, dist)), { level: 9 }).length;
    const weigh = (names) => [...names].reduce((sum, name) => sum + weighed(name), 0);
    const [start, physics] = [await fetched(), /\.wasm$/];
    const words = weigh(['index.html', ...[...start].filter((name) => !physics.test(name))]);
    const module = weigh([...start].filter((name) => physics.test(name)));
    assert.ok(![...start].some((name) => name.includes('robots')), 'the module for robots is not loaded yet');
    const robot = page.getByText('“panda” has');
    // Elements on the way get their layout and move the target.
    for (let tries = 0; tries < 100 && !(await robot.isVisible()); tries += 1) {
      await page.locator('#your-robot').evaluate((one) => one.scrollIntoView({ block: 'end', behavior: 'instant' }));
      await page.waitForTimeout(300);
    }
    await robot.waitFor();
    const later = [...await fetched()].filter((name) => !start.has(name) && !/flips|worker|thread|queue|card/.test(name));
    const [robots, solid] = [true, false].map((one) => weigh(later.filter((name) => physics.test(name) === one)));
    await close();
    const kilobytes = (bytes) => `${(bytes / 1000).toFixed(0)} kB`;
    console.log(`        page ${kilobytes(words)}, its physics ${kilobytes(module)}; three dimensions ${kilobytes(solid)}, `
      + `the robots’ physics ${kilobytes(robots)}`);
    assert.ok(words > 20_000 && words < 150_000, `the page takes ${words} bytes`);
    assert.ok(module > 50_000 && module < 250_000, `its physics takes ${module} bytes`);
    assert.ok(words + module < 200_000, `the start takes ${words + module} bytes`);
    assert.ok(solid > 100_000 && solid < 400_000, `three dimensions take ${solid} bytes`);
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
