// Opens published robots on the page, folder by folder, and checks that each is drawn completely and runs.
//
//     node test/published.js [--floating] [--seconds 10] FOLDER...
//
// Each folder is a robot package with URDF and MJCF files and their meshes. This is not a test; it prints a
// table.
import { basename } from 'node:path';
import { parseArgs } from 'node:util';

import { closeBrowser, openPage, serve } from './browser.js';
import { asNumber } from './person.js';

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { floating: { type: 'boolean', default: false }, seconds: { type: 'string', default: '10' } },
});
const seconds = Number(values.seconds);
/** Time limit for loading a robot, and for its run [ms]. */
const PATIENCE = 120_000;

const server = await serve();
const counts = { whole: 0, refused: 0, other: 0 };
console.log('| robot | parts | reach in the picture | ran | unaccounted for | said |\n| --- | ---: | ---: | ---: | ---: | --- |');
for (const folder of positionals) {
  const { page, faults, close } = await openPage(server.address, {
    viewport: { width: 520, height: 640 }, reducedMotion: 'reduce', hash: '#your-robot',
  });
  const section = page.locator('#your-robot');
  const message = () => section.locator('.message').allTextContents().then((all) => all.filter((text) => text !== '').join(' '));
  const shown = () => section.getAttribute('data-shown');
  const reads = async (key) => asNumber(await section.locator(`[data-reading="${key}"]`).textContent());
  /** Opens a robot, and waits until it is shown or rejected. */
  const after = async (open) => {
    await page.evaluate(() => { delete document.querySelector('#your-robot').dataset.shown; });
    await open();
    const end = Date.now() + PATIENCE;
    while (Date.now() < end && (await shown()) === null && (await message()) === '') await page.waitForTimeout(100);
    return (await shown()) !== null;
  };
  try {
    await section.getByText('“panda” has').waitFor();
    await section.getByText('Method and gains').click();
    if (values.floating) await section.getByRole('switch', { name: 'Base floats' }).click();
    const opens = [['', () => section.getByLabel('A folder with a robot').setInputFiles(folder)]];
    // The first offers the others.
    for (let next = 0; next < opens.length; next += 1) {
      const ready = await after(opens[next][1]);
      if (next === 0) {
        const others = section.getByRole('toolbar', { name: 'Robots in this folder' }).getByRole('button');
        const titles = await others.allTextContents();
        opens[0][0] = titles[0] ?? '';
        titles.slice(1).forEach((title, i) => { opens.push([title, () => others.nth(i + 1).click()]); });
      }
      const [name] = opens[next];
      const title = `${basename(folder)}${name === '' ? '' : `/${name}`}`;
      if (!ready) {
        counts.refused += 1;
        console.log(`| ${title} | - | - | - | - | ${(await message()).slice(0, 160)} |`);
      } else {
        const { parts, spread } = await section.locator('.stage').evaluate(({ dataset }) => dataset);
        await section.getByRole('spinbutton', { name: 'Speed' }).fill('4');
        await section.getByRole('spinbutton', { name: 'Speed' }).press('Tab');
        await section.getByRole('button', { name: 'Play', exact: true }).click();
        const end = Date.now() + PATIENCE;
        while (Date.now() < end && (await reads('t')) < seconds && (await message()) === '') await page.waitForTimeout(200);
        const [t, off, said] = [await reads('t'), await section.locator('[data-reading="off"]').textContent(), await message()];
        const pause = section.getByRole('button', { name: 'Pause', exact: true });
        if (await pause.isVisible()) await pause.click();
        const isWhole = Number(spread) <= 1 && Number(parts) > 0 && t >= seconds && said === '';
        counts[isWhole ? 'whole' : 'other'] += 1;
        console.log(`| ${title} | ${parts} | ${Number(spread).toFixed(2)} | ${t.toFixed(1)} s | ${off} J | ${said.slice(0, 160)} |`);
      }
    }
    for (const fault of new Set(faults)) console.log(`${folder}: ${fault}`);
  } catch (error) {
    counts.other += 1;
    console.log(`${folder}: ${error.message.split('\n')[0]}`);
  }
  await close();
}
console.log(`${counts.whole} drawn whole and run without a complaint, ${counts.refused} refused, ${counts.other} others`);
await closeBrowser();
await server.close();
