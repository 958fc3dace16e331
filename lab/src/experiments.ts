// What the page is made of, in the order of the story: the name that an address gives it, its title, what makes it.
import type { Widget } from './widgets/frame.ts';
import { flipMap } from './widgets/flip-map.ts';
import { inertiaEllipse } from './widgets/inertia-ellipse.ts';
import { integratorRace } from './widgets/integrator-race.ts';
import { knifeEdge } from './widgets/knife-edge.ts';
import { lagrangianLab } from './widgets/lagrangian-lab.ts';
import { opening } from './widgets/opening.ts';
import { predictFirst } from './widgets/predict-first.ts';
import { replay } from './widgets/replay.ts';
import { tumblingBrick } from './widgets/tumbling-brick.ts';
import { workbench } from './widgets/workbench.ts';
import { yourRobot } from './widgets/your-robot.ts';

/** The questions come before what answers them. */
export const EXPERIMENTS: readonly (readonly [string, string, () => Widget])[] = [
  ['opening', 'Throw it', opening],
  ['predict-first', 'Predict first', predictFirst],
  ['inertia-ellipse', 'Inertia ellipse', inertiaEllipse],
  ['lagrangian-lab', 'Lagrangian lab', lagrangianLab],
  ['replay', 'Replay', replay],
  ['workbench', 'Workbench', workbench],
  ['knife-edge', 'Knife-edge', knifeEdge],
  ['tumbling-brick', 'Tumbling brick', tumblingBrick],
  ['your-robot', 'Your robot', yourRobot],
  ['integrator-race', 'Integrator race', integratorRace],
  ['flip-map', 'Map of flips', flipMap],
];
