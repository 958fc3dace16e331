import { assert, at } from '../person.js';

export default {
  'every answer comes with its number': (address) =>
    at(address, 'predict-first', async (person) => {
      const cards = person.section.locator('.cards > li');
      const rights = ['3', '1', '3', 'long along q̇₂', 'drifts far away', 'grows', 'fourfold'];
      assert.equal(await cards.count(), rights.length);
      for (const [i, right] of rights.entries()) {
        await cards.nth(i).getByRole('button', { name: right, exact: true }).click();
        assert.equal(await cards.nth(i).locator('.verdict').textContent(), 'Yes.');
        assert.ok((await cards.nth(i).locator('.because').textContent()).length > 20);
      }
      assert.match(await cards.nth(0).locator('.because').textContent(), /3\.0000/);
      assert.match(await cards.nth(1).locator('.because').textContent(), /1\.0000/);
      assert.match(await cards.nth(3).locator('.because').textContent(), /1\.7\d\d|1\.\d\d\d/);
      assert.match(await person.section.locator('.score').textContent(), /7 of 7 answered, 7 right/);
    }),

  'a wrong answer is told the right one, and counts': (address) =>
    at(address, 'predict-first', async (person) => {
      await person.section.locator('.cards > li').first().getByRole('button', { name: '4', exact: true }).click();
      assert.match(await person.section.locator('.verdict').first().textContent(), /No: 3/);
      assert.match(await person.section.locator('.score').textContent(), /1 of 7 answered, 0 right/);
    }),
};
