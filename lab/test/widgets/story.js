// The passages between the experiments: a prediction drawn by the user, then the curve, then numbers in the
// text.
import { assert, at, near } from '../person.js';

const PASSAGES = ['inertia-ellipse', 'lagrangian-lab', 'replay', 'workbench', 'knife-edge', 'tumbling-brick'];

const passage = (person) => person.section.locator('.passage');

/** Draws a line by mouse: heights from 0 to 1, evenly spaced. */
const draws = async (person, heights) => {
  const sheet = passage(person).locator('.sheet');
  await sheet.evaluate((one) => one.scrollIntoView({ block: 'center', behavior: 'instant' }));
  const box = await sheet.boundingBox();
  // Just inside its edges.
  const point = (k) => [box.x + 1 + ((box.width - 2) * k) / (heights.length - 1), box.y + box.height * (1 - heights[k])];
  await person.page.mouse.move(...point(0));
  await person.page.mouse.down();
  for (let k = 1; k < heights.length; k += 1) await person.page.mouse.move(...point(k), { steps: 3 });
  await person.page.mouse.up();
};

/** The curve's height at a fraction of its width, from 0 to 1. */
const curveAt = (person, share) =>
  passage(person).locator('.answer-curve').evaluate((path, part) => {
    const points = [...path.getAttribute('d').matchAll(/[ML](\S+) ([^ML\s]+)/g)].map((match) => match.slice(1).map(Number));
    return 1 - points[Math.round(part * (points.length - 1))][1] / 6;
  }, share);

export default {
  'every passage asks first, without curve or answer': async (address) => {
    for (const id of PASSAGES) {
      await at(address, id, async (person) => {
        assert.equal(await passage(person).locator('.tells').isVisible(), false, id);
        assert.equal(await passage(person).locator('.answer-curve').getAttribute('d'), null, id);
        await passage(person).getByRole('button', { name: 'Show the curve' }).click();
        assert.ok((await passage(person).locator('.answer-curve').getAttribute('d')).length > 500, id);
        assert.ok((await passage(person).locator('.tells').textContent()).length > 100, id);
        assert.ok((await passage(person).getByRole('slider').count()) >= 1, `${id} has a number to drag`);
      });
    }
  },

  'what was drawn is compared with the curve': (address) =>
    at(address, 'lagrangian-lab', async (person) => {
      // The answer is a parabola from 8 to 0 to 8 N·m, so the drawing is close to it.
      const rates = Array.from({ length: 33 }, (_, k) => -4 + k / 4);
      await draws(person, rates.map((rate) => (0.5 * rate * rate + 10) / 20));
      await passage(person).getByRole('button', { name: 'Show the curve' }).click();
      assert.match(await passage(person).locator('.off-by').textContent(), /^Very close/);
      near(await curveAt(person, 0), 0.9, 1e-3, '8 N·m at −4 rad/s');
      near(await curveAt(person, 0.5), 0.5, 1e-3, 'nothing at rest');
    }),

  'a number in the text changes the curve and highlights its term': (address) =>
    at(address, 'lagrangian-lab', async (person) => {
      await passage(person).getByRole('button', { name: 'Show the curve' }).click();
      const elbow = passage(person).getByRole('slider', { name: 'Angle of the elbow' });
      await elbow.focus();
      await elbow.press('Home');
      near(await curveAt(person, 0), 0.5, 1e-3, 'folded, there is no elbow to open');
      const lit = await passage(person).locator('math .lit').evaluateAll((all) => all.map((one) => one.dataset.term));
      assert.deepEqual(lit, ['coupling']);
    }),

  'a finger draws sideways, and scrolls the page up and down': (address) =>
    at(address, 'workbench', async (person) => {
      const [sheet, guess] = ['.sheet', '.guess'].map((part) => passage(person).locator(part));
      assert.ok((await person.swipes(sheet, 150)) > 60, 'the page scrolls');
      assert.equal((await guess.getAttribute('d')) ?? '', '', 'and nothing is drawn');
      await sheet.evaluate((one) => one.scrollIntoView({ block: 'center', behavior: 'instant' }));
      const box = await sheet.boundingBox();
      const finger = await person.page.context().newCDPSession(person.page);
      const send = (type, share) => finger.send('Input.dispatchTouchEvent', {
        type, touchPoints: share === undefined ? [] : [{ x: box.x + share * box.width, y: box.y + (0.5 - 0.3 * share) * box.height }],
      });
      await send('touchStart', 0.1);
      for (let share = 0.2; share < 0.95; share += 0.1) {
        await send('touchMove', share);
        await person.waits(0.02);
      }
      await person.waits(0.2);
      await send('touchEnd');
      assert.ok((await guess.getAttribute('d')).split('L').length > 20, await guess.getAttribute('d'));
      await passage(person).getByRole('button', { name: 'Show the curve' }).tap();
      await passage(person).locator('.off-by', { hasText: '% of the height' }).waitFor();
    }, { viewport: { width: 390, height: 844 }, hasTouch: true }),

  'the keyboard draws and shows the curve, with values for screen readers': (address) =>
    at(address, 'workbench', async (person) => {
      const sheet = passage(person).getByRole('application');
      await sheet.focus();
      for (let k = 0; k < 4; k += 1) await sheet.press('ArrowRight');
      await sheet.press('PageUp');
      assert.match(await passage(person).locator('[aria-live]').textContent(), /you drew 5\.00/);
      await sheet.press('Enter');
      assert.match(await passage(person).locator('.off-by').textContent(), /% of the height/);
      await sheet.press('ArrowLeft');
      assert.match(await passage(person).locator('[aria-live]').textContent(), /it is [12]\.\d\d/);
      near((await curveAt(person, 0.5)) * 8, 3, 1e-2, 'M₁₁ stretched');
      near((await curveAt(person, 0)) * 8, 1, 1e-2, 'M₁₁ folded');
    }),

  'the side force is a line through zero, and the brick flips': async (address) => {
    await at(address, 'knife-edge', async (person) => {
      await passage(person).getByRole('button', { name: 'Show the curve' }).click();
      for (const [share, newtons] of [[0, 6], [0.5, 0], [1, -6]]) {
        near((await curveAt(person, share)) * 20 - 10, newtons, 1e-2, `at ${share}`);
      }
    });
    await at(address, 'tumbling-brick', async (person) => {
      await passage(person).getByRole('button', { name: 'Show the curve' }).click();
      const rates = await Promise.all([0, 0.5].map(async (share) => (await curveAt(person, share)) * 14 - 7));
      near(rates[0], 6, 0.05, 'at first');
      assert.ok(rates[1] < -5, `half way it spins the other way: ${rates[1]}`);
    });
  },
};
