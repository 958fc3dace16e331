import { assert, at, near } from '../person.js';

const ID = 'workbench';

async function overshoot(person, pose) {
  await person.press(pose);
  await person.waits(0.2);
  await person.press('Pause');
  return { m11: await person.reads('m11'), zeta: await person.reads('zeta'), over: await person.reads('overshoot') };
}

export default {
  'gains without overshoot for the folded arm oscillate for the stretched one': (address) =>
    at(address, ID, async (person) => {
      const folded = await overshoot(person, 'Folded');
      const stretched = await overshoot(person, 'Stretched');
      near(folded.m11, 1, 1e-3, 'M11 folded');
      near(stretched.m11, 3, 1e-3, 'M11 stretched');
      near(folded.zeta / stretched.zeta, Math.sqrt(3), 0.03, 'ζ falls with the root of M11');
      // Both start 0.3 rad from the waypoint.
      assert.ok(folded.over < 0.05 * 0.3, `crisp: ${folded.over} rad`);
      assert.ok(stretched.over > 0.12 * 0.3, `rings: ${stretched.over} rad`);
    }),

  'the arm settles at its waypoint, and the peak is reported': (address) =>
    at(address, ID, async (person) => {
      await person.types('Speed', 4);
      await person.press('Folded');
      await person.waits(2);
      await person.press('Pause');
      assert.ok((await person.reads('peak1')) > 1 && (await person.reads('peak1')) <= 20);
      assert.ok((await person.reads('settles')) < 3);
    }),

  'a limit below the weight gives a message': (address) =>
    at(address, ID, async (person) => {
      await person.press('Sideways');
      await person.press('Pause');
      assert.match(await person.section.locator('.message[role="status"]').textContent(), /Joint 1 cannot carry/);
      await person.types('Limit 1', 40);
      assert.equal(await person.section.locator('.message[role="status"]').textContent(), '');
    }),

  'the waypoint is dragged and nudged': (address) =>
    at(address, ID, async (person) => {
      await person.keys('Waypoint of joint 2', 'ArrowUp', 6);
      assert.equal(await person.handle('Waypoint of joint 2').getAttribute('aria-valuetext'), '0.524 rad');
      await person.drags('Waypoint of joint 1', 80, 0);
      assert.notEqual(await person.handle('Waypoint of joint 1').getAttribute('aria-valuetext'), '1.571 rad');
    }),
};
