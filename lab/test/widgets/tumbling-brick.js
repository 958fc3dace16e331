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

  'a long Runge–Kutta step loses energy that the other method conserves': (address) =>
    at(address, ID, async (person) => {
      await person.types('Step h', 60);
      await person.types('Speed', 4);
      for (const [method, keeps] of [['rk4', false], ['cayley', true]]) {
        await person.chooses('Step', method);
        await flipsAbout(person, 'the middle axis');
        assert.equal((await person.reads('driftK')) < 1e-10, keeps, method);
      }
    }),

  'an orientation of zeros in the address gives a message': (address) =>
    at(address, ID, async (person) => {
      assert.match(await person.section.locator('.message').textContent(), /orientation/);
      assert.ok(Math.abs((await person.reads('wy')) - 4) < 1e-3, 'the spin is taken all the same');
      await person.press('Step');
      assert.ok((await person.reads('t')) > 0, 'and the brick turns');
    }, { hash: `#${ID}?w=0&x=0&y=0&z=0&wx=0&wy=4&wz=0.1` }),

  'the link contains the views and the playback speed': (address) =>
    at(address, ID, async (person) => {
      await person.section.locator('.space').first().focus();
      await person.page.keyboard.press('ArrowRight');
      await person.types('Speed', 2);
      await person.press('Copy link to this state');
      const { page } = person;
      const shared = new URLSearchParams(page.url().split('?')[1]);
      assert.ok(Math.abs(Number(shared.get('space-azimuth')) + 1) < 1e-6, `${shared.get('space-azimuth')}`);
      assert.equal(shared.get('speed'), '2');
      const face = () => person.section.locator('.face[visibility="visible"]').first().getAttribute('d');
      const before = await face();
      await page.reload();
      await page.waitForSelector('html[data-ready]');
      assert.equal(await face(), before);
    }),

  'a swipe over the brick scrolls the page': (address) =>
    at(address, ID, async (person) => {
      const went = await person.swipes(person.section.locator('.space').first(), 250);
      assert.ok(went > 150, `the page went ${went} px`);
    }, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }),

  'the view turns by arrow keys': (address) =>
    at(address, ID, async (person) => {
      const face = () => person.section.locator('.face[visibility="visible"]').first().getAttribute('d');
      const before = await face();
      await person.section.locator('.space').first().focus();
      await person.page.keyboard.press('ArrowRight');
      assert.notEqual(await face(), before);
    }),
};
