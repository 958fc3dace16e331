// Common properties of plots: a cursor for a group, a timeline, downloads.
import { readFile } from 'node:fs/promises';

import { assert, at, near } from '../person.js';

const ID = 'lagrangian-lab';

const ran = async (person) => {
  await person.press('Play');
  await person.waits(1.2);
  await person.press('Pause');
  await person.section.locator('.plot').first().evaluate((one) => one.scrollIntoView({ block: 'center', behavior: 'instant' }));
  await person.waits(0.4);
};

const values = (person) => person.section.locator('.legend .at').allTextContents();

const saved = async (person, name) => {
  const [file] = await Promise.all([person.page.waitForEvent('download'), person.press(name)]);
  return { name: file.suggestedFilename(), content: await readFile(await file.path()) };
};

export default {
  'the pointer over one plot reads all of them': (address) =>
    at(address, ID, async (person) => {
      await ran(person);
      assert.ok((await values(person)).every((text) => text === ''));
      const canvas = person.section.locator('.plot canvas').first();
      const box = await canvas.boundingBox();
      await person.page.mouse.move(box.x + 0.6 * box.width, box.y + 0.5 * box.height);
      const [K, V, E, error] = (await values(person)).map((text) => Number(text.replace('−', '-')));
      near(K + V, E, 2e-3, 'K + V = E under the cursor');
      near(E, 17.3418, 1e-3, 'E');
      assert.ok(Number.isNaN(error) || error < 1e-6, 'the other plot is read as well');
      await person.page.mouse.move(5, 5);
      assert.ok((await values(person)).every((text) => text === ''));
    }),

  'the timeline shows the arm as it was': (address) =>
    at(address, ID, async (person) => {
      await ran(person);
      const timeline = person.section.getByRole('slider', { name: 'Timeline' });
      await timeline.evaluate((range) => {
        range.value = '0';
        range.dispatchEvent(new Event('input', { bubbles: true }));
      });
      const then = person.section.locator('.links.thin.muted');
      assert.equal(await then.evaluate((one) => one.parentElement.getAttribute('visibility')), 'visible');
      // The start: q = (π/4, π/2), so the elbow is at (0.7071, 0.7071).
      assert.match(await then.getAttribute('d'), /^M0 0L0\.7071 -0\.7071L0 -1\.4142/);
      await timeline.focus();
      await timeline.press('End');
      assert.equal(await then.evaluate((one) => one.parentElement.getAttribute('visibility')), 'hidden');
    }),

  'a robot’s energy and the distance of two pendulums come as CSV, too': async (address) => {
    for (const [id, head] of [['your-robot', 't [s],K [J],V [J],E [J]'], ['flip-map', 't [s],distance [m]']]) {
      await at(address, id, async (person) => {
        if (id === 'your-robot') await person.section.getByText('“panda” has').waitFor();
        await ran(person);
        const { name, content } = await saved(person, 'CSV');
        assert.equal(name, `${id}.csv`);
        const [first, ...rows] = content.toString().trim().split('\n');
        assert.equal(first, head);
        assert.ok(rows.length > 10 && rows.every((row) => row.split(',').every((x) => Number.isFinite(Number(x)))), `${rows.length} rows`);
        assert.ok(await person.section.getByRole('slider', { name: 'Timeline' }).isVisible());
      });
    }
  },

  'the plots’ numbers come as CSV, and their picture as PNG': (address) =>
    at(address, ID, async (person) => {
      await ran(person);
      const csv = await saved(person, 'CSV');
      assert.equal(csv.name, 'lagrangian-lab.csv');
      const [head, ...rows] = csv.content.toString().trimEnd().split('\n');
      assert.equal(head, 't [s],energy error,K [J],V [J],E [J]');
      assert.ok(rows.length > 50, `${rows.length} rows`);
      for (const row of rows) {
        const [, error, K, V, E] = row.split(',').map(Number);
        near(K + V, E, 1e-9, row);
        assert.ok(error < 1e-6);
      }
      const png = await saved(person, 'PNG');
      assert.equal(png.name, 'lagrangian-lab.png');
      assert.equal(png.content.subarray(1, 4).toString(), 'PNG');
      assert.ok(png.content.length > 3000, `${png.content.length} bytes`);
    }),

  'the plots are recorded as a video while they move': (address) =>
    at(address, ID, async (person) => {
      await ran(person);
      await person.press('Video');
      await person.press('Play');
      await person.waits(2);
      const video = await saved(person, 'End the video');
      assert.match(video.name, /^lagrangian-lab\.(webm|mp4)$/);
      assert.ok(video.content.length > 5000, `${video.content.length} bytes`);
      // It plays, and has the shape of the picture.
      const shape = await person.page.evaluate(async (bytes) => {
        const player = document.createElement('video');
        player.src = URL.createObjectURL(new Blob([Uint8Array.from(bytes)]));
        await new Promise((resolve, reject) => {
          player.onloadeddata = resolve;
          player.onerror = () => { reject(new Error('it does not play')); };
        });
        return [player.videoWidth, player.videoHeight];
      }, [...video.content]);
      assert.ok(shape[0] > 200 && shape[1] > 200, `${shape}`);
      assert.equal(await person.section.getByRole('button', { name: 'Video', exact: true }).getAttribute('aria-pressed'), 'false');
    }),
};
