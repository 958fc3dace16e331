// A program in TypeScript with the package's types.
import { load, type Module, type Robot } from '@robot-dynamics/wasm';

const module: Module = await load();
const robot: Robot = module.Robot.load('<robot name="none"/>', false, false);
export const mass: number = robot.totalMass;
export const torques: Float64Array = robot.inverseDynamics(robot.q, robot.v, robot.v);
