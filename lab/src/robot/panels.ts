// The modules that a robot's controls need once a robot is there.
export { acting } from './acting.ts';
export { actuators } from './actuators.ts';
export { poseSliders } from './pose-sliders.ts';
export { robotBooks } from './robot-books.ts';
export { torqueTable } from './torque-table.ts';
export { reportTable } from '../widgets/load-report.ts';
