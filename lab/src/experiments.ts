// The constructors of the experiments, by their names in addresses.
export { selfCheckPanel } from './self-check-panel.ts';
import type { Id } from './story/words.ts';
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

export const EXPERIMENTS: Readonly<Record<Id, () => Widget>> = {
  'opening': opening,
  'predict-first': predictFirst,
  'inertia-ellipse': inertiaEllipse,
  'lagrangian-lab': lagrangianLab,
  'replay': replay,
  'workbench': workbench,
  'knife-edge': knifeEdge,
  'tumbling-brick': tumblingBrick,
  'your-robot': yourRobot,
  'integrator-race': integratorRace,
  'flip-map': flipMap,
};
