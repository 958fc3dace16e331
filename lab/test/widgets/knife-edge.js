import { assert, at, near } from '../person.js';

const ID = 'knife-edge';

export default {
  'A q̇ stays zero while it drives': (address) =>
    at(address, ID, async (person) => {
      await person.press('Play');
      await person.drags('Drive pad', 30, -40);
      await person.waits(1);
      await person.types('Side push', 6);
      await person.waits(1);
      await person.press('Pause');
      assert.ok((await person.reads('t')) > 1.5);
      assert.ok(Math.abs(await person.reads('slip')) < 1e-12, 'no slip');
      assert.ok(Math.abs(await person.reads('lambda')) > 3, 'the floor pushes back');
      assert.ok(Math.abs(await person.reads('off')) < 1e-6, 'the energy is accounted for');
    }),

  'coasting in a circle the floor supplies m v θ̇': (address) =>
    at(address, ID, async (person) => {
      near(await person.reads('lambda'), -2.4, 1e-3, 'λ = −2 · 1.5 · 0.8');
      await person.press('Play');
      await person.waits(1);
      await person.press('Pause');
      near(await person.reads('lambda'), -2.4, 1e-3, 'and it stays');
      near(await person.reads('v'), 1.5, 1e-3, 'at the same speed');
    }),

  'with opposite wheel forces it turns on the spot': (address) =>
    at(address, ID, async (person) => {
      await person.press('Turn on the spot');
      await person.waits(1);
      await person.press('Pause');
      assert.ok((await person.reads('turn')) > 0.3);
      near(await person.reads('v'), 0, 1e-3, 'forward speed');
      near(await person.reads('lambda'), 0, 1e-3, 'λ');
    }),

  'the pad is driven by keys': (address) =>
    at(address, ID, async (person) => {
      await person.keys('Drive pad', 'ArrowUp', 4);
      const entry = (name) => person.section.getByRole('spinbutton', { name }).inputValue();
      assert.equal(Number(await entry('Left wheel')), 1);
      assert.equal(Number(await entry('Right wheel')), 1);
      await person.keys('Drive pad', 'ArrowRight', 2);
      assert.equal(Number(await entry('Left wheel')), 1.5);
      assert.equal(Number(await entry('Right wheel')), 0.5);
    }),
};
