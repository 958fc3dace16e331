// What shows a robot: in three dimensions where the browser can, as a flat drawing elsewhere.
import type { Shared } from '../address.ts';
import type { Vector3 } from '../drawing/view.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import type { MeshFiles } from './mesh-files.ts';

export interface Layers {
  /** What the file gives to be seen; a skeleton where it gives nothing. */
  shapes: boolean;
  /** What the links hit. */
  collision: boolean;
  /** The uniform ellipsoid of each link's mass and inertia. */
  inertia: boolean;
  /** What each contact pushes with. */
  forces: boolean;
}

/** Takes hold of a point of a link, moves it, lets go; places in the world [m]. */
export interface Hand {
  grab(link: number, point: Vector3): void;
  move(point: Vector3): void;
  release(): void;
}

export interface Stage {
  element: Element;
  /** Builds what is drawn of a robot; answers with the meshes that were not to be had. */
  show(robot: Robot, files: MeshFiles): Promise<readonly string[]>;
  /** The robot's present pose. */
  draw(): void;
  /** Brings all of it into the picture. */
  fit(): void;
  look(azimuth: number, elevation: number): void;
  layers(layers: Layers): void;
  /** How brightly each link glows from the next picture on, 0 to 1; undefined: none does. */
  glow(brightness: Float64Array | undefined): void;
  /** Where it is seen from, for the address. */
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

/** Numbers a link in `robot.poses()`: a rotation row by row, then the origin. */
export const POSE = 12;

/** Where to look from: a name, azimuth, elevation [rad]. */
export const VIEWS = [['Front', 0, 0.05], ['Side', -Math.PI / 2, 0.05], ['Above', -Math.PI / 2, 1.5]] as const;
