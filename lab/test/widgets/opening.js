import { assert, at, near } from '../person.js';

const ID = 'opening';

/** A point of the arm on the screen, at this fraction of the length of its drawn links. */
const along = (person, share) =>
  person.section.locator('.throw-felt').evaluate((path, part) => {
    path.scrollIntoView({ block: 'center', behavior: 'instant' });
    const at = path.getPointAtLength(part * path.getTotalLength()).matrixTransform(path.getScreenCTM());
    return { x: at.x, y: at.y };
  }, share);

const energy = async (person) => {
  const [K, V, start, work, off] = await Promise.all(['K', 'V', 'start', 'work', 'off'].map((key) => person.reads(key)));
  return { K, V, start, work, off };
};

export default {
  'a link is dragged and thrown, and the energy balance contains the work of the hand': (address) =>
    at(address, ID, async (person) => {
      const { x, y } = await along(person, 0.9);
      await person.page.mouse.move(x, y);
      await person.page.mouse.down();
      for (let k = 1; k <= 12; k += 1) await person.page.mouse.move(x - 14 * k, y - 6 * k, { steps: 2 });
      assert.match(await person.section.locator('.spring').getAttribute('d'), /^M/, 'the hand’s pull is drawn');
      await person.page.mouse.up();
      await person.waits(1);
      await person.press('Pause');
      const { K, V, start, work, off } = await energy(person);
      assert.ok(K > 0.5, `it flies: ${K} J`);
      assert.ok(Math.abs(work) > 0.3, `the hand did work: ${work} J`);
      near(K + V, start + work, 0.21, 'what it has and what it was given, to the digits shown');
      assert.ok(off < 1e-3, `${off} J unaccounted for`);
      assert.equal(await person.section.locator('.spring').getAttribute('d'), '');
    }),

  'arrow keys strike its tip, and space goes to the buttons': (address) =>
    at(address, ID, async (person) => {
      const arm = person.section.getByRole('application');
      await arm.focus();
      for (let k = 0; k < 4; k += 1) await arm.press('ArrowUp');
      const { K, start, work } = await energy(person);
      assert.ok(K > 1, `${K} J of motion`);
      near(K, work, 0.11, 'all of it by hand');
      assert.ok(start > 1);
    }),

  'a finger throws it, and beside it the page scrolls': (address) =>
    at(
      address,
      ID,
      async (person) => {
        const { x, y } = await along(person, 0.8);
        const finger = await person.page.context().newCDPSession(person.page);
        const points = (part) => (part === undefined ? [] : [{ x: x - 60 * part, y: y - 40 * part }]);
        const send = (type, part) => finger.send('Input.dispatchTouchEvent', { type, touchPoints: points(part) });
        await send('touchStart', 0);
        for (const part of [0.25, 0.5, 0.75, 1]) {
          await send('touchMove', part);
          await person.waits(0.05);
        }
        await send('touchEnd');
        await person.waits(0.5);
        await person.press('Pause');
        assert.ok(Math.abs((await energy(person)).work) > 0.1, 'it was thrown');
        const box = await person.section.locator('.throw').boundingBox();
        const scrolled = await person.swipesFrom({ x: box.x + 12, y: Math.min(box.y + box.height - 20, 700) }, 200);
        assert.ok(scrolled > 80, `the page went ${scrolled} px`);
      },
      { viewport: { width: 390, height: 844 }, hasTouch: true },
    ),

  'numbers in the text are dragged, and turned by keys': (address) =>
    at(address, ID, async (person) => {
      const gravity = person.handle('Gravity');
      const before = (await energy(person)).V;
      await gravity.focus();
      await gravity.press('PageUp');
      assert.equal(await gravity.getAttribute('aria-valuenow'), '10.8');
      assert.ok((await energy(person)).V > before * 1.05, 'it is heavier');
      const lit = await person.section.locator('math .lit').evaluateAll((all) => all.map((one) => one.dataset.term));
      assert.deepEqual(lit, ['gravity'], 'the term that moved is lit');
      await person.drags('Mass of link 3', 50, 0);
      near(Number(await person.handle('Mass of link 3').getAttribute('aria-valuenow')), 1.8, 1e-9, 'ten steps of a tenth');
    }),

  'each drawn quantity can be switched off, and the link keeps that': (address) =>
    at(address, ID, async (person) => {
      const groups = person.section.locator('.felt-by > g');
      const lit = () => groups.evaluateAll((all) => all.map((one) => one.getAttribute('visibility') ?? 'visible'));
      assert.ok((await lit()).every((one) => one === 'visible'));
      await person.section.getByRole('button', { name: 'torques' }).click();
      assert.equal((await lit()).filter((one) => one === 'hidden').length, 1);
      await person.press('Copy link to this state');
      await person.page.reload();
      await person.page.waitForSelector('html[data-ready]');
      assert.equal((await lit()).filter((one) => one === 'hidden').length, 1);
    }),

  'the arcs of each joint return to their start without a driving torque': (address) =>
    at(address, ID, async (person) => {
      await person.press('Play');
      await person.waits(0.6);
      await person.press('Pause');
      // The direction in which each arc begins and ends, from its path about the joint.
      const gaps = await person.section.evaluate((section) => {
        const joints = [...section.querySelectorAll('.joints circle')].map((one) => [one.cx.baseVal.value, one.cy.baseVal.value]);
        const turned = joints.map(() => []);
        for (const path of section.querySelectorAll('.torque:not(.drive)')) {
          for (const match of path.getAttribute('d').matchAll(/M(\S+) (\S+)A(\S+) \S+ 0 ([01]) ([01]) (\S+) ([^M\s]+)/g)) {
            const [x0, y0, radius, large, sweep, x1, y1] = match.slice(1).map(Number);
            // An arc belongs to the joint that it goes around.
            const off = ([cx, cy]) => Math.abs(Math.hypot(x0 - cx, y0 - cy) - radius) + Math.abs(Math.hypot(x1 - cx, y1 - cy) - radius);
            const i = joints.findIndex((joint) => off(joint) < 1e-3);
            const [cx, cy] = joints[i];
            let by = Math.atan2(-(y1 - cy), x1 - cx) - Math.atan2(-(y0 - cy), x0 - cx);
            while (by > Math.PI) by -= 2 * Math.PI;
            while (by < -Math.PI) by += 2 * Math.PI;
            if (large) by -= 2 * Math.PI * Math.sign(by);
            turned[i].push((sweep === 0) === (by > 0) ? by : by - 2 * Math.PI * Math.sign(by));
          }
        }
        return turned.map((all) => ({ sum: all.reduce((a, b) => a + b, 0), size: Math.max(0, ...all.map(Math.abs)) }));
      });
      assert.equal(gaps.length, 3);
      assert.ok(gaps.some(({ size }) => size > 0.3), 'arcs are there');
      for (const { sum } of gaps) assert.ok(Math.abs(sum) < 0.12, `${sum} rad are missing`);
    }),
};
