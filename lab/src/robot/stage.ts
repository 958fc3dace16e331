// The view of a robot: three-dimensional with WebGL, otherwise a flat drawing.
import type { Shared } from '../address.ts';
import type { Vector3 } from '../drawing/view.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import type { MeshFiles } from './mesh-files.ts';

export interface Layers {
  /** The file's visual shapes, or a skeleton without any. */
  shapes: boolean;
  /** The collision shapes. */
  collision: boolean;
  /** The uniform ellipsoid of each link's mass and inertia. */
  inertia: boolean;
  /** The contact forces. */
  forces: boolean;
}

/** Grips a point of a link, moves it, releases it; positions in the world [m]. */
export interface Hand {
  grab(link: number, point: Vector3): void;
  move(point: Vector3): void;
  release(): void;
}

export interface Stage {
  element: Element;
  /** Builds the drawing of a robot, and returns its missing meshes. */
  show(robot: Robot, files: MeshFiles): Promise<readonly string[]>;
  /** The robot's current pose. */
  draw(): void;
  /** Moves the camera so that the whole robot is in view. */
  fit(): void;
  look(azimuth: number, elevation: number): void;
  layers(layers: Layers): void;
  /** The brightness of each link from the next picture on, 0 to 1; undefined for none. */
  glow(brightness: Float64Array | undefined): void;
  /** The viewpoint, for the address. */
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

/** The numbers of a link in `robot.poses()`: a rotation in row-major order, then the origin. */
export const POSE = 12;

/** A viewpoint: a name, azimuth, elevation [rad]. */
export const VIEWS = [['Front', 0, 0.05], ['Side', -Math.PI / 2, 0.05], ['Above', -Math.PI / 2, 1.5]] as const;
