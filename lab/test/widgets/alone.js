import { strict as assert } from 'node:assert';

import { openPage } from '../browser.js';

export default {
  'an address shows one experiment alone, as the guide does': async (address) => {
    const { page, faults, close } = await openPage(address, { hash: '?only=knife-edge', reducedMotion: 'reduce' });
    const shown = await page.evaluate(() => [...document.querySelectorAll('.widget')].map((widget) => widget.id));
    assert.deepEqual(shown, ['knife-edge']);
    assert.equal(await page.locator('.masthead').count(), 0);
    await page.getByRole('button', { name: 'Play' }).click();
    assert.deepEqual(faults, []);
    await close();
  },

  'an address with an unknown experiment shows all': async (address) => {
    const { page, close } = await openPage(address, { hash: '?only=nothing' });
    assert.equal(await page.locator('.masthead').count(), 1);
    await close();
  },
};
