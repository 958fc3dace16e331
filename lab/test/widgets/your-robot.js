import { readFile } from 'node:fs/promises';

import { asOnACard } from '../browser.js';
import { asNumber, assert, at, near } from '../person.js';
import { apart, grip, ID, loaded, shows, stage, values } from '../robots.js';

const sum = async (person, names) => {
  let total = 0;
  for (const name of names) total += await person.reads(name);
  return total;
};

export default {
  'every bundled robot loads, is drawn and falls with its energy balanced': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const names = await person.section.getByRole('toolbar', { name: 'Robots' }).getByRole('button').allTextContents();
      assert.ok(names.length >= 14);
      await person.section.getByText('Method and gains').click();
      for (const name of names) {
        await shows(person, name);
        const { parts, spread } = await stage(person).evaluate(({ dataset }) => dataset);
        assert.ok(Number(parts) > 2, `${name}: ${parts} parts`);
        assert.ok(Number(spread) > 0.6 && Number(spread) <= 1, `${name} reaches to ${spread} of the picture`);
        await person.types('Step h', 0.5);
        await person.press('Step');
        await person.press('Play');
        await person.waits(0.3);
        await person.press('Pause');
        const t = await person.reads('t');
        assert.ok(t > 0.02, `${name} runs`);
        // The distance depends on the machine: on a fast one the humanoid falls and lands with 400 J. The
        // method is of order 2, and repeats a step whose energy error is above a thousandth.
        const through = await sum(person, ['K', 'lost', 'friction', 'stops', 'sliding', 'impacts']);
        const off = Math.abs(await person.reads('off'));
        assert.ok(off < 1e-3 * through + 1e-3, `${name}: ${off} J of ${through} J`);
      }
    }, { viewport: { width: 520, height: 640 } }),

  'the motors carry the weight of the panda': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      assert.equal(await person.reads('dof'), 7);
      const rows = person.section.locator('.torques tbody tr');
      assert.equal(await rows.count(), 7);
      const looks = async () => {
        await rows.nth(0).scrollIntoViewIfNeeded();
        await person.waits(0.3);
      };
      await looks();
      const term = async (row, name) => asNumber(await rows.nth(row).locator(`[data-term="${name}"]`).textContent());
      near(await term(0, 'gravity'), 0, 0.01, 'a vertical axis carries nothing');
      assert.equal(await rows.nth(1).locator('[data-term="inertial"]').textContent(), '–', 'it has not moved');

      // The columns are the equation of motion.
      await person.flips('Motors hold the pose');
      await person.press('Step');
      await looks();
      near(await term(1, 'applied'), await term(1, 'gravity'), 0.011, 'motors carry the arm');
      await person.flips('Motors hold the pose');
      await person.press('Reset');
      await person.press('Play');
      await person.waits(0.2);
      await person.press('Pause');
      await looks();
      for (let row = 0; row < 7; row += 1) {
        const [inertial, coriolis, gravity] = [await term(row, 'inertial'), await term(row, 'coriolis'), await term(row, 'gravity')];
        near(inertial + coriolis + gravity, (await term(row, 'applied')) + (await term(row, 'rest')), 0.03, `joint ${row + 1}`);
      }
    }),

  'links glow by a term of the equation of motion, and the brightest joint is named': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const by = person.section.getByLabel('Links glow by');
      const bright = async () => Number(await stage(person).evaluate(({ dataset }) => dataset.brightest));
      const said = () => person.section.locator('[data-reading="brightest"]').textContent();
      await by.selectOption('gravity');
      assert.equal(await bright(), 1);
      await person.section.locator('.torques').scrollIntoViewIfNeeded();
      await person.waits(0.3);
      const weights = await person.section.locator('[data-term="gravity"]').allTextContents();
      near(asNumber(await said()), Math.max(...weights.map((text) => Math.abs(asNumber(text)))), 0.06, 'the largest of g');
      assert.match(await said(), /panda_joint[24]$/);
      await by.selectOption('coriolis');
      assert.equal(await bright(), 0, 'nothing moves');
      assert.equal(await said(), 'no joint is loaded');
      await person.press('Copy link to this state');
      assert.match(person.page.url(), /glow=coriolis/);
      await by.selectOption('off');
      assert.ok(!(await person.section.locator('.glow-key').isVisible()));
    }),

  'motors hold the pose': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await person.flips('Motors hold');
      await person.section.getByText('Pose, joint by joint').click();
      const pose = () => person.section.getByRole('spinbutton', { name: 'panda_joint4' }).inputValue();
      const before = Number(await pose());
      await person.press('Play');
      await person.waits(1);
      await person.press('Pause');
      near(Number(await pose()), before, 0.01, 'joint 4');
    }),

  'a link is dragged and its joint follows': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await person.section.getByText('Pose, joint by joint').click();
      const before = await values(person);
      const link = await grip(person);
      await person.page.mouse.down();
      await person.page.mouse.move(link.x + 40, link.y + 30, { steps: 8 });
      await person.page.mouse.up();
      const after = await values(person);
      assert.ok(apart(before, after) > 0.1, `${apart(before, after)} rad`);
      assert.equal(await person.reads('t'), 0);
      assert.equal(await person.reads('K'), 0);
      await person.press('Step');
      await person.press('Reset');
      assert.ok(apart(after, await values(person)) < 0.011, 'Reset goes back to where it was let go');
    }),

  'while the robot runs, a spring pulls a link, and the energy balance contains its work': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await person.flips('Motors hold');
      await person.press('Play');
      const link = await grip(person);
      await person.page.mouse.down();
      await person.page.mouse.move(link.x + 60, link.y - 40, { steps: 8 });
      // Read while the link is held: when it is released, the motors return the energy.
      await person.reaches('work', 1);
      await person.page.mouse.up();
      await person.press('Pause');
      assert.ok(Math.abs(await person.reads('off')) < 2e-2, `${await person.reads('off')} J from nowhere`);
    }, { viewport: { width: 520, height: 640 } }),

  'a finger on the robot holds it, one beside it scrolls the page': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const before = await person.section.locator('[data-reading="V"]').textContent();
      const link = await grip(person);
      assert.equal(await person.swipesFrom(link, 120), 0, 'the page stays');
      assert.notEqual(await person.section.locator('[data-reading="V"]').textContent(), before, 'the robot moves');
      const box = await stage(person).boundingBox();
      const went = await person.swipesFrom({ x: box.x + 12, y: box.y + box.height - 12 }, 200);
      assert.ok(went > 100, `the page goes, ${went} px`);
    }, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }),

  'joints stop at their limits, and the losses are shown': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await person.section.getByText('Pose, joint by joint').click();
      await person.types('Speed', 4);
      await person.press('Play');
      await person.reaches('t', 2);
      await person.press('Pause');
      for (const entry of await person.section.locator('.coordinates input[type="number"]').all()) {
        const [value, min, max] = await entry.evaluate((one) => [one.value, one.min, one.max].map(Number));
        assert.ok(value >= min - 1e-3 && value <= max + 1e-3, `${value} of ${min} to ${max}`);
      }
      assert.ok((await person.reads('stops')) > 0.1, `${await person.reads('stops')} J`);
    }),

  'a floating robot falls on the ground and stays, and falls on without ground': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await shows(person, 'Quadruped');
      const contacts = () => stage(person).evaluate(({ dataset }) => Number(dataset.contacts));
      assert.ok(await person.section.getByRole('switch', { name: 'Base floats freely' }).isChecked(), 'it can fall');
      await person.section.getByText('Method and gains').click();
      assert.equal(await contacts(), 0, 'it begins in the air');
      await person.types('Speed', 4);
      await person.press('Play');
      await person.reaches('t', 5);
      await person.press('Pause');
      const height = await person.reads('V');
      assert.ok((await person.reads('impacts')) > 1, `${await person.reads('impacts')} J went into the ground`);
      assert.ok((await person.reads('K')) < 1e-3, 'it lies still');
      assert.ok((await contacts()) >= 3, `${await contacts()} contacts`);
      assert.ok(Math.abs(await person.reads('off')) < 0.05, `${await person.reads('off')} J from nowhere`);
      await person.flips('Ground');
      await person.press('Play');
      await person.reaches('t', (await person.reads('t')) + 2);
      await person.press('Pause');
      assert.ok((await person.reads('V')) < height - 100, 'without ground it falls on');
      assert.equal(await contacts(), 0);
    }, { viewport: { width: 520, height: 640 } }),

  'the camera follows an arm that leaves the picture, unless the user chose the distance': (address) =>
    at(address, ID, async (person) => {
      await person.section.getByText('“panda” has').waitFor();
      const distance = async () => {
        await person.press('Copy link to this state');
        return Number(new URLSearchParams(person.page.url().split('?').at(-1)).get('distance'));
      };
      const outermost = () => person.section.locator('.stage').getAttribute('data-outermost').then(Number);
      const begun = await distance();
      await person.types('Speed', 4);
      await person.press('Play');
      // Without a graphics card frames are few, and the camera moves a little in each.
      await person.reaches('t', 12);
      await person.press('Pause');
      assert.ok((await outermost()) <= 0.9, `a link is at ${await outermost()} of the picture's half`);
      assert.ok((await distance()) > 1.05 * begun, `${await distance()} m away, ${begun} m at first`);
      await person.press('Fit');
      await person.section.locator('.stage').focus();
      for (let k = 0; k < 8; k += 1) await person.page.keyboard.press('+');
      const chosen = await distance();
      await person.press('Play');
      await person.waits(2);
      await person.press('Pause');
      assert.ok((await outermost()) > 0.9, 'so near, it is not all in sight');
      assert.ok(Math.abs((await distance()) - chosen) < 1e-9, 'and stays as near as it was put');
    }),

  'a video is recorded and saved': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await person.press('Play');
      await person.press('Record a video');
      await person.waits(2);
      const [file] = await Promise.all([person.page.waitForEvent('download'), person.press('End the video')]);
      assert.match(file.suggestedFilename(), /^panda\.(webm|mp4)$/);
      const bytes = await readFile(await file.path());
      assert.ok(bytes.length > 5000, `${bytes.length} bytes`);
      // The first bytes of every Matroska file.
      if (file.suggestedFilename().endsWith('webm')) assert.equal(bytes.subarray(0, 4).toString('hex'), '1a45dfa3');
    }, { viewport: { width: 520, height: 640 } }),

  'edges are smooth and shadows fall where a graphics card draws': async (address) => {
    const seen = [];
    for (const before of [asOnACard, undefined]) {
      await at(address, ID, async (person) => {
        await loaded(person, 'panda');
        seen.push(await stage(person).evaluate((one) => ({
          triangles: Number(one.dataset.triangles),
          isSmooth: one.querySelector('canvas').getContext('webgl2').getContextAttributes().antialias,
        })));
      }, { before, viewport: { width: 520, height: 640 } });
    }
    const [card, processor] = seen;
    assert.ok(card.isSmooth && !processor.isSmooth);
    assert.ok(card.triangles > 1.5 * processor.triangles, `${card.triangles}, of which ${processor.triangles} are seen`);
  },

  'a browser without WebGL gets a flat drawing that the user can drag': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await shows(person, 'Two rods');
      await person.section.getByText('Pose, joint by joint').click();
      assert.equal(await stage(person).count(), 0);
      await person.press('Side');
      const before = await values(person);
      const link = person.section.locator('.link.grip[visibility="visible"]').last();
      const box = await link.boundingBox();
      await person.page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await person.page.mouse.down();
      await person.page.mouse.move(box.x + box.width / 2 + 60, box.y + box.height / 2 - 60, { steps: 8 });
      await person.page.mouse.up();
      assert.ok(apart(before, await values(person)) > 0.1);
    }, { before: () => { HTMLCanvasElement.prototype.getContext = ((get) => function (kind, ...rest) {
      return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest);
    })(HTMLCanvasElement.prototype.getContext); }, quiet: /WebGL/ }),
};
