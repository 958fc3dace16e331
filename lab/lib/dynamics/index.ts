// Robot dynamics for TypeScript: a typed interface to the WebAssembly build, without computations of its own.
import { engine } from './engine.ts';

export { columns, load, loadBytes, rows, tuple, type Tuple, type Vector } from './engine.ts';
export { PlanarArm, PlanarBody, PolarMass, Reach2R, RpArm } from './models.ts';
export { energyDrift, rk4Step, System, type InertiaEllipse, type IntegratorName, type State } from './system.ts';
export { loadRobots, type Robot, type RobotCoordinate, type Robots, type DrawnShape } from './robots.ts';
export { selfChecks, type SelfCheck } from './self-checks.ts';

// Simulations: a state, whole steps, and samples over simulated time.
export const { Blade: KnifeEdge, Brick, FallingArm, Race, Replay, ThrownArm, Workbench, integratorNames } = engine;
export type KnifeEdge = engine.Blade;
export type Brick = engine.Brick;
export type FallingArm = engine.FallingArm;
export type Race = engine.Race;
export type Replay = engine.Replay;
export type ThrownArm = engine.ThrownArm;
export type Workbench = engine.Workbench;
