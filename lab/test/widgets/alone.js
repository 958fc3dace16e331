// Each experiment alone at its own address, as another page embeds it.
import { createServer } from 'node:http';

import { AxeBuilder } from '@axe-core/playwright';

import { openPage } from '../browser.js';
import { assert, at, near } from '../person.js';

const IDS = [
  'opening', 'predict-first', 'replay', 'lagrangian-lab', 'inertia-ellipse', 'tumbling-brick', 'knife-edge', 'workbench', 'your-robot',
  'integrator-race', 'flip-map',
];

const alone = async (address, id, run, { query = '', state = '', ...options } = {}) => {
  const hash = `?only=${id}${query}#${id}${state}`;
  const { page, faults, close } = await openPage(address, { reducedMotion: 'reduce', hash, ...options });
  try {
    await run(page);
    assert.deepEqual(faults, []);
  } finally {
    await close();
  }
};

export default {
  'every experiment stands alone: no masthead, no others, fit for a frame': async (address) => {
    for (const id of IDS) {
      await alone(address, id, async (page) => {
        assert.deepEqual(await page.$$eval('section', (all) => all.map((one) => one.id)), [id]);
        assert.equal(await page.locator('.masthead, footer').count(), 0);
        assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 700);
        // The embedding page has its own heading.
        const { violations } = await new AxeBuilder({ page }).disableRules(['page-has-heading-one']).analyze();
        assert.deepEqual(violations.map((one) => one.id), [], id);
      }, { viewport: { width: 700, height: 760 } });
    }
  },

  'its state is in the address, and in the HTML that embeds it': (address) =>
    alone(address, 'lagrangian-lab', async (page) => {
      assert.equal(await page.locator('[data-reading="q1"]').textContent(), '0.500');
      await page.getByRole('toolbar', { name: 'Share' }).getByRole('button', { name: 'Embed' }).click();
      const code = await page.locator('.embed-code').inputValue();
      assert.match(code, /^<iframe src="[^"]*\?only=lagrangian-lab#lagrangian-lab\?q1=0\.5&amp;q2=-1/);
      assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'dark');
    }, { query: '&theme=dark', state: '?q1=0.5&q2=-1&h=0.002' }),

  'an unknown experiment gives a list of the known ones': (address) =>
    alone(address, 'nothing', async (page) => {
      assert.match(await page.getByRole('alert').last().textContent(), /no experiment named “nothing”.*lagrangian-lab/);
    }),

  'it runs in a frame of another page': async (address) => {
    const frame = `<!doctype html><title>course</title><iframe src="${address}?only=knife-edge" width="700" height="760"></iframe>`;
    const server = createServer((_, answer) => answer.writeHead(200, { 'content-type': 'text/html' }).end(frame));
    await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
    const { page, close } = await openPage(address, { reducedMotion: 'reduce' });
    try {
      await page.goto(`http://127.0.0.1:${server.address().port}/`);
      const inside = page.frameLocator('iframe');
      await inside.getByRole('button', { name: 'Play', exact: true }).click();
      await page.waitForTimeout(700);
      await inside.getByRole('button', { name: 'Pause', exact: true }).click();
      assert.ok(Number(await inside.locator('[data-reading="t"]').textContent()) > 0.2, 'it runs');
    } finally {
      await close();
      await new Promise((resolve) => server.close(resolve));
    }
  },

  'the whole page gives the same HTML': (address) =>
    at(address, 'workbench', async (person) => {
      await person.press('Embed');
      const code = await person.section.locator('.embed-code').inputValue();
      assert.match(code, /\?only=workbench#workbench\?q1=/);
      near(await person.section.locator('.embed-code').count(), 1, 0, 'one field');
    }),
};
