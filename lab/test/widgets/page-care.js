// Properties of the whole page: formulas drawn completely, cost of frames, keyboard access, stable links.
import { gzipSync } from 'node:zlib';

import { openPage } from '../browser.js';
import { assert, at, opened } from '../person.js';
import { layDown, passFrames, reader, RUNNING, setGoing } from '../running.js';

// The browser computes layout at most once a frame by itself; reading a changed element forces more.
const LAYOUTS = 1.1;
/** Number of observed frames: pictures change in each, plots in every third or fourth, numbers in every
 * sixth. */
const FRAMES = 120;
/** Limits of the mean drawing work of a frame, in canvas calls and changes of the document. They are 1.5
 * times the measured work, or twice if workers determine it. The race's worker delivers for a quarter to
 * three quarters of the frames, depending on the machine. A delivery changes 12 things once, so a frame
 * changes at most 12. */
const DRAWN = {
  opening: { calls: 0, changes: 60 },
  replay: { calls: 0, changes: 15 },
  'lagrangian-lab': { calls: 0, changes: 42 },
  'tumbling-brick': { calls: 0, changes: 27 },
  'knife-edge': { calls: 0, changes: 14 },
  workbench: { calls: 0, changes: 5 },
  'integrator-race': { calls: 900, changes: 18 },
  'flip-map': { calls: 110, changes: 14 },
  'your-robot': { calls: 220, changes: 10 },
};

const cases = {
  'all texts are in place before the physics is loaded, within 150 kB': async (address) => {
    const { page, close } = await openPage(address, { ready: 'nav', before: () => { window.fetch = () => new Promise(() => undefined); } });
    let bytes = 0;
    page.on('response', (response) => {
      const body = response.body().then((text) => { bytes += gzipSync(text, { level: 9 }).length; });
      bodies.push(body);
    });
    const bodies = [];
    await page.reload();
    await page.waitForSelector('nav');
    await page.waitForLoadState('networkidle');
    await Promise.all(bodies);
    assert.equal(await page.locator('nav a').count(), 12);
    assert.match(await page.locator('h1').textContent(), /Robot dynamics lab/);
    assert.equal(await page.locator('button', { hasText: 'Play' }).count(), 0, 'the experiments wait for their physics');
    const sections = await page.$$eval('main > section', (all) => all.map((one) => {
      one.scrollIntoView({ behavior: 'instant' });
      const seen = (part) => one.querySelector(part)?.checkVisibility() && one.querySelector(part).textContent.length > 3;
      return { height: one.getBoundingClientRect().height, words: seen('h2') && seen('.lede') };
    }));
    assert.equal(sections.length, 11);
    assert.ok(sections.every(({ height, words }) => words && height > 400), JSON.stringify(sections));
    assert.equal(await page.locator('.passage .sheet').count(), 6, 'what asks for predictions is there');
    console.log(`        ${(bytes / 1000).toFixed(0)} kB`);
    assert.ok(bytes > 20_000 && bytes < 150_000, `${bytes} bytes`);
    await close();
  },

  'no text moves when the physics is loaded': async (address) => {
    for (const viewport of [{ width: 1280, height: 900 }, { width: 390, height: 844 }]) {
      const before = () => {
        const fetched = window.fetch.bind(window);
        const asked = new Promise((resolve) => { window.comes = resolve; });
        window.fetch = (...what) => asked.then(() => fetched(...what));
        new PerformanceObserver((list) => {
          window.moved = (window.moved ?? 0) + list.getEntries().reduce((sum, { value }) => sum + value, 0);
        }).observe({ type: 'layout-shift', buffered: true });
      };
      const { page, close } = await openPage(address, { ready: 'main', before, viewport, reducedMotion: 'reduce' });
      await page.waitForTimeout(500);
      await page.evaluate(() => { window.comes(); });
      await page.waitForSelector('html[data-ready]');
      await page.waitForTimeout(700);
      const moved = await page.evaluate(() => window.moved ?? 0);
      console.log(`        ${viewport.width} px: ${moved.toFixed(3)} of the window`);
      // Browsers call a shift below a tenth good.
      assert.ok(moved < 0.1, `${moved}`);
      await close();
    }
  },

  'every formula is drawn with the page’s font, including dots': (address) =>
    opened(address, {}, async (page) => {
      await page.evaluate(() => document.fonts.ready);
      const tools = await page.context().newCDPSession(page);
      await tools.send('DOM.enable');
      await tools.send('CSS.enable');
      // All of them, visible or not.
      await page.addStyleTag({ content: '.widget { content-visibility: visible } .equations[hidden] { display: block }' });
      const { root } = await tools.send('DOM.getDocument', { depth: 0 });
      const { nodeIds } = await tools.send('DOM.querySelectorAll', { nodeId: root.nodeId, selector: '.equations :is(mi, mo, mn, mtext)' });
      assert.ok(nodeIds.length > 300);
      let glyphs = 0;
      for (const nodeId of nodeIds) {
        const { fonts } = await tools.send('CSS.getPlatformFontsForNode', { nodeId });
        for (const { familyName, isCustomFont, glyphCount } of fonts) {
          assert.ok(isCustomFont, `${glyphCount} glyphs come from ${familyName}, which another machine may not have`);
          glyphs += glyphCount;
        }
      }
      assert.ok(glyphs > 400, `${glyphs} glyphs`);
      // q̈ is taller than q.
      const [dotted, plain] = await page.evaluate(() => {
        const over = document.querySelector('.equations mover');
        return [over.getBoundingClientRect().height, over.firstElementChild.getBoundingClientRect().height];
      });
      assert.ok(dotted > 1.15 * plain, `${dotted} px over ${plain} px`);
    }),

  'a keyboard passes every experiment in two stops': (address) =>
    opened(address, {}, async (page) => {
      await page.keyboard.press('Tab');
      await page.keyboard.press('Enter');
      const heading = () => page.evaluate(() => document.activeElement?.closest('section')?.id ?? document.activeElement?.tagName);
      const ids = await page.$$eval('main > section', (sections) => sections.map(({ id }) => id));
      assert.equal(await heading(), ids[0]);
      for (const [i, id] of ids.slice(0, -1).entries()) {
        // From a heading back to the link past its experiment.
        await page.keyboard.press('Shift+Tab');
        assert.match(await page.evaluate(() => document.activeElement.textContent), /^Skip/, id);
        await page.keyboard.press('Enter');
        assert.equal(await heading(), ids[i + 1]);
      }
    }),

  'there are few stops, and arrow keys go within a row of buttons': (address) =>
    opened(address, { hash: '#your-robot' }, async (page) => {
      await page.getByText('“panda” has').waitFor();
      const stops = await page.evaluate(() => {
        const all = [...document.querySelectorAll('a[href], button, input, select, summary, [tabindex]')];
        const last = document.querySelector('#integrator-race');
        const isBefore = (one) => one.compareDocumentPosition(last) === Node.DOCUMENT_POSITION_FOLLOWING;
        return all.filter((one) => one.tabIndex >= 0 && !one.disabled && one.checkVisibility() && isBefore(one)).length;
      });
      console.log(`        ${stops} stops before the last experiment`);
      assert.ok(stops <= 105, `${stops}`);
      const row = page.getByRole('toolbar', { name: 'Waypoints' });
      await row.getByRole('button').first().focus();
      await page.keyboard.press('ArrowRight');
      assert.equal(await page.evaluate(() => document.activeElement.textContent), 'Stretched');
      assert.equal(await row.locator('button[tabindex="0"]').count(), 1);
    }),

  'no text before a question of Predict first answers it': (address) =>
    opened(address, {}, async (page) => {
      const before = await page.evaluate(() => {
        const range = document.createRange();
        range.setStart(document.body, 0);
        range.setEndBefore(document.querySelector('#predict-first .cards'));
        return range.toString();
      });
      const answers = [/four times|fourfold/, /leaves its line/, /3, 2, 1/, /long along/, /grow/];
      for (const answer of answers) assert.doesNotMatch(before, answer);
    }),

  'an address leads to its experiment, on a phone too': async (address) => {
    for (const viewport of [{ width: 1280, height: 900 }, { width: 390, height: 844 }]) {
      for (const id of ['knife-edge', 'your-robot']) {
        await opened(address, { hash: `#${id}`, viewport }, async (page) => {
          await page.waitForTimeout(700);
          const { top, bottom } = await page.locator(`#${id}`).evaluate((one) => one.getBoundingClientRect().toJSON());
          assert.ok(top < 0.5 * viewport.height && bottom > 0.5 * viewport.height, `${id} is at ${top} to ${bottom}`);
        });
      }
    }
  },

  'an invalid address has no effect': async (address) => {
    for (const hash of [
      '#tumbling-brick?w=0&x=0&y=0&z=0', '#lagrangian-lab?q1=1e400&h=-5&method=none', '#knife-edge?v=NaN&drag=-3',
      '#workbench?kp1=-1&to1=abc', '#replay?turn=-7.25&times=99', '#integrator-race?h=0&duration=-1', '#your-robot?file=%25&q0=x',
    ]) {
      await opened(address, { hash }, async (page) => {
        await page.waitForTimeout(200);
        assert.ok((await page.locator('section.widget').count()) > 8, hash);
      });
    }
  },
};

/** Counts drawing operations: calls of a canvas, of its paths or of WebGL, and changes of the document. Runs
 * in the page. */
const countDrawing = () => {
  const drawn = { calls: 0, changes: 0 };
  for (const kind of [CanvasRenderingContext2D, Path2D, WebGL2RenderingContext]) {
    for (const [name, { value }] of Object.entries(Object.getOwnPropertyDescriptors(kind.prototype))) {
      if (typeof value !== 'function' || name === 'constructor') continue;
      kind.prototype[name] = function counted(...all) {
        drawn.calls += 1;
        return value.apply(this, all);
      };
    }
  }
  const changes = { attributes: true, characterData: true, childList: true, subtree: true };
  new MutationObserver((records) => { drawn.changes += records.length; }).observe(document, changes);
  globalThis.drawn = drawn;
};

/** The drawing operations so far, and the number of layouts. */
const drawing = async (page) => {
  const layouts = await reader(page, 'LayoutCount');
  return async () => [await layouts(), ...(await page.evaluate(() => [drawn.calls, drawn.changes]))];
};

for (const id of RUNNING) {
  cases[`a frame asks for no layout, and draws no more than it needs (${id})`] = (address) =>
    at(address, id, async (person) => {
      await setGoing(person, id);
      const read = await drawing(person.page);
      const before = await read();
      await passFrames(person.page, FRAMES);
      const after = await read();
      const [layouts, calls, changes] = after.map((value, i) => (value - before[i]) / FRAMES);
      console.log(`        a frame: ${layouts.toFixed(2)} layouts, ${calls.toFixed(0)} calls, ${changes.toFixed(1)} changes`);
      assert.ok(layouts < LAYOUTS, `${layouts} layouts a frame`);
      assert.ok(calls <= DRAWN[id].calls, `${calls} calls a frame`);
      assert.ok(changes <= DRAWN[id].changes, `${changes} changes a frame`);
    }, { before: countDrawing });
}

cases['a humanoid lies on the ground, on many contacts'] = (address) =>
  at(address, 'your-robot', async (person) => {
    await layDown(person);
    const contacts = Number(await person.section.locator('.stage').getAttribute('data-contacts'));
    assert.ok(contacts >= 3, `${contacts} contacts`);
  });

export default cases;
