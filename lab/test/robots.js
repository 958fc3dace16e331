// The actions of a user with a robot on the page.

export const ID = 'your-robot';
export const robots = new URL('../../robots/', import.meta.url);

export const loaded = (person, name) => person.section.getByText(`“${name}” has`).waitFor();

export const stage = (person) => person.section.locator('.stage');

/** Shows a robot of the gallery. */
export const shows = async (person, title) => {
  await person.press(title);
  await person.section.locator(`button[aria-pressed="true"]`, { hasText: title }).first().waitFor();
  await person.waits(0.3);
};

export const values = (person) =>
  person.section.locator('.coordinates input[type="number"]').evaluateAll((inputs) => inputs.map((input) => Number(input.value)));

export const apart = (a, b) => Math.max(...a.map((x, i) => Math.abs(x - b[i])));

/** Moves the mouse to a point of the robot that can be held, according to the page, and returns it. */
export const grip = async (person) => {
  await stage(person).evaluate((one) => one.scrollIntoView({ block: 'center', behavior: 'instant' }));
  await person.waits(0.3);
  const box = await stage(person).boundingBox();
  const places = [];
  for (let row = 0.15; row < 0.7; row += 0.05) {
    for (let column = 0.25; column < 0.8; column += 0.03) places.push([column, row]);
  }
  // From a little above the middle outwards, since the base below does not move.
  const off = ([column, row]) => Math.hypot(column - 0.5, row - 0.4);
  for (const [column, row] of places.sort((a, b) => off(a) - off(b))) {
    const at = { x: box.x + column * box.width, y: box.y + row * box.height };
    await person.page.mouse.move(at.x, at.y);
    if (await stage(person).evaluate((one) => one.classList.contains('over'))) return at;
  }
  throw new Error('nothing of the robot can be held');
};

/** Drops files on the page, by path. */
export const give = (person, files) =>
  person.page.evaluate((all) => {
    const data = new DataTransfer();
    for (const [path, content] of Object.entries(all)) data.items.add(new File([content], path.replace(/^.*\//, '')));
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
  }, files);

/** The modules for robots that the page has loaded. */
export const fetched = async (person) => {
  const names = await person.page.evaluate(() => performance.getEntriesByType('resource').map((entry) => entry.name));
  const modules = names.filter((name) => name.endsWith('.wasm') && name.includes('robots'));
  return modules.map((name) => (name.includes('simd128') ? 'simd128' : 'portable'));
};

/** A browser without vector registers, as far as the page can tell. */
export const withoutRegisters = { before: () => { WebAssembly.validate = () => false; } };
