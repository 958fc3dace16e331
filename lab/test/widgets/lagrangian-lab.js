import { assert, at, near } from '../person.js';

const ID = 'lagrangian-lab';

export default {
  'E is constant to 1e-6 in a fall': (address) =>
    at(address, ID, async (person) => {
      near(await person.reads('E'), 17.3418, 1e-4, 'E at the start');
      await person.press('Play');
      await person.waits(2);
      await person.press('Pause');
      assert.ok((await person.reads('t')) > 1, 'it ran');
      assert.ok((await person.reads('drift')) < 1e-6, 'E stays');
      near(await person.reads('E'), 17.3418, 1e-4, 'E at the end');
    }),

  'with C q̇ off, E changes by more than 20 %': (address) =>
    at(address, ID, async (person) => {
      await person.flips('Coriolis');
      await person.types('Speed', 4);
      await person.press('Play');
      await person.waits(3);
      await person.press('Pause');
      assert.ok((await person.reads('drift')) > 0.2, `drift ${await person.reads('drift')}`);
    }),

  'the tip is dragged, and the released arm falls': (address) =>
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

  'a long step diverges with a message': (address) =>
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

  'Reset returns to the pose of the release': (address) =>
    at(address, ID, async (person) => {
      await person.drags('q2, the second joint', 90, 50);
      await person.waits(0.4);
      await person.press('Pause');
      const fallen = await person.reads('E');
      await person.press('Reset');
      near(await person.reads('t'), 0, 1e-9, 't');
      near(await person.reads('E'), fallen, 1e-3, 'the energy of the pose that was let go');
      assert.ok(Math.abs(fallen - 17.3418) > 0.5, 'which is another than at first');
      await person.press('Worked example');
      near(await person.reads('E'), 17.3418, 1e-4, 'the worked example');
    }),

  'no bar is ever full': (address) =>
    at(address, ID, async (person) => {
      await person.types('q₁, rad', 1.5);
      await person.types('q₂, rad', 0);
      await person.types('Speed', 4);
      const watch = person.page.evaluate(async () => {
        let most = 0;
        const end = performance.now() + 4000;
        while (performance.now() < end) {
          const bars = document.querySelectorAll('#lagrangian-lab .fill');
          most = Math.max(most, ...[...bars].map((bar) => Math.abs(Number(bar.dataset.share))));
          await new Promise(requestAnimationFrame);
        }
        return most;
      });
      await person.press('Play');
      const most = await watch;
      assert.ok(most > 0.6 && most < 1, `the fullest bar was at ${most}`);
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
        const shared = new URLSearchParams(person.page.url().split('?')[1]);
        const expected = {
          q1: '0.5', q2: '-1', v1: '0.25', v2: '-0.75', method: 'variational-midpoint', h: '0.002', coriolis: '0', speed: '0.5',
        };
        assert.deepEqual(Object.fromEntries(shared), expected);
        await person.press('Reset');
        near(await person.reads('q1'), 0.5, 1e-3, 'Reset goes there again');
      },
      { hash: `#${ID}?q1=0.5&q2=-1&v1=0.25&v2=-0.75&method=variational-midpoint&h=0.002&coriolis=0&speed=0.5` },
    );
  },

  'a fork follows the changed law, and the link contains it': (address) =>
    at(address, ID, async (person) => {
      const said = async () => (await person.section.locator('.fork .says').textContent()).match(/[\d.]+/g).map(Number);
      await person.press('Play');
      await person.waits(0.5);
      await person.press('Pause');
      await person.press('Fork');
      near((await said())[1], 0, 1e-9, 'both start where the arm is');
      await person.types('Speed', 2);
      await person.press('Play');
      await person.waits(1.5);
      await person.press('Pause');
      const [energy, distance] = await said();
      assert.ok(distance > 0.05, `${distance} m apart`);
      assert.ok(Math.abs(energy - 17.3418) > 0.1, `without C q̇ its energy is ${energy} J`);
      near(await person.reads('E'), 17.3418, 1e-4, 'while the arm keeps its own');
      // In one plot, at a common time: the energies of the arm and of its fork.
      await person.section.locator('.plots').evaluate((one) => one.scrollIntoView({ block: 'end', behavior: 'instant' }));
      const chart = person.section.locator('.plot', { hasText: 'Energy since the fork' });
      await chart.locator('canvas').waitFor();
      const box = await chart.locator('.u-over').boundingBox();
      await person.page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
      const energies = (await chart.locator('.legend .at').allTextContents()).map(Number);
      near(energies[0], 17.342, 2e-3, 'the arm’s energy');
      assert.ok(Math.abs(energies[1] - 17.342) > 0.05, `the fork’s energy is ${energies[1]} J`);
      const apart = person.section.locator('.plot', { hasText: 'Distance of the tips' }).locator('.legend .at');
      assert.match(await apart.textContent(), /\d/, 'the other plot is read as well');
      await person.press('Copy link to this state');
      await person.page.reload();
      await person.page.waitForSelector('html[data-ready]');
      near((await said())[1], distance, 2e-3, 'the fork is in the link');
      await person.press('End the fork');
      assert.equal(await person.section.locator('.fork .says').textContent(), '');
      await person.chooses('One law changed', 'mass');
      await person.press('Fork');
      assert.ok(Math.abs((await said())[0]) > 0.1, 'a heavier rod has an energy of its own');
    }),

  'damping removes energy and the energy balance closes; a fork without it conserves energy': (address) =>
    at(address, ID, async (person) => {
      const sentence = () => person.section.locator('.fork .says').textContent();
      await person.chooses('One law changed', 'damping');
      await person.press('Fork');
      assert.match(await sentence(), /Neither arm is damped/);
      const said = await person.section.locator('.equations math').first().textContent();
      assert.equal(said.replace(/[\s\u2061-\u2064]/g, '').normalize('NFD').replace(/\u0308|¨|˙|\u0307/g, ''), 'M(q)q+C(q,q)q+g(q)+b(q)=u');
      await person.press('End the fork');
      await person.section.getByText('Rods, gravity, damping, motors').click();
      await person.types('Damping', 2);
      await person.press('Fork');
      const forked = (await person.reads('E'));
      await person.types('Speed', 2);
      await person.press('Play');
      await person.waits(1.5);
      await person.press('Pause');
      assert.ok((await person.reads('E')) < forked - 3, 'the arm loses energy');
      assert.ok((await person.reads('drift')) < 1e-6, 'and it is accounted for');
      near(Number((await sentence()).match(/-?[\d.]+/)[0]), forked, 2e-3, 'its fork loses none');
    }),

  'ten milliseconds a single step': (address) =>
    at(address, ID, async (person) => {
      await person.press('Step');
      near(await person.reads('t'), 0.01, 1e-9, 't');
    }),
};
