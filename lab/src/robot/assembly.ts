// A robot's links as groups of solids: the file's shapes, its meshes, rods for links without shapes, and
// masses.
import { Box3, Group, Matrix4, Mesh, type Object3D, Sphere, Vector3 } from 'three';

import { vector } from '../drawing/view.ts';
import type { DrawnShape, Robot } from '../../lib/dynamics/index.ts';
import type { MeshFiles } from './mesh-files.ts';
import { colorOf, masses, type Materials, placed, skeleton, solid } from './solids.ts';
import { POSE } from './stage.ts';

export interface Assembly {
  links: Group[];
  /** Whether the hand can move a link. */
  movable: boolean[];
  /** Approximate size of the robot [m]. */
  reach: number;
  /** Height of the file's ground [m]. */
  ground: number | undefined;
  /** Meshes with missing files. */
  absent: string[];
  /** Meshes of collision shapes. */
  hulls: { shape: DrawnShape; body: Object3D }[];
}

export async function assemble(robot: Robot, files: MeshFiles, materials: Materials): Promise<Assembly> {
  const shapes = robot.shapes();
  const reach = size(robot, shapes);
  const links = robot.bodies().map((_, link) => {
    const group = new Group();
    group.matrixAutoUpdate = false;
    group.userData['link'] = link;
    return group;
  });
  const roots = new Set(links.keys());
  for (const { child } of robot.joints()) roots.delete(child);
  let ground: number | undefined;
  const dressed = new Set<number>();
  const absent: string[] = [];
  const hulls: Assembly['hulls'] = [];
  await Promise.all(shapes.map(async (shape) => {
    if (shape.kind === 'plane' && roots.has(shape.link)) {
      // The stage draws its own ground in its place.
      ground = shape.pose[11];
      return;
    }
    const body = shape.kind === 'mesh' ? await mesh(shape, files, materials) : form(shape, reach, materials);
    if (body === undefined) {
      if (shape.kind === 'mesh') absent.push(shape.file);
      return;
    }
    if (shape.kind === 'mesh' && !shape.visual) hulls.push({ shape, body });
    body.matrixAutoUpdate = false;
    body.userData['layer'] = shape.visual ? 'shapes' : 'collision';
    body.userData['flat'] = shape.kind === 'plane';
    links[shape.link]!.add(body);
    if (shape.visual) dressed.add(shape.link);
  }));
  // A link without visual shapes shows its collision shapes, and one without either a rod.
  links.forEach((group, link) => {
    if (dressed.has(link)) return;
    for (const body of group.children) {
      body.userData['layer'] = 'shapes';
      if (body instanceof Mesh) body.material = materials.named('part');
      dressed.add(link);
    }
  });
  const layer = (name: string, parts: readonly Object3D[], link: number): void => {
    for (const part of parts) {
      part.userData['layer'] = name;
      links[link]!.add(part);
    }
  };
  skeleton(robot, (link) => !dressed.has(link), reach, materials).forEach((parts, link) => { layer('shapes', parts, link); });
  masses(robot, reach, materials).forEach((mass, link) => { layer('inertia', mass === undefined ? [] : [mass], link); });
  return { links, movable: canMove(robot), reach, ground, absent, hulls };
}

/** The extent of its joints, masses and shapes. */
function size(robot: Robot, shapes: readonly DrawnShape[]): number {
  const poses = robot.poses();
  const bodies = robot.bodies();
  const points = bodies.map((_, link) => new Vector3(...vector(poses, POSE * link + 9)));
  const around = new Box3().setFromPoints(points).getBoundingSphere(new Sphere());
  const sizes = shapes.filter(({ kind }) => kind !== 'plane' && kind !== 'mesh').flatMap((shape) => [...shape.size]);
  return Math.max(0.02, around.radius, ...sizes.map((one) => 0.5 * one), ...bodies.map(({ center }) => 1.6 * Math.hypot(...center)));
}

function material(shape: DrawnShape, materials: Materials): ReturnType<Materials['of']> {
  if (!shape.visual) return materials.named('collision', 0.35);
  const color = colorOf(shape);
  return color === undefined ? materials.named('part') : materials.of(color, shape.color[3] ?? 1);
}

function form(shape: DrawnShape, reach: number, materials: Materials): Object3D | undefined {
  const geometry = solid(shape, reach);
  if (geometry === undefined) return undefined;
  const body = new Mesh(geometry, material(shape, materials));
  body.matrix.copy(placed(shape.pose));
  return body;
}

async function mesh(shape: DrawnShape, files: MeshFiles, materials: Materials): Promise<Object3D | undefined> {
  const found = await files.load(shape.file);
  if (found === undefined) return undefined;
  // A mesh file's own colours are kept if the robot's file has none.
  const dress = !shape.visual || shape.color.length > 0 || /\.stl$/i.test(shape.file);
  found.traverse((part) => {
    if (dress && part instanceof Mesh) part.material = material(shape, materials);
  });
  const body = new Group().add(found);
  body.matrix.copy(placed(shape.pose)).scale(new Vector3(...shape.size));
  return body;
}

/** The points of a mesh in its shape's frame [m]: those of the mesh file, scaled as in the robot's file. */
export function points({ shape, body }: Assembly['hulls'][number]): Float64Array {
  body.updateWorldMatrix(true, true);
  const [x, y, z] = vector(shape.size);
  const fromWorld = new Matrix4().makeScale(x, y, z).multiply(body.matrixWorld.clone().invert());
  const list: number[] = [];
  body.traverse((part) => {
    if (!(part instanceof Mesh)) return;
    const places = (part as Mesh).geometry.getAttribute('position');
    const to = new Matrix4().multiplyMatrices(fromWorld, part.matrixWorld);
    for (let i = 0; i < places.count; i += 1) list.push(...new Vector3().fromBufferAttribute(places, i).applyMatrix4(to));
  });
  return Float64Array.from(list);
}

function canMove(robot: Robot): boolean[] {
  const joints = robot.joints();
  return robot.bodies().map((_, link) => {
    for (let at: number | undefined = link; at !== undefined;) {
      const joint = joints.find(({ child }) => child === at);
      if (joint !== undefined && joint.coordinates.length > 0) return true;
      at = joint?.parent;
    }
    return robot.baseFloats;
  });
}
