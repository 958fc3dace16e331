// The page in a second browser engine: Firefox from Debian, driven over WebDriver BiDi.
import assert from 'node:assert/strict';

import { launch } from 'puppeteer-core';

import { serve } from './browser.js';
import { asNumber, near } from './person.js';

const server = await serve();
// The window's default size, which not every Firefox can change.
const browser = await launch({
  browser: 'firefox', executablePath: '/usr/bin/firefox-esr', headless: true, defaultViewport: null, args: ['--width=1000', '--height=880'],
});
const faults = [];

/** Opens the page, and asserts that it logs nothing and requests nothing from elsewhere. */
async function open(hash) {
  const page = await browser.newPage();
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('console', (message) => {
    // Without a graphics card there is no WebGL, and the page uses its flat drawing.
    if (message.type() === 'error' && !/WebGL/.test(message.text())) faults.push(message.text());
  });
  page.on('request', (request) => {
    if (!request.url().startsWith(server.address) && !/^(data|blob):/.test(request.url())) faults.push(`left the page: ${request.url()}`);
  });
  await page.goto(server.address + hash);
  await page.waitForSelector('html[data-ready]');
  const inside = (id) => ({
    reads: (key) => page.$eval(`#${id} [data-reading="${key}"]`, (one) => one.textContent).then(asNumber),
    press: async (name) => {
      const button = await page.waitForSelector(`#${id} ::-p-aria([name="${name}"][role="button"])`);
      await button.click();
    },
  });
  return { page, inside };
}
/** Scrolls to an element until it stays, since elements on the way get their layout and move it. */
async function scrollsTo(page, selector, isSo) {
  for (let tries = 0; tries < 300 && !(await page.$eval(selector, isSo)); tries += 1) {
    await page.$eval(selector, (one) => { one.scrollIntoView(); });
    await wait(0.2);
  }
}
const wait = (seconds) => new Promise((resolve) => { setTimeout(resolve, 1000 * seconds); });

const cases = {
  'all self-checks hold': async () => {
    const { page } = await open('#self-checks');
    await scrollsTo(page, '#self-checks', (panel) => panel.dataset.failed !== undefined);
    const rows = await page.$$eval('#self-checks tbody tr', (all) => all.map((row) => row.className));
    assert.ok(rows.length >= 10, `${rows.length} checks`);
    assert.ok(rows.every((name) => !name.includes('failed')));
    await page.close();
  },
  'the errors at the end of the race are in the expected ranges': async () => {
    const { page, inside } = await open('#integrator-race');
    await inside('integrator-race').press('Play');
    await page.waitForFunction(() => document.querySelector('#integrator-race [data-reading="time"]').textContent.startsWith('600.0 s'),
      { timeout: 60_000 });
    const drifts = await page.$$eval('#integrator-race tbody td:nth-child(2)', (all) => all.map((one) => one.textContent));
    const [explicit, , rk4, midpoint] = drifts.map(asNumber);
    assert.ok(explicit > 0.1 && rk4 < 1e-5 && midpoint < 1e-2);
    await page.close();
  },
  'a slider moves the Lagrangian lab': async () => {
    const { page } = await open('#lagrangian-lab');
    const slider = await page.waitForSelector('#lagrangian-lab input[type="range"]');
    const before = await page.$eval('#lagrangian-lab', (one) => one.textContent);
    await slider.focus();
    for (let k = 0; k < 5; k += 1) await page.keyboard.press('ArrowRight');
    await wait(0.3);
    assert.notEqual(await page.$eval('#lagrangian-lab', (one) => one.textContent), before);
    await page.close();
  },
  'the map of flips is computed by workers': async () => {
    const { page } = await open('#flip-map');
    await scrollsTo(page, '.flips', (map) => Number(map.dataset.coarse) > 0);
    assert.ok((await page.$eval('.flips', (map) => Number(map.dataset.rate))) > 1e6);
    await page.close();
  },
  'the mass of the panda is correct, and its energy is balanced in a fall': async () => {
    const { page, inside } = await open('#your-robot');
    const robot = inside('your-robot');
    await page.waitForSelector('#your-robot[data-shown="panda"]', { timeout: 60_000 });
    near(await robot.reads('dof'), 7, 0, 'degrees of freedom');
    await robot.press('Play');
    await wait(2);
    await robot.press('Pause');
    assert.ok((await robot.reads('t')) > 0.1);
    assert.ok(Math.abs(await robot.reads('off')) < 0.05);
    await page.close();
  },
  'a quadruped falls on the ground': async () => {
    const { page, inside } = await open('#your-robot?robot=quadruped&floating=1');
    const robot = inside('your-robot');
    await page.waitForSelector('#your-robot[data-shown="quadruped"]', { timeout: 60_000 });
    await robot.press('Play');
    const end = Date.now() + 60_000;
    while (Date.now() < end && (await robot.reads('t')) < 1.5) await wait(0.2);
    await robot.press('Pause');
    assert.ok((await robot.reads('impacts')) > 1, `${await robot.reads('impacts')} J`);
    await page.close();
  },
};

let failures = 0;
for (const [name, run] of Object.entries(cases)) {
  const start = Date.now();
  try {
    await run();
    assert.deepEqual(faults.splice(0), []);
    console.log(`ok      firefox: ${name} (${Date.now() - start} ms)`);
  } catch (error) {
    failures += 1;
    console.log(`FAILED  firefox: ${name}\n${error.stack}`);
  }
}
await browser.close();
await server.close();
if (failures > 0) process.exit(1);
