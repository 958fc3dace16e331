import { assert, at, near } from '../person.js';

const ID = 'inertia-ellipse';

export default {
  'M11 reads 3, 2, 1': (address) =>
    at(address, ID, async (person) => {
      for (const [pose, m11] of [['q₂ = 0', 3], ['q₂ = π/2', 2], ['q₂ = π', 1]]) {
        await person.press(pose);
        near(await person.reads('m11'), m11, 1e-3, pose);
      }
    }),

  'the semi-axes of the worked example are 1.928 and 0.696': (address) =>
    at(address, ID, async (person) => {
      near(await person.reads('long'), 1.928, 5e-4, 'longer');
      near(await person.reads('short'), 0.696, 5e-4, 'shorter');
    }),

  'moving q1 changes nothing, by slider and by dragging': (address) =>
    at(address, ID, async (person) => {
      const all = async () => Promise.all(['m11', 'm12', 'm22', 'long', 'short'].map((key) => person.reads(key)));
      const before = await all();
      await person.types('q₁, rad', -1.2);
      assert.deepEqual(await all(), before);
      await person.drags('q1, the first joint', 60, 40);
      assert.ok(Math.abs((await person.reads('q1')) + 1.2) > 0.05, 'it was dragged');
      assert.deepEqual(await all(), before);
    }),

  'the question comes before the answer': (address) =>
    at(address, ID, async (person) => {
      assert.equal(await person.section.locator('.veiled').count(), 2);
      await person.press('It grows and shrinks');
      assert.match(await person.section.locator('.verdict').textContent(), /No: Nothing/);
      assert.equal(await person.section.locator('.veiled').count(), 0);
    }),
};
