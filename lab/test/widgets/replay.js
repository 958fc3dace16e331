import { assert, at, near } from '../person.js';

const pegged = (person) =>
  person.section.locator('.gauge').evaluateAll((gauges) => gauges.map((gauge) => gauge.dataset.pegged === 'true'));

export default {
  'at 1× both gauges stay within their limits, at 2× both are at their stops': (address) =>
    at(address, 'replay', async (person) => {
      assert.deepEqual(await pegged(person), [false, false]);
      near(await person.reads('peak1'), 8.5, 0.1, 'peak of joint 1 at 1×');
      await person.press('2×');
      assert.deepEqual(await pegged(person), [true, true]);
      near(await person.reads('peak1'), 49.7, 0.1, 'peak of joint 1 at 2×');
      near(await person.reads('peak2'), 18.9, 0.1, 'peak of joint 2 at 2×');
      await person.press('1×');
      assert.deepEqual(await pegged(person), [false, false]);
    }),

  'the slider finds the fastest speed inside the limits': (address) =>
    at(address, 'replay', async (person) => {
      const fastest = await person.reads('fastest');
      assert.ok(fastest > 1 && fastest < 2);
      await person.types('Replay at', fastest - 0.02);
      assert.deepEqual(await pegged(person), [false, false]);
      await person.types('Replay at', fastest + 0.02);
      assert.ok((await pegged(person)).some(Boolean));
    }),

  'the needle never covers its number': (address) =>
    at(address, 'replay', async (person) => {
      await person.press('2×');
      const gap = () => person.section.locator('.gauge svg').evaluateAll((dials) => Math.min(...dials.map((dial) => {
        // The needle's end at full scale on either side, relative to the top of the number, in the dial's
        // units.
        const reach = 0.82 * Math.cos(0.25 * Math.PI);
        return dial.querySelector('.value').getBBox().y - reach;
      })));
      assert.ok((await gap()) > 0.1, `${await gap()}`);
      const inside = await person.section.locator('.gauge svg').evaluateAll((dials) => dials.every((dial) => {
        const [box, number] = [dial.viewBox.baseVal, dial.querySelector('.value').getBBox()];
        return number.y + number.height <= box.y + box.height;
      }));
      assert.ok(inside, 'and the number is in the picture');
    }),

  'the arm goes round its loop': (address) =>
    at(address, 'replay', async (person) => {
      const place = () => person.section.locator('.plane .links').getAttribute('d');
      const before = await place();
      await person.press('Play');
      await person.waits(0.6);
      await person.press('Pause');
      assert.notEqual(await place(), before);
    }),
};
