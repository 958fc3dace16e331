import { assert, at, near } from '../person.js';

const ID = 'inertia-ellipse';

export default {
  'M11 reads 3, 2, 1': (address) =>
    at(address, ID, async (person) => {
      await person.press('Nothing');
      for (const [pose, m11] of [['q₂ = 0', 3], ['q₂ = π/2', 2], ['q₂ = π', 1]]) {
        await person.press(pose);
        near(await person.reads('m11'), m11, 1e-3, pose);
      }
    }),

  'the semi-axes of the worked example are 1.928 and 0.696': (address) =>
    at(address, ID, async (person) => {
      await person.press('Nothing');
      near(await person.reads('long'), 1.928, 5e-4, 'longer');
      near(await person.reads('short'), 0.696, 5e-4, 'shorter');
    }),

  'moving q1 changes nothing, by slider and by dragging': (address) =>
    at(address, ID, async (person) => {
      const all = async () => Promise.all(['m11', 'm12', 'm22', 'long', 'short'].map((key) => person.reads(key)));
      await person.press('Nothing');
      const before = await all();
      await person.types('q₁, rad', -1.2);
      assert.deepEqual(await all(), before);
      await person.drags('q1, the first joint', 60, 40);
      assert.ok(Math.abs((await person.reads('q1')) + 1.2) > 0.05, 'it was dragged');
      assert.deepEqual(await all(), before);
    }),

  'the question comes before the answer': (address) =>
    at(address, ID, async (person) => {
      const heard = async () => (await person.section.ariaSnapshot()).replace(/\s+/g, ' ');
      const secrets = ['turns the arm without changing', 'The inertia ellipse in the plane', 'condition of M', 'semi-axis', 'M₁₁'];
      const before = await heard();
      for (const secret of secrets) assert.ok(!before.includes(secret), `a screen reader hears “${secret}” before the answer`);
      assert.equal(await person.section.locator('ellipse').isVisible(), false);
      await person.press('It grows and shrinks');
      assert.match(await person.section.locator('.verdict').textContent(), /No: Nothing/);
      const after = await heard();
      for (const secret of secrets) assert.ok(after.includes(secret), `“${secret}” comes with the answer`);
      assert.equal(await person.section.locator('ellipse').isVisible(), true);
    }),

  'the ellipse stays in its frame in every pose': (address) =>
    at(address, ID, async (person) => {
      await person.press('Nothing');
      let longest = 0;
      for (let q2 = -3.14; q2 < 3.15; q2 += 0.157) {
        await person.types('q₂, rad', q2.toFixed(3));
        const gap = await person.section.locator('.velocities').evaluate((frame) => {
          const [outer, inner] = [frame.getBoundingClientRect(), frame.querySelector('ellipse').getBoundingClientRect()];
          return Math.min(inner.left - outer.left, inner.top - outer.top, outer.right - inner.right, outer.bottom - inner.bottom);
        });
        assert.ok(gap >= 0, `it sticks out by ${-gap} px at q₂ = ${q2}`);
        longest = Math.max(longest, await person.reads('long'));
      }
      near(longest, 3.25, 0.02, 'the longest semi-axis, at q₂ = 0');
    }),
};
