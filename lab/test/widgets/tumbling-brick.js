import { assert, at } from '../person.js';

const ID = 'tumbling-brick';

async function flipsAbout(person, axis) {
  await person.press(`About ${axis}`);
  await person.waits(4);
  await person.press('Pause');
  return person.reads('flips');
}

export default {
  'it flips about the middle axis and about no other': (address) =>
    at(address, ID, async (person) => {
      await person.types('Speed', 4);
      assert.equal(await flipsAbout(person, 'the long axis'), 0);
      assert.equal(await flipsAbout(person, 'the short axis'), 0);
      assert.ok((await flipsAbout(person, 'the middle axis')) >= 2);
      assert.ok((await person.reads('driftL')) < 1e-11, 'L stays');
      assert.ok((await person.reads('driftK')) < 1e-11, 'K stays');
    }),

  'a long Runge–Kutta step loses the energy that the other keeps': (address) =>
    at(address, ID, async (person) => {
      await person.types('Step h', 60);
      await person.types('Speed', 4);
      for (const [method, keeps] of [['rk4', false], ['cayley', true]]) {
        await person.chooses('Step', method);
        await flipsAbout(person, 'the middle axis');
        assert.equal((await person.reads('driftK')) < 1e-10, keeps, method);
      }
    }),

  'the view turns by arrow keys': (address) =>
    at(address, ID, async (person) => {
      const face = () => person.section.locator('.face[visibility="visible"]').first().getAttribute('d');
      const before = await face();
      await person.section.locator('.space').first().focus();
      await person.page.keyboard.press('ArrowRight');
      assert.notEqual(await face(), before);
    }),
};
