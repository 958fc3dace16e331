import type * as robots from './module/robots.js';

/** Everything that the module exports: `Robot`, `RobotFiles` and the types of their results. */
export type Module = typeof robots;

export type * from './module/robots.js';

/** Loads the module once. After a failure the next call tries again. */
export function load(): Promise<Module>;
