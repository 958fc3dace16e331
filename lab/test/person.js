// The actions of a user: read numbers, drag, press keys, type, switch.
import assert from 'node:assert/strict';

import { openPage } from './browser.js';

/** Opens the page at one experiment with reduced motion, runs the case, and asserts that no error occurred.
 */
export async function at(address, id, run, options = {}) {
  const { page, faults, close } = await openPage(address, { reducedMotion: 'reduce', hash: `#${id}`, ...options });
  try {
    const section = page.locator(`#${id}`);
    await section.scrollIntoViewIfNeeded();
    await run(new Person(page, section));
    assert.deepEqual(faults.filter((fault) => !options.quiet?.test(fault)), []);
  } finally {
    await close();
  }
}

/** Opens the whole page with reduced motion, runs the case, and asserts that no error occurred. */
export async function opened(address, options, run) {
  const { page, faults, close } = await openPage(address, { reducedMotion: 'reduce', ...options });
  try {
    await run(page);
    assert.deepEqual(faults, []);
  } finally {
    await close();
  }
}

export class Person {
  constructor(page, section) {
    this.page = page;
    this.section = section;
  }

  /** The displayed number with this key. */
  async reads(key) {
    const text = await this.section.locator(`[data-reading="${key}"]`).textContent();
    return asNumber(text);
  }

  /** Waits until a reading has reached a value; the time depends on the machine. */
  async reaches(key, value, seconds = 60) {
    const end = Date.now() + 1000 * seconds;
    while (!((await this.reads(key)) >= value)) {
      assert.ok(Date.now() < end, `${key} is ${await this.reads(key)} after ${seconds} s, not ${value}`);
      await this.waits(0.1);
    }
  }

  press(name) {
    return this.section.getByRole('button', { name, exact: true }).click();
  }

  async types(label, value) {
    const entry = this.section.getByRole('spinbutton', { name: label });
    await entry.fill(String(value));
    await entry.press('Tab');
  }

  chooses(label, option) {
    return this.section.getByLabel(label, { exact: true }).selectOption(option);
  }

  flips(label) {
    return this.section.getByRole('switch', { name: label }).click();
  }

  handle(label) {
    return this.section.getByRole('slider', { name: label });
  }

  /** Drags a handle by this many pixels. */
  async drags(label, dx, dy) {
    const handle = this.handle(label);
    await handle.scrollIntoViewIfNeeded();
    const box = await handle.boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await this.page.mouse.move(x, y);
    await this.page.mouse.down();
    await this.page.mouse.move(x + dx / 2, y + dy / 2, { steps: 4 });
    await this.page.mouse.move(x + dx, y + dy, { steps: 4 });
    await this.page.mouse.up();
  }

  /** Drags with a finger. */
  async touches(label, dx, dy) {
    const handle = this.handle(label);
    await handle.scrollIntoViewIfNeeded();
    const box = await handle.boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const finger = await this.page.context().newCDPSession(this.page);
    const points = (at) => (at === undefined ? [] : [{ x: x + at * dx, y: y + at * dy }]);
    const send = (type, at) => finger.send('Input.dispatchTouchEvent', { type, touchPoints: points(at) });
    await send('touchStart', 0);
    for (const at of [0.25, 0.5, 0.75, 1]) await send('touchMove', at);
    await send('touchEnd');
  }

  /** Swipes up by pixels with a finger from the middle of an element. Returns the scrolled distance. */
  async swipes(element, up) {
    await element.evaluate((one) => one.scrollIntoView({ block: 'center', behavior: 'instant' }));
    const box = await element.boundingBox();
    return this.swipesFrom({ x: box.x + box.width / 2, y: box.y + box.height / 2 }, up);
  }

  /** Swipes up from a point of the screen. */
  async swipesFrom({ x, y }, up) {
    const scrolled = () => this.page.evaluate(() => scrollY);
    const before = await scrolled();
    const finger = await this.page.context().newCDPSession(this.page);
    await finger.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x, y }] });
    for (let share = 0.1; share < 1.05; share += 0.1) {
      await finger.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: [{ x, y: y - share * up }] });
      await this.page.waitForTimeout(16);
    }
    await finger.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
    await this.waits(0.4);
    return (await scrolled()) - before;
  }

  async keys(label, key, times) {
    const handle = this.handle(label);
    await handle.focus();
    for (let i = 0; i < times; i += 1) await handle.press(key);
  }

  /** Waits in real time. */
  waits(seconds) {
    return this.page.waitForTimeout(1000 * seconds);
  }
}

/** Parses 1.2·10⁻⁸ and −3.4. */
export function asNumber(text) {
  const plain = text
    .replace(/−/g, '-')
    .replace(/·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)/, (_, raised) =>
      `e${Array.from(raised, (c) => (c === '⁻' ? '-' : '⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(c))).join('')}`);
  return Number.parseFloat(plain);
}

export function near(found, expected, tolerance, what) {
  assert.ok(Math.abs(found - expected) <= tolerance, `${what}: found ${found}, expected ${expected} ± ${tolerance}`);
}

export { assert };
