import { assert, at, near } from '../person.js';
import { ID, loaded, shows, stage, values } from '../robots.js';

export default {
  'a four-bar linkage stays closed by every method, until its loop is switched off': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await shows(person, 'Linkage, MJCF');
      await person.section.getByText('1 closed loop or coupling and 1 actuator').waitFor();
      await person.section.getByText('Pose, joint by joint').click();
      await person.types('crank', 0.6);
      const turned = await values(person);
      // Unlike in a parallelogram, the other joints follow at different angles.
      assert.ok(Math.abs(turned[1]) > 0.05 && Math.abs(turned[2]) > 0.05, `${turned}`);
      await person.press('Play');
      await person.reaches('t', 2);
      await person.press('Pause');
      const lost = await person.reads('lost');
      assert.ok(lost > 0.01, `${lost} J lost to damping`);
      assert.ok(Math.abs(await person.reads('off')) < 1e-3 * lost + 1e-4, `${await person.reads('off')} J unaccounted for`);
      await person.section.getByText('Effects', { exact: true }).click();
      await person.flips('Closed loops');
      await person.types('coupler', turned[1] + 0.3);
      const opened = await values(person);
      near(opened[1], turned[1] + 0.3, 0.011, 'the coupler turns alone');
    }),

  'the page shows the method, its reason, and unsupported effects': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await shows(person, 'Hand, MJCF');
      const method = person.section.locator('[data-reading="method"]');
      const absent = person.section.getByRole('list', { name: 'Left out of the simulation' });
      assert.match(await method.textContent(), /^Steps by implicit: ./);
      assert.equal(await absent.isVisible(), false, 'everything acts');
      await person.section.getByText('Method and gains').click();
      await person.chooses('Method', 'rk4');
      assert.match(await method.textContent(), /^Steps by rk4/);
      assert.match(await absent.textContent(), /position limits.*“rk4”/);
      await person.section.getByText('Effects', { exact: true }).click();
      for (const effect of ['Position limits', 'Contacts between links']) {
        assert.ok(await person.section.getByRole('switch', { name: effect }).isChecked(), effect);
      }
      assert.equal(await person.section.getByRole('switch', { name: 'Effort limits' }).isVisible(), false, 'the file states none');
      // A method with its own limits cannot omit them: the previous choice stays, and the page gives the
      // reason.
      await person.chooses('Method', 'mujoco');
      await person.flips('Position limits');
      await person.section.getByText('method `mujoco` holds position limits by its law').waitFor();
      assert.match(await method.textContent(), /^Steps by mujoco/);
      assert.ok(await person.section.getByRole('switch', { name: 'Position limits' }).isChecked(), 'the switch is back');
    }),

  'a gripper lifts a box off a table by the controls of its poses, and lets it fall': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await shows(person, 'Gripper and box, MJCF');
      await loaded(person, 'gripper_and_box');
      const contacts = () => stage(person).evaluate(({ dataset }) => Number(dataset.contacts));
      const begun = await person.reads('V');
      await person.press('Play');
      await person.reaches('t', 4);
      await person.press('Pause');
      // 0.56 kg rose by 0.15 m.
      near((await person.reads('V')) - begun, 0.5609 * 9.81 * 0.15, 0.01, 'V');
      assert.equal(await contacts(), 8, 'four corners of each finger');
      await person.section.getByText('Controls of the actuators').click();
      await person.press('open');
      await person.press('Play');
      await person.reaches('t', 6);
      await person.press('Pause');
      near(await person.reads('V'), begun, 0.01, 'the box is on the table, the fingers are down');
    }, { viewport: { width: 520, height: 640 } }),
};
