// The modules of a robot's controls, loaded with the first robot.
export { effectSwitches } from './effect-switches.ts';
export { actuators } from './actuators.ts';
export { poseSliders } from './pose-sliders.ts';
export { energyTable } from './energy-table.ts';
export { torqueTable } from './torque-table.ts';
export { reportTable } from '../widgets/load-report.ts';
