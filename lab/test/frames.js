// A benchmark of the built page in Chromium: processor time of the main thread for a frame, the race, and the
// map of flips.
import { closeBrowser, serve } from './browser.js';
import { at } from './person.js';
import { layDown, passFrames, reader, RUNNING, setGoing } from './running.js';

/** Slow-down to a phone's processor, as browsers' tools define it. */
const PHONE = 4;
/** Limits of main-thread time for a frame [ms]: 4, so that a phone keeps 60 frames a second, and 8 for
 * robots. */
const BUDGET = 4;
const BUDGETS = { 'your-robot': 8 };
const FRAMES = 180;

const server = await serve();
for (const id of RUNNING) await at(server.address, id, (person) => report(person, id));
await at(server.address, 'your-robot', reportHumanoid);
await at(server.address, 'integrator-race', reportRace);
await at(server.address, 'flip-map', reportMap);
await closeBrowser();
await server.close();

async function report(person, id) {
  await setGoing(person, id);
  const busy = await busyTime(person.page);
  const before = await busy();
  const seconds = await passFrames(person.page, FRAMES);
  const cost = ((await busy()) - before) / FRAMES;
  const budget = BUDGETS[id] ?? BUDGET;
  const rate = (FRAMES / seconds).toFixed(0);
  const transport = person.section.locator('.transport[data-physics-ms]');
  const isShown = (await transport.count()) > 0;
  const physics = isShown ? `, physics ${Number(await transport.getAttribute('data-physics-ms')).toFixed(2)}` : '';
  console.log(`${id.padEnd(16)} ${cost.toFixed(2)} ms a frame of ${budget}${physics}, ${(PHONE * cost).toFixed(1)} on a phone; `
    + `${rate} frames a second here`);
}

/** The cost of a frame at 60 per second: drawing, and a sixtieth of a second of motion. A slow machine has
 * fewer frames with more motion in each, so runs at two speeds separate the two. */
async function reportHumanoid(person) {
  await layDown(person);
  const busy = await busyTime(person.page);
  const runs = [];
  for (const speed of [0.05, 1]) {
    await person.types('Speed', speed);
    await person.waits(0.5);
    const [from, time] = [await busy(), await person.reads('t')];
    await passFrames(person.page, FRAMES);
    runs.push({ cost: ((await busy()) - from) / FRAMES, motion: ((await person.reads('t')) - time) / FRAMES });
  }
  const [slow, usual] = runs;
  const second = (usual.cost - slow.cost) / (usual.motion - slow.motion);
  const drawing = slow.cost - second * slow.motion;
  const contacts = await person.section.locator('.stage').getAttribute('data-contacts');
  const frame = drawing + second / 60;
  console.log(`a humanoid on the ground, ${contacts} contacts: ${frame.toFixed(2)} ms a frame of ${BUDGETS['your-robot']} at 60 a second: `
    + `to draw it ${drawing.toFixed(2)}, a second of its motion ${second.toFixed(0)}`);
}

async function reportRace(person) {
  const start = Date.now();
  await person.press('Play');
  await person.section.getByRole('button', { name: 'Play', exact: true }).waitFor({ timeout: 60_000 });
  console.log(`ten minutes of the race in ${((Date.now() - start) / 1000).toFixed(1)} s`);
}

async function reportMap(person) {
  const map = person.section.locator('.flips[data-share="1.0000"]');
  await map.waitFor({ timeout: 60_000 });
  const data = async (name) => Number(await map.getAttribute(`data-${name}`));
  const rate = (await data('rate')) / 1e6;
  console.log(`the map of flips: coarse in ${(await data('coarse')).toFixed(2)} s, ${rate.toFixed(0)} million steps a second`);
}

/** The milliseconds that the main thread was busy. */
async function busyTime(page) {
  const read = await reader(page, 'TaskDuration');
  return async () => 1000 * (await read());
}
