// Installs the packed package into an empty folder, as a user does, and compares its numbers with closed
// forms. `cargo xtask npm` copies the module and runs this.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';

const PACKAGE = fileURLToPath(new URL('..', import.meta.url));
const ROOT = join(PACKAGE, '..');

let folder;
let robots;

const npm = (args, cwd) => execFileSync('npm', args, { cwd, encoding: 'utf8', shell: process.platform === 'win32' });

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'robot-dynamics-'));
  const [{ filename }] = JSON.parse(npm(['pack', '--json', '--pack-destination', folder], PACKAGE));
  writeFileSync(join(folder, 'package.json'), '{ "private": true, "type": "module" }');
  npm(['install', '--offline', '--no-audit', '--no-fund', join(folder, filename)], folder);
  writeFileSync(join(folder, 'program.js'), "export * from '@robot-dynamics/wasm';\n");
  robots = await (await import(pathToFileURL(join(folder, 'program.js')).href)).load();
});

after(() => rmSync(folder, { recursive: true, force: true }));

/** Sums of a few products of numbers near 10 have errors of a few units in the last place, 2e-15 each. */
const ROUNDING = 1e-13;

function near(found, expected, tolerance = ROUNDING) {
  assert.equal(found.length, expected.length);
  expected.forEach((x, k) => assert.ok(Math.abs(found[k] - x) <= tolerance, `${k}: ${found[k]}, expected ${x}`));
}

/** Two uniform rods of 1 m, with 2 kg and 1 kg. M and g follow from the Lagrangian by hand. */
function twoRods(q1, q2) {
  const [m1, m2, g, c2] = [2, 1, 9.81, Math.cos(q2)];
  const [far, near] = [m2 * (1 / 3 + c2 / 2), m2 / 3];
  const [first, second] = [(m1 / 2 + m2) * g * Math.cos(q1), (m2 / 2) * g * Math.cos(q1 + q2)];
  return { m: [m1 / 3 + m2 * (4 / 3 + c2), far, far, near], g: [first + second, second] };
}

const twoR = () => robots.Robot.load(readFileSync(join(ROOT, 'robots/two_r.urdf'), 'utf8'), false, false);

test('mass matrix and gravity are those of two rods', () => {
  const robot = twoR();
  assert.equal(robot.totalMass, 3);
  for (const q of [[0, 0], [Math.PI / 4, Math.PI / 2], [-1.2, 2.5]]) {
    const expected = twoRods(...q);
    near(robot.massMatrix(Float64Array.from(q)), expected.m);
    near(robot.gravityForces(Float64Array.from(q)), expected.g);
  }
});

test('forward dynamics inverts inverse dynamics', () => {
  const robot = twoR();
  const [q, v, a] = [[0.3, -0.8], [1.5, -0.4], [2, -3]].map((x) => Float64Array.from(x));
  const torques = robot.inverseDynamics(q, v, a);
  // The condition number of M is at most 40.
  near(robot.forwardDynamics(q, v, torques), [...a], 40 * ROUNDING);
});

test('a falling arm keeps its energy', () => {
  const robot = twoR();
  robot.choose('rk4', 1e-3, []);
  robot.place(Float64Array.of(0, 0));
  robot.advance(1000);
  const { kinetic, unaccounted } = robot.energyAccount;
  assert.ok(kinetic > 1, `${kinetic}`);
  // Runge–Kutta 4 of steps of 1 ms: the error of the energy is of order h⁴ over a second, times 15 J.
  assert.ok(Math.abs(unaccounted) < 1e-8, `${unaccounted}`);
});

test('errors name the problem', () => {
  assert.throws(() => robots.Robot.load('<robot', false, false), Error);
  assert.throws(() => twoR().massMatrix(Float64Array.of(0)), /q/);
});

test('the example for Node.js runs', () => {
  cpSync(join(folder, 'node_modules/@robot-dynamics/wasm/examples/node.mjs'), join(folder, 'example.mjs'));
  const printed = execFileSync(process.execPath, ['example.mjs'], { cwd: folder, encoding: 'utf8' });
  // m g l/2 with 2 kg and 1 m.
  assert.match(printed, /9\.810 N m/);
});

test('types are those of the module', () => {
  const options = { target: 'es2022', module: 'nodenext', strict: true, noEmit: true, skipLibCheck: false, lib: ['es2022', 'esnext.disposable', 'dom'] };
  writeFileSync(join(folder, 'tsconfig.json'), JSON.stringify({ compilerOptions: { ...options, types: [] }, files: ['types.ts'] }));
  cpSync(join(PACKAGE, 'test/types.ts'), join(folder, 'types.ts'));
  execFileSync(process.execPath, [join(ROOT, 'lab/node_modules/typescript/bin/tsc'), '-p', folder], { stdio: 'inherit' });
});
