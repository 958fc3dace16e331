import { assert, at } from '../person.js';

const ID = 'integrator-race';

const drifts = async (person) => {
  const { asNumber } = await import('../person.js');
  return (await person.section.locator('tbody td:nth-child(2)').allTextContents()).map(asNumber);
};

export default {
  'after ten simulated minutes the drift of each method is in its expected range': (address) =>
    at(address, ID, async (person) => {
      await person.press('Play');
      await person.section.getByRole('button', { name: 'Play', exact: true }).waitFor({ timeout: 60_000 });
      assert.match(await person.section.locator('[data-reading="time"]').textContent(), /^600\.0 s of 600 s/);
      const [explicit, semi, rk4, midpoint] = await drifts(person);
      assert.ok(explicit > 0.1 && semi > 0.1, 'the Euler methods are far off');
      assert.ok(rk4 < 1e-5 && midpoint < 1e-2, 'the others are not');
    }),

  'with a long step a runner drops out with a message': (address) =>
    at(address, ID, async (person) => {
      await person.types('Step h', 50);
      await person.press('Play');
      await person.section.getByRole('button', { name: 'Play', exact: true }).waitFor({ timeout: 30_000 });
      const [explicit, , rk4] = await drifts(person);
      assert.ok(explicit > 0.3 && rk4 > 1e-4);
      for (const fate of await person.section.locator('tbody td:nth-child(3)').allTextContents()) {
        if (fate.startsWith('dropped out')) assert.match(fate, /smaller step/);
      }
    }),

  'a single step is a thousand of them': (address) =>
    at(address, ID, async (person) => {
      await person.press('Step');
      await person.section.getByText(/^1\.0 s of 600 s/).waitFor();
      await person.press('Step');
      await person.section.getByText(/^2\.0 s of 600 s/).waitFor();
      await person.press('Reset');
      await person.section.getByText(/^0\.0 s of 600 s/).waitFor();
      assert.ok((await drifts(person)).every((drift) => drift === 0));
    }),
};
