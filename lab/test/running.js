// Experiments in motion, for the frame limits.
export const RUNNING = [
  'opening', 'replay', 'lagrangian-lab', 'tumbling-brick', 'knife-edge', 'workbench', 'integrator-race', 'flip-map', 'your-robot',
];

/** Starts an experiment once it is loaded and drawn. */
export async function setGoing(person, id) {
  if (id === 'your-robot') await person.section.getByText('“panda” has').waitFor();
  // While the map is computed it is also drawn.
  if (id === 'flip-map') await person.page.waitForSelector('.flips[data-share="1.0000"]');
  await person.press('Play');
  await person.waits(1);
}

/** Starts a humanoid, and waits until it lies on the ground. */
export async function layDown(person) {
  await person.section.getByText('“panda” has').waitFor();
  await person.press('Humanoid');
  await person.section.getByText('“humanoid” has').waitFor();
  await person.types('Speed', 4);
  await person.press('Play');
  await person.reaches('t', 4);
}

/** Reads one of Chromium's performance counters. Times are processor times of the main thread, on which other
 * programs have little effect. */
export async function reader(page, name) {
  const tools = await page.context().newCDPSession(page);
  await tools.send('Performance.enable', { timeDomain: 'threadTicks' });
  return async () => {
    const { metrics } = await tools.send('Performance.getMetrics');
    return metrics.find((metric) => metric.name === name).value;
  };
}

/** Waits for frames, and returns how many seconds they took. */
export const passFrames = (page, count) =>
  page.evaluate(async (frames) => {
    const start = performance.now();
    for (let passed = 0; passed < frames; passed += 1) await new Promise(requestAnimationFrame);
    return (performance.now() - start) / 1000;
  }, count);
