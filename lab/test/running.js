// Experiments in motion, for what is asked of a frame.
export const RUNNING = [
  'opening', 'replay', 'lagrangian-lab', 'tumbling-brick', 'knife-edge', 'workbench', 'integrator-race', 'flip-map', 'your-robot',
];

/** Sets an experiment going, once it is there and drawn. */
export async function setGoing(person, id) {
  if (id === 'your-robot') await person.section.getByText('“panda” has').waitFor();
  // While the map is computed it is drawn, too.
  if (id === 'flip-map') await person.page.waitForSelector('.flips[data-share="1.0000"]');
  await person.press('Play');
  await person.waits(1);
}

/** Sets a humanoid going, and waits until it lies on the ground. */
export async function layDown(person) {
  await person.section.getByText('“panda” has').waitFor();
  await person.press('Humanoid');
  await person.section.getByText('“humanoid” has').waitFor();
  await person.types('Speed', 4);
  await person.press('Play');
  await person.reaches('t', 4);
}

/** Reads one of Chromium's counts of what a page has done; times are the main thread's own on its processor, so that other programs on
 * this machine count little. */
export async function reader(page, name) {
  const tools = await page.context().newCDPSession(page);
  await tools.send('Performance.enable', { timeDomain: 'threadTicks' });
  return async () => {
    const { metrics } = await tools.send('Performance.getMetrics');
    return metrics.find((metric) => metric.name === name).value;
  };
}

/** Lets frames pass, and says how many seconds they took. */
export const passFrames = (page, count) =>
  page.evaluate(async (frames) => {
    const start = performance.now();
    for (let passed = 0; passed < frames; passed += 1) await new Promise(requestAnimationFrame);
    return (performance.now() - start) / 1000;
  }, count);
