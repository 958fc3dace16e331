import { readFileSync } from 'node:fs';

import { assert, at, near } from '../person.js';

const ID = 'your-robot';
const robots = new URL('../../../robots/', import.meta.url);

const loaded = (person, name) => person.section.getByText(`“${name}” has`).waitFor();

/** Which module of the robots the page has fetched. */
const fetched = async (person) => {
  const names = await person.page.evaluate(() => performance.getEntriesByType('resource').map((entry) => entry.name));
  return names.filter((name) => name.endsWith('.wasm') && name.includes('robots')).map((name) => (name.includes('simd128') ? 'simd128' : 'portable'));
};

/** A browser that takes no vector registers, as far as the page can see. */
const withoutRegisters = { before: () => { WebAssembly.validate = () => false; } };

export default {
  'the module for vector registers is fetched, and no other': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      assert.deepEqual(await fetched(person), ['simd128']);
    }),

  'a browser without vector registers gets a module that runs': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      assert.deepEqual(await fetched(person), ['portable']);
      await person.press('Step');
      assert.ok(Math.abs(await person.reads('off')) < 1e-2);
      assert.ok((await person.reads('t')) > 0);
    }, withoutRegisters),

  'every bundled robot loads, is drawn and falls with its books in order': (address) =>
    at(address, ID, async (person) => {
      const names = await person.section.getByLabel('Robot', { exact: true }).locator('option').evaluateAll((options) => options.map((option) => option.value));
      assert.ok(names.length >= 10);
      for (const name of names) {
        await person.chooses('Robot', name);
        await loaded(person, name);
        assert.ok((await person.section.locator('.link[visibility="visible"]').count()) > 0, name);
        await person.press('Step');
        await person.press('Play');
        await person.waits(0.4);
        await person.press('Pause');
        const t = await person.reads('t');
        assert.ok(t > 0.02, `${name} runs`);
        // Friction changes sign within a step, which costs the books the step's error: dual_arm's 0.013 J by 1.2 s. How
        // long it runs before the pause, the machine decides.
        assert.ok(Math.abs(await person.reads('off')) < 2e-2 * Math.max(1, t), `${name}: ${await person.reads('off')} J`);
      }
    }),

  'the panda weighs on its motors as it should': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      assert.equal(await person.reads('dof'), 7);
      const rows = person.section.locator('.torques tbody tr');
      assert.equal(await rows.count(), 7);
      near(Number.parseFloat((await rows.nth(0).locator('td').first().textContent()).replace('−', '-')), 0, 0.01, 'a vertical axis carries nothing');
    }),

  'motors that hold keep the pose': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await person.flips('Motors hold');
      const pose = () => person.section.getByRole('spinbutton', { name: 'panda_joint4' }).inputValue();
      const before = Number(await pose());
      await person.press('Play');
      await person.waits(1);
      await person.press('Pause');
      near(Number(await pose()), before, 0.01, 'joint 4');
    }),

  'a link is dragged and its joint follows': (address) =>
    at(address, ID, async (person) => {
      await person.chooses('Robot', 'two_r');
      await loaded(person, 'two_r');
      await person.press('Side');
      const values = () => person.section.locator('.coordinates input[type="number"]').evaluateAll((inputs) => inputs.map((input) => input.value));
      const before = await values();
      const link = person.section.locator('.link.grip[visibility="visible"]').last();
      const box = await link.boundingBox();
      await person.page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await person.page.mouse.down();
      await person.page.mouse.move(box.x + box.width / 2 + 60, box.y + box.height / 2 - 60, { steps: 8 });
      await person.page.mouse.up();
      assert.notDeepEqual(await values(), before);
    }),

  'a file is opened, and a broken one is explained': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const input = person.section.locator('input[type="file"]');
      const give = (name, text) => input.setInputFiles({ name, mimeType: 'text/xml', buffer: Buffer.from(text) });
      await give('ur5.urdf', readFileSync(new URL('ur5.urdf', robots), 'utf8').replace('name="ur5"', 'name="mine"'));
      await loaded(person, 'mine');
      assert.equal(await person.reads('dof'), 6);
      await give('broken.urdf', '<robot name="broken"><link name="a"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint></robot>');
      await person.section.getByText('This file was not loaded.').waitFor();
      assert.match(await person.section.locator('.message').first().textContent(), /line 1|joint|link/);
      assert.equal(await person.reads('dof'), 6, 'the robot before stays');
    }),

  'a file is dropped on the page': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const text = readFileSync(new URL('three_r.urdf', robots), 'utf8');
      await person.page.evaluate((content) => {
        const data = new DataTransfer();
        data.items.add(new File([content], 'three_r.urdf'));
        document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
      }, text);
      await loaded(person, 'three_r');
    }),
};
