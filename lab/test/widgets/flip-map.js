import { openPage } from '../browser.js';
import { assert, at, near } from '../person.js';

const ID = 'flip-map';

const finished = (person) =>
  person.page.waitForFunction(() => document.querySelector('.flips').dataset.share === '1.0000', null, { timeout: 120_000 });

const data = (person, name) => person.section.locator('.flips').evaluate((one, key) => Number(one.dataset[key]), name);

/** The colours of every eighth point in each direction, which are computed first. */
const coarsePixels = ({ page }) =>
  page.evaluate(() => {
    const { data, width } = document.querySelector('.flips').getContext('2d').getImageData(0, 0, 512, 512);
    const at = (k) => 4 * (8 * Math.floor(k / 64) * width + 8 * (k % 64));
    return Array.from({ length: 64 * 64 }, (_, k) => Array.from(data.slice(at(k), at(k) + 3)));
  });

/** Clicks at fractions of the map's width and height. */
const clicks = async (person, across, down) => {
  const map = person.section.getByRole('application');
  await map.evaluate((one) => one.scrollIntoView({ block: 'center', behavior: 'instant' }));
  const box = await map.boundingBox();
  await person.page.mouse.click(box.x + across * box.width, box.y + down * box.height);
};

export default {
  'a coarse map stands first, the fine one follows': (address) =>
    at(address, ID, async (person) => {
      await finished(person);
      assert.ok((await data(person, 'coarse')) > 0);
      assert.match(await person.section.locator('.says').last().textContent(), /.+/);
      assert.match(await person.section.textContent(), /Runge–Kutta 4 in steps of 10 ms, 20 s at most, in double precision/);
    }),

  'a graphics card computes the same map, by the generated step in single precision': (address) =>
    at(address, ID, async (person) => {
      await finished(person);
      const expected = await coarsePixels(person);
      // The processor emulates the card, and the page is told that it is one.
      const before = () => Object.defineProperty(GPUAdapterInfo.prototype, 'isFallbackAdapter', { get: () => false });
      const { page, faults, close } = await openPage(address, { before, reducedMotion: 'reduce', hash: `?only=${ID}` });
      try {
        await page.waitForFunction(() => Number(document.querySelector('.flips')?.dataset.coarse) > 0, null, { timeout: 120_000 });
        const found = await coarsePixels({ page });
        assert.match(await page.locator(`#${ID}`).textContent(), /in single precision, on the graphics card by WebGPU/);
        // Neighbouring arms diverge in places, and so does rounding; elsewhere colours agree up to a step of
        // 10 ms.
        const alike = found.filter((colour, k) => colour.every((x, i) => Math.abs(x - expected[k][i]) <= 8)).length / found.length;
        const rate = Number(await page.locator('.flips').getAttribute('data-rate'));
        console.log(`        ${(100 * alike).toFixed(1)} % of the points alike; ${(rate / 1e6).toFixed(1)} million steps a second`);
        assert.ok(alike > 0.95, `${alike}`);
        assert.deepEqual(faults, []);
      } finally {
        await close();
      }
    }),

  'a click releases that pendulum, which flips at the time of the map': (address) =>
    at(address, ID, async (person) => {
      await finished(person);
      await clicks(person, 0.97, 0.7);
      await person.waits(0.5);
      await person.press('Pause');
      near(await person.reads('t1'), 169, 1.5, 'the inner rod');
      near(await person.reads('t2'), -72, 1.5, 'the outer rod');
      const flip = await person.reads('flip');
      assert.ok(flip > 0 && flip < 20, `${flip} s`);
      assert.ok((await person.reads('t')) > 0.1, 'it falls');
      await person.press('Open in the Lagrangian lab');
      await person.waits(0.5);
      near(Number(await person.page.locator('#lagrangian-lab [data-reading="q1"]').textContent()), 1.38, 0.03, 'q₁ there');
    }),

  'in the middle none flips, for lack of energy': (address) =>
    at(address, ID, async (person) => {
      await finished(person);
      await clicks(person, 0.5, 0.5);
      assert.match(await person.section.locator('[data-reading="flip"]').textContent(), /never/);
    }),

  'keys move, zoom and release, and the link keeps the view': (address) =>
    at(address, ID, async (person) => {
      await finished(person);
      const map = person.section.getByRole('application');
      await map.focus();
      const before = await person.reads('t1');
      await map.press('ArrowRight');
      near(await person.reads('t1'), before + 180 / 32, 0.02, 'a sixty-fourth of the map');
      await map.press('+');
      await person.press('Copy link to this state');
      assert.match(person.page.url(), /half=1\.570796/);
      await finished(person);
      await map.press('Enter');
      await person.waits(0.3);
      await person.press('Pause');
      assert.ok((await person.reads('t')) > 0.05);
    }),

  'pendulums that start 1e-4 rad apart diverge': (address) =>
    at(address, ID, async (person) => {
      await person.types('Speed', 4);
      await clicks(person, 0.9, 0.12);
      await person.waits(5);
      await person.press('Pause');
      assert.ok((await person.reads('apart')) > 1e-3, `${await person.reads('apart')} m`);
    }),

  'the single file has its workers too': async () => {
    const file = new URL('../../dist/single/index.html', import.meta.url).href;
    const { page, faults, close } = await openPage(file, { reducedMotion: 'reduce', hash: `?only=${ID}` });
    try {
      await page.waitForFunction(() => Number(document.querySelector('.flips').dataset.share) > 0.02, null, { timeout: 60_000 });
      assert.deepEqual(faults, []);
    } finally {
      await close();
    }
  },
};
