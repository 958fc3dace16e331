import { assert, at, near } from '../person.js';

const ID = 'lagrangian-lab';

export default {
  'E keeps its line to 1e-6 in a fall': (address) =>
    at(address, ID, async (person) => {
      near(await person.reads('E'), 17.3418, 1e-4, 'E at the start');
      await person.press('Play');
      await person.waits(2);
      await person.press('Pause');
      assert.ok((await person.reads('t')) > 1, 'it ran');
      assert.ok((await person.reads('drift')) < 1e-6, 'E stays');
      near(await person.reads('E'), 17.3418, 1e-4, 'E at the end');
    }),

  'with C q̇ off, E leaves its line by more than 20 %': (address) =>
    at(address, ID, async (person) => {
      await person.flips('Coriolis');
      await person.types('Speed', 4);
      await person.press('Play');
      await person.waits(3);
      await person.press('Pause');
      assert.ok((await person.reads('drift')) > 0.2, `drift ${await person.reads('drift')}`);
    }),

  'the tip is dragged, the arm falls when let go': (address) =>
    at(address, ID, async (person) => {
      await person.drags('q2, the second joint', 120, 60);
      await person.waits(0.5);
      await person.press('Pause');
      assert.ok((await person.reads('t')) > 0.1, 'it falls');
      assert.ok(Math.abs((await person.reads('E')) - 17.3418) > 0.5, 'from another pose');
    }),

  'arrow keys turn a joint by five degrees each': (address) =>
    at(address, ID, async (person) => {
      await person.keys('q1, the first joint', 'ArrowRight', 3);
      near(await person.reads('q1'), Math.PI / 4 + Math.PI / 12, 1e-3, 'q1');
      assert.equal(await person.handle('q1, the first joint').getAttribute('aria-valuetext'), '1.047 rad');
    }),

  'a touch drags too': (address) =>
    at(
      address,
      ID,
      async (person) => {
        const handle = person.handle('q1, the first joint');
        await handle.scrollIntoViewIfNeeded();
        const box = await handle.boundingBox();
        assert.ok(Math.min(box.width, box.height) >= 24, `a finger finds it: ${box.width} px`);
        await person.touches('q1, the first joint', -40, 10);
        await person.waits(0.3);
        await person.press('Pause');
        assert.ok((await person.reads('t')) > 0.05, 'it falls when let go');
        assert.ok(Math.abs((await person.reads('E')) - 17.3418) > 0.5, 'from another pose');
      },
      { viewport: { width: 390, height: 844 }, hasTouch: true },
    ),

  'a step too long blows up with a plain message': (address) =>
    at(address, ID, async (person) => {
      await person.chooses('Integrator', 'explicit-euler');
      await person.types('Step h', 50);
      await person.types('Speed', 4);
      await person.press('Play');
      await person.waits(6);
      const text = await person.section.locator('.message').textContent();
      if (text !== '') assert.match(text, /smaller step/);
      assert.ok(text !== '' || (await person.reads('drift')) > 0.1, 'it fails or is far off');
    }),

  'the address restores state and parameters': async (address) => {
    await at(
      address,
      ID,
      async (person) => {
        near(await person.reads('q1'), 0.5, 1e-3, 'q1');
        near(await person.reads('q2'), -1, 1e-3, 'q2');
        assert.equal(await person.section.getByLabel('Integrator').inputValue(), 'variational-midpoint');
        await person.press('Copy link to this state');
        assert.match(person.page.url(), /#lagrangian-lab\?q1=0\.5&q2=-1&.*method=variational-midpoint/);
      },
      { hash: `#${ID}?q1=0.5&q2=-1&method=variational-midpoint&h=0.002` },
    );
  },

  'ten milliseconds a single step': (address) =>
    at(address, ID, async (person) => {
      await person.press('Step');
      near(await person.reads('t'), 0.01, 1e-9, 't');
    }),

  'physics costs less than 2 ms a frame': (address) =>
    at(address, ID, async (person) => {
      await person.press('Play');
      await person.waits(2.5);
      const cost = Number(await person.section.locator('.transport').getAttribute('data-physics-ms'));
      assert.ok(cost > 0 && cost < 2, `${cost} ms`);
    }),
};
