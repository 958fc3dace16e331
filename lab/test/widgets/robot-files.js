import { readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';

import { assert, at, near } from '../person.js';
import { fetched, give, ID, loaded, robots, shows, stage, withoutRegisters } from '../robots.js';

export default {
  'the module for vector registers is fetched, and no other': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      assert.deepEqual(await fetched(person), ['simd128']);
    }),

  'a browser without vector registers gets a module that runs': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      assert.deepEqual(await fetched(person), ['portable']);
      await person.press('Step');
      assert.ok(Math.abs(await person.reads('off')) < 1e-2);
      assert.ok((await person.reads('t')) > 0);
    }, withoutRegisters),

  'the link contains motion, motors, camera and layers': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      await shows(person, 'UR5');
      await person.press('Play');
      await person.waits(0.5);
      await person.press('Pause');
      await person.flips('Motors hold');
      await person.flips('Inertia');
      await stage(person).press('ArrowRight');
      await person.types('Speed', 0.5);
      await person.press('Copy link to this state');
      const given = new URLSearchParams(person.page.url().split('?')[1]);
      assert.ok(Math.abs(Number(given.get('v1'))) > 1e-3, 'velocities');
      const expected = { robot: 'ur5', hold: '1', inertia: '1', speed: '0.5', azimuth: '-0.8', method: 'auto' };
      for (const [name, value] of Object.entries(expected)) assert.equal(given.get(name), value, name);
      await person.page.reload();
      await person.page.waitForSelector('html[data-ready]');
      await loaded(person, 'ur5');
      await person.waits(0.5);
      await person.press('Copy link to this state');
      const again = new URLSearchParams(person.page.url().split('?')[1]);
      for (const [name, value] of given) {
        const [a, b] = [Number(value), Number(again.get(name))];
        if (Number.isFinite(a)) near(b, a, 1e-5 * Math.max(1, Math.abs(a)), name);
        else assert.equal(again.get(name), value, name);
      }
    }),

  'a scene shows the robot that it includes, with the inertia of its meshes': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const robot = '<mujoco model="rod"><asset><mesh name="rock" file="rock.obj"/></asset><worldbody>'
        + '<body><joint axis="0 1 0"/><geom type="mesh" mesh="rock"/></body></worldbody></mujoco>';
      const rock = 'v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n';
      const scene = '<mujoco model="scene"><include file="rod.xml"/></mujoco>';
      await give(person, { 'a-scene.xml': scene, 'rod.xml': robot, 'rock.obj': rock });
      await loaded(person, 'scene');
      near(await person.reads('mass'), 1000 / 6000, 0.006, 'a tetrahedron of water');
      await person.press('Copy link to this state');
      await person.section.getByText('It includes other files').waitFor();
      await person.press('rod.xml');
      await loaded(person, 'rod');
    }),

  'a dropped mesh makes contact with the ground, and a change of theme does not move the robot': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      // A tetrahedron a tenth of a metre deep, in millimetres and upside down in its file.
      const corners = [[0, 0, 100], [100, 0, -100], [-100, 100, -100], [-100, -100, -100]];
      const facets = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].map((facet) =>
        `facet normal 0 0 0 outer loop ${facet.map((k) => `vertex ${corners[k].join(' ')}`).join(' ')} endloop endfacet`);
      const inertia = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>';
      const mesh = '<mesh filename="cone.stl" scale="0.001 0.001 -0.001"/>';
      const collision = `<collision><origin xyz="0 0 0.3"/><geometry>${mesh}</geometry></collision>`;
      const link = `<link name="cone"><inertial><mass value="2"/>${inertia}</inertial>${collision}</link>`;
      await person.flips('Base floats freely');
      await give(person, { 'cone.urdf': `<robot name="cone">${link}</robot>`, 'cone.stl': `solid cone ${facets.join(' ')} endsolid` });
      await loaded(person, 'cone');
      await person.waits(0.5);
      // Its tip is 0.2 m above the link's frame, so the start is not lifted.
      near(await person.reads('V'), 0, 1e-6, 'where it starts');
      await person.press('Play');
      await person.waits(1);
      await person.press('Pause');
      assert.ok((await stage(person).evaluate(({ dataset }) => Number(dataset.contacts))) >= 1, 'it touches');
      const before = await person.reads('t');
      await person.page.emulateMedia({ colorScheme: 'dark' });
      await person.waits(0.5);
      assert.equal(await person.reads('t'), before);
    }, { viewport: { width: 520, height: 640 } }),

  'the link contains a dropped file, and a message tells if it is too large': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const text = readFileSync(new URL('three_r.urdf', robots), 'utf8').replace('name="three_r"', 'name="parcel"');
      await give(person, { 'parcel.urdf': text });
      await loaded(person, 'parcel');
      await person.press('Copy link to this state');
      const link = person.page.url();
      assert.ok(link.length < 4000, `${link.length} characters`);
      await person.page.goto('about:blank');
      await person.page.goto(link);
      await loaded(person, 'parcel');
      // Many links with random names, which do not compress.
      const names = Array.from({ length: 3000 }, (_, i) => `${i}${Math.random().toString(36)}`);
      const links = names.map((name) => `<link name="l${name}"/>`).join('');
      const ends = (name) => `<parent link="base"/><child link="l${name}"/>`;
      const joints = names.map((name) => `<joint name="j${name}" type="fixed">${ends(name)}</joint>`).join('');
      const arm = text.replace(/^[\s\S]*?<robot[^>]*>/, '').replace(/<\/robot>\s*$/, '').replace(/"base"/g, '"base_of_arm"');
      const tie = '<joint name="tie" type="fixed"><parent link="base"/><child link="base_of_arm"/></joint>';
      const root = /<link name="base_of_arm"/.test(arm) ? tie : '';
      await give(person, { 'large.urdf': `<robot name="large"><link name="base"/>${root}${arm}${links}${joints}</robot>` });
      await loaded(person, 'large');
      await person.press('Copy link to this state');
      const said = person.section.locator('.copied');
      // After the clipboard has answered.
      await said.filter({ hasText: /./ }).waitFor();
      assert.match(await said.textContent(), /too large for a link/);
      assert.equal(new URLSearchParams(person.page.url().split('?')[1]).get('file'), null);
    }),

  'names in files are text, wherever the page writes them': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const name = '=cmd|x&#10;<script>window.broken = 1</script>\u202e"\'&amp;';
      const written = name.replace(/</g, '&lt;').replace(/"/g, '&quot;');
      const file = `<mujoco model="${written}"><worldbody><body name="${written}"><joint name="${written}" axis="0 1 0"/>`
        + `<geom size="0.1"/></body></worldbody><actuator><motor name="${written}" joint="${written}"/></actuator>`
        + `<keyframe><key name="${written}" ctrl="1"/><key name="${written}2" ctrl="0"/></keyframe></mujoco>`;
      await give(person, { '<b>\u202emodel.xml': file });
      await loaded(person, '=cmd|x\\n<script>window.broken = 1</script>\\u{202e}"\'&');
      assert.equal(await person.page.evaluate(() => window.broken), undefined, 'no name is a script');
      assert.equal(await person.section.locator('script, b').count(), 0, 'no name is an element');
      await person.section.getByText('Controls of the actuators').click();
      await person.section.getByText('Pose, joint by joint').click();
      const seen = await person.section.innerText();
      assert.ok(!/[\u202e\u0000-\u0008]/.test(seen), 'what cannot be seen is written as its escape');
      assert.ok(seen.includes('\\u{202e}'), 'and can be read');
      await person.press('Play');
      await person.waits(0.5);
      await person.press('Pause');
      const [csv] = await Promise.all([person.page.waitForEvent('download'), person.press('CSV')]);
      const lines = readFileSync(await csv.path(), 'utf8').trimEnd().split('\n');
      assert.equal(lines[0], 't [s],K [J],V [J],E [J]');
      assert.ok(lines.length > 2 && lines.every((line) => line.split(',').length === 4), 'no name breaks a row');
      await person.press('Embed');
      const code = await person.section.locator('.embed-code').inputValue();
      assert.equal((code.match(/</g) ?? []).length, 2, `one element: ${code}`);
      await person.press('Record a video');
      await person.waits(0.3);
      const [film] = await Promise.all([person.page.waitForEvent('download'), person.press('End the video')]);
      assert.match(film.suggestedFilename(), /^_cmd_x__script[A-Za-z0-9_]*\.(webm|mp4)$/);
    }, { viewport: { width: 520, height: 640 } }),

  'an MJCF file is opened like a URDF file, and a folder with its meshes': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const cube = (s) => {
        const corner = (k) => [k & 1, (k >> 1) & 1, k >> 2].map((x) => (x ? s : -s)).join(' ');
        const faces = ['013', '032', '475', '467', '051', '045', '237', '276', '026', '064', '157', '173'].map((face) => [...face]);
        const facet = (face) => `facet normal 0 0 0\nouter loop\n${face.map((k) => `vertex ${corner(k)}`).join('\n')}\nendloop\nendfacet`;
        return `solid cube\n${faces.map(facet).join('\n')}\nendsolid cube\n`;
      };
      const urdf = `<robot name="boxed"><link name="base"/><link name="arm"><inertial><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
        <visual><geometry><mesh filename="package://boxed/meshes/cube.stl"/></geometry></visual>
        <visual><geometry><mesh filename="package://boxed/meshes/absent.stl"/></geometry></visual></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>`;
      await give(person, { 'boxed.urdf': urdf, 'meshes/cube.stl': cube(0.3) });
      await loaded(person, 'boxed');
      await person.section.getByText('1 mesh is missing (absent.stl)').waitFor();
      const mjcf = readFileSync(new URL('arm.xml', robots), 'utf8').replace(/model="[^"]*"/, 'model="mine"');
      await give(person, { 'mine.xml': mjcf });
      await loaded(person, 'mine');
    }),

  'the code for three dimensions is loaded with the first robot, and is under 400 kB': (address) =>
    at(address, 'replay', async (person) => {
      const scripts = () => person.page.evaluate(() =>
        performance.getEntriesByType('resource').map(({ name }) => name).filter((name) => name.endsWith('.js')));
      const before = await scripts();
      await person.page.locator(`#${ID}`).scrollIntoViewIfNeeded();
      await person.page.getByText('“panda” has').waitFor();
      const later = (await scripts()).filter((name) => !before.includes(name));
      const file = (name) => readFileSync(new URL(`../../dist/site/${name.slice(address.length)}`, import.meta.url));
      const total = later.reduce((sum, name) => sum + gzipSync(file(name), { level: 9 }).length, 0);
      console.log(`        ${(total / 1000).toFixed(0)} kB in ${later.length} scripts`);
      assert.ok(later.some((name) => name.includes('solid-stage')) && total > 50_000 && total < 400_000, `${total}`);
    }),

  'a file is opened, and an invalid one gives a message': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const input = person.section.getByLabel('A robot file', { exact: true });
      const choose = (name, text) => input.setInputFiles({ name, mimeType: 'text/xml', buffer: Buffer.from(text) });
      await choose('ur5.urdf', readFileSync(new URL('ur5.urdf', robots), 'utf8').replace('name="ur5"', 'name="mine"'));
      await loaded(person, 'mine');
      assert.equal(await person.reads('dof'), 6);
      const joint = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>';
      await choose('broken.urdf', `<robot name="broken"><link name="a"/>${joint}</robot>`);
      await person.section.getByText('This file was not loaded.').waitFor();
      assert.match(await person.section.locator('.message').first().textContent(), /line 1|joint|link/);
      assert.equal(await person.reads('dof'), 6, 'the robot before stays');
    }),

  'a file is dropped on the page': (address) =>
    at(address, ID, async (person) => {
      await loaded(person, 'panda');
      const text = readFileSync(new URL('three_r.urdf', robots), 'utf8');
      await give(person, { 'three_r.urdf': text });
      await loaded(person, 'three_r');
    }),
};
