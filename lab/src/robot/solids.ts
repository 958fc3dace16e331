// The solids of a robot's links: the file's shapes, its masses, or a skeleton of rods and pins.
import {
  BoxGeometry, type BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, type Material, Matrix4, Mesh, MeshStandardMaterial,
  type Object3D, PlaneGeometry, Quaternion, SphereGeometry, Vector3,
} from 'three';

import type { DrawnShape, Robot } from '../../lib/dynamics/index.ts';
import { POSE } from './stage.ts';

const UP = new Vector3(0, 1, 0);

/** The materials, by theme. */
export interface Palette {
  part: Color;
  pin: Color;
  mass: Color;
  collision: Color;
}

export class Materials {
  private readonly made = new Map<string, MeshStandardMaterial>();
  constructor(private readonly palette: Palette) {}

  named(name: keyof Palette, opacity = 1): MeshStandardMaterial {
    return this.of(this.palette[name], opacity);
  }

  /** The material of a file's colour. */
  of(color: Color, opacity = 1): MeshStandardMaterial {
    const key = `${color.getHexString()} ${opacity.toFixed(2)}`;
    let material = this.made.get(key);
    if (material === undefined) {
      material = new MeshStandardMaterial({ color, roughness: 0.62, metalness: 0.05 });
      if (opacity < 1) Object.assign(material, { transparent: true, opacity, depthWrite: false });
      this.made.set(key, material);
    }
    return material;
  }

  dispose(): void {
    for (const material of this.made.values()) material.dispose();
  }
}

/** A shape of the file in its link's frame; `undefined` for a mesh, whose file must be loaded, and for
 * unknown shapes. */
export function solid(shape: DrawnShape, reach: number): BufferGeometry | undefined {
  const [a = 0, b = 0, c = 0] = shape.size;
  switch (shape.kind) {
    case 'box': return new BoxGeometry(a, b, c);
    case 'sphere': return new SphereGeometry(a, 32, 20);
    case 'ellipsoid': return new SphereGeometry(1, 32, 20).scale(a, b, c);
    // Cylinders of three.js are along y, those of robots along z.
    case 'cylinder': return new CylinderGeometry(a, a, b, 32).rotateX(Math.PI / 2);
    case 'capsule': return new CapsuleGeometry(a, b, 8, 24).rotateX(Math.PI / 2);
    case 'plane': return new PlaneGeometry(2 * (a || 4 * reach), 2 * (b || 4 * reach));
    default: return undefined;
  }
}

/** A rotation in row-major order and an origin, from `at` in a list. */
export function placed(list: ArrayLike<number>, at = 0): Matrix4 {
  const n = (k: number): number => list[at + k]!;
  return new Matrix4().set(n(0), n(1), n(2), n(9), n(3), n(4), n(5), n(10), n(6), n(7), n(8), n(11), 0, 0, 0, 1);
}

/** The colour of the file, in sRGB. */
export function colorOf(shape: DrawnShape): Color | undefined {
  const [r, g, b] = shape.color;
  return r === undefined ? undefined : new Color().setRGB(r, g!, b!, 'srgb');
}

/** Inertia ellipsoids, one for each link; a tiny one is enlarged to be visible. */
export function masses(robot: Robot, reach: number, materials: Materials): (Object3D | undefined)[] {
  return robot.bodies().map(({ mass, center, semiaxes, axes }) => {
    if (!(mass > 0)) return undefined;
    const within = (a: number): number => Math.min(0.6 * reach, Math.max(0.012 * reach, a));
    const ellipsoid = new Mesh(new SphereGeometry(1, 24, 16), materials.named('mass', 0.45));
    ellipsoid.matrix.copy(placed([...axes, ...center])).scale(new Vector3(...Array.from(semiaxes, within)));
    ellipsoid.matrixAutoUpdate = false;
    return ellipsoid;
  });
}

/** Rods from joint to joint and pins along the axes, for links without shapes. */
export function skeleton(robot: Robot, bare: (link: number) => boolean, reach: number, materials: Materials): Mesh[][] {
  const poses = robot.poses();
  const bodies = robot.bodies();
  const joints = robot.joints();
  const coordinates = robot.coordinates();
  const parts: Mesh[][] = bodies.map(() => []);
  const world = bodies.map((_, link) => placed(poses, POSE * link));
  const radii = bodies.map(({ semiaxes }) => {
    const [small, middle] = Array.from(semiaxes).sort((p, q) => p - q) as [number, number];
    return Math.min(0.055 * reach, Math.max(0.022 * reach, 0.45 * (small + middle)));
  });
  // A link without mass is as thick as its children.
  for (const { parent, child } of [...joints].reverse()) {
    if (!(bodies[parent]!.mass > 0)) radii[parent] = Math.max(radii[parent]!, radii[child]!);
  }
  const roots = new Set(bodies.keys());
  for (const { parent, child, coordinate, axis } of joints) {
    roots.delete(child);
    const place = new Vector3().setFromMatrixPosition(world[child]!).applyMatrix4(world[parent]!.clone().invert());
    if (bare(parent)) parts[parent]!.push(...rod(place, radii[parent]!, materials.named('part')));
    const along = new Vector3(...axis);
    if (coordinate === undefined || along.lengthSq() === 0 || !bare(child)) continue;
    const size = 1.3 * radii[child]!;
    const slides = coordinates[coordinate]?.slides ?? false;
    const pin = slides ? new BoxGeometry(1.7 * size, 2.4 * size, 1.7 * size) : new CylinderGeometry(size, size, 2.5 * size, 28);
    const mesh = new Mesh(pin, materials.named('pin'));
    mesh.quaternion.setFromUnitVectors(UP, along.normalize());
    parts[child]!.push(mesh);
  }
  const parents = new Set(joints.map(({ parent }) => parent));
  bodies.forEach(({ mass, center }, link) => {
    if (!bare(link)) return;
    // The last link extends as far beyond its centre of mass as that is from its joint, like a uniform rod.
    if (mass > 0 && !parents.has(link)) {
      const end = new Vector3(...center).multiplyScalar(2);
      parts[link]!.push(...rod(end, radii[link]!, materials.named('part')));
      if (end.length() < radii[link]!) parts[link]!.push(new Mesh(new SphereGeometry(radii[link]!, 24, 16), materials.named('part')));
    }
    if (roots.has(link) && !robot.floats) {
      const size = 0.1 * reach;
      parts[link]!.push(new Mesh(new CylinderGeometry(size, 1.1 * size, 0.03 * reach, 40).rotateX(Math.PI / 2), materials.named('pin')));
    }
  });
  return parts;
}

function rod(end: Vector3, radius: number, material: Material): Mesh[] {
  const length = end.length();
  if (length < 0.2 * radius) return [];
  const mesh = new Mesh(new CapsuleGeometry(radius, length, 8, 24), material);
  mesh.position.copy(end).multiplyScalar(0.5);
  mesh.quaternion.copy(new Quaternion().setFromUnitVectors(UP, end.clone().normalize()));
  return [mesh];
}
