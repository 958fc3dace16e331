// The library's integrators with their names on the page.
import type { IntegratorName } from '../../lib/dynamics/index.ts';

export const INTEGRATORS: readonly (readonly [IntegratorName, string])[] = [
  ['rk4', 'Runge–Kutta 4'],
  ['variational-midpoint', 'Variational midpoint'],
  ['variational-yoshida4', 'Variational, order 4'],
  ['semi-implicit-euler', 'Semi-implicit Euler'],
  ['explicit-euler', 'Explicit Euler'],
];
