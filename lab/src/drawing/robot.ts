// A robot without meshes: a line from joint to joint, an ellipsoid of inertia for every link.
import { set, svg } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { axesInWorld, outline } from './ellipsoid.ts';
import { rotate, type Vector3, type View } from './view.ts';

/** Numbers per link in `poses` and `bodies`, per joint in `joints` and `jointAxes`. */
const POSE = 12;
const BODY = 16;
const AXIS = 4;

/** Asks for a change of a coordinate, in rad or m. */
export type Pull = (coordinate: number, by: number) => void;

export interface RobotDrawing {
  element: SVGGElement;
  draw(view: View): void;
  /** The middle of the robot and how far it reaches from there, in its present pose. */
  extent(): { middle: Vector3; reach: number };
}

export function robotDrawing(robot: Robot, pull: Pull, grab: () => void): RobotDrawing {
  const names = robot.linkNames();
  const bodies = robot.bodies();
  const joints = Array.from(robot.joints());
  const axes = robot.jointAxes();
  const bones = svg('path', { class: 'bones' });
  const knuckles = svg('path', { class: 'knuckles' });
  const links = names.map((name, link) => svg('ellipse', { class: 'link', 'data-link': name, visibility: bodies[BODY * link]! > 0 ? 'visible' : 'hidden' }));
  const layer = svg('g', {}, ...links);
  const element = svg('g', {}, layer, bones, knuckles);
  let poses = robot.poses();
  let seenFrom: View | undefined;

  const origin = (link: number): Vector3 => [poses[POSE * link + 9]!, poses[POSE * link + 10]!, poses[POSE * link + 11]!];
  const centre = (link: number): Vector3 => {
    const c = [bodies[BODY * link + 1]!, bodies[BODY * link + 2]!, bodies[BODY * link + 3]!] as const;
    const [x, y, z] = rotate(poses, c, POSE * link);
    const o = origin(link);
    return [o[0] + x, o[1] + y, o[2] + z];
  };

  links.forEach((ellipse, link) => {
    // The joint that moves this link, or the nearest one above it that moves.
    let joint = joints.findIndex((one, i) => i % 2 === 1 && one === link) >> 1;
    while (joint >= 0 && axes[AXIS * joint]! < 0) {
      const parent = joints[2 * joint]!;
      joint = joints.findIndex((one, i) => i % 2 === 1 && one === parent) >> 1;
    }
    if (joint < 0) return;
    ellipse.classList.add('grip');
    ellipse.addEventListener('pointerdown', (event) => {
      event.stopPropagation();
      ellipse.setPointerCapture(event.pointerId);
      grab();
    });
    ellipse.addEventListener('pointermove', (event) => {
      if (!ellipse.hasPointerCapture(event.pointerId) || seenFrom === undefined) return;
      const matrix = ellipse.ownerSVGElement!.getScreenCTM()!;
      const [dx, dy] = [event.movementX / matrix.a, -event.movementY / matrix.d];
      // How the picture of the grabbed point moves with the joint: axis × arm for a turn, the axis for a slide.
      const [tx, ty] = seenFrom.look(tangent(joint, link));
      const size = tx * tx + ty * ty;
      if (size > 1e-9) pull(axes[AXIS * joint]!, (dx * tx + dy * ty) / Math.max(size, 1e-3));
    });
  });

  const tangent = (joint: number, link: number): Vector3 => {
    const child = joints[2 * joint + 1]!;
    const a = rotate(poses, [axes[AXIS * joint + 1]!, axes[AXIS * joint + 2]!, axes[AXIS * joint + 3]!], POSE * child);
    const coordinate = axes[AXIS * joint]!;
    if (slides[coordinate] === 1) return a;
    const [c, o] = [centre(link), origin(child)];
    const r = [c[0] - o[0], c[1] - o[1], c[2] - o[2]] as const;
    return [a[1] * r[2] - a[2] * r[1], a[2] * r[0] - a[0] * r[2], a[0] * r[1] - a[1] * r[0]];
  };
  const coordinates = robot.coordinates();
  const slides = Array.from({ length: coordinates.length / 5 }, (_, i) => coordinates[5 * i + 1]!);

  const draw = (view: View): void => {
    seenFrom = view;
    poses = robot.poses();
    const { reach } = extent();
    const at = names.map((_, link) => {
      const [x, y] = view.look(origin(link));
      return `${x.toFixed(4)} ${(-y).toFixed(4)}`;
    });
    let d = '';
    for (let i = 0; i < joints.length; i += 2) d += `M${at[joints[i]!]!}L${at[joints[i + 1]!]!}`;
    set(bones, { d });
    set(knuckles, { d: at.map((point) => `M${point}h0`).join('') });
    const depths = links.map((ellipse, link) => {
      const k = BODY * link;
      const middle = centre(link);
      const semi = [bodies[k + 4]!, bodies[k + 5]!, bodies[k + 6]!] as const;
      outline(ellipse, view, middle, axesInWorld(poses, POSE * link, bodies, k + 7), semi, 0.045 * reach);
      return { ellipse, depth: view.look(middle)[2] };
    });
    // The farthest first; an element in hand is not moved about.
    if (!links.some((ellipse) => ellipse.matches(':active'))) {
      const order = depths.sort((a, b) => a.depth - b.depth).map((entry) => entry.ellipse);
      if (order.some((ellipse, i) => layer.children[i] !== ellipse)) layer.append(...order);
    }
  };
  const extent = (): { middle: Vector3; reach: number } => {
    const points = names.map((_, link) => (bodies[BODY * link]! > 0 ? centre(link) : origin(link)));
    const range = ([0, 1, 2] as const).map((k) => points.map((point) => point[k]));
    const middle = range.map((values) => (Math.min(...values) + Math.max(...values)) / 2) as unknown as Vector3;
    const reach = Math.max(...points.map((point) => Math.hypot(...point.map((x, k) => x - middle[k]!))), 0.05);
    return { middle, reach };
  };
  return { element, draw, extent };
}
