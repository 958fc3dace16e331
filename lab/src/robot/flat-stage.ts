// A flat drawing of a robot for browsers without WebGL: a line from joint to joint, and an inertia ellipsoid
// for every link.
import { set, svg } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { axesInWorld, outline } from '../drawing/ellipsoid.ts';
import { floorLines, rotate, spatialPicture, vector, View, type Vector3 } from '../drawing/view.ts';
import { POSE, type Hand, type Stage } from './stage.ts';

export function flatStage(hand: Hand): Stage {
  const view = new View(-0.7, 0.3);
  const element = spatialPicture('The robot', view, 1, () => { draw(); });
  const floor = svg('path', { class: 'floor' });
  const bones = svg('path', { class: 'bones' });
  const knuckles = svg('path', { class: 'knuckles' });
  const layer = svg('g');
  element.append(floor, layer, bones, knuckles);
  let robot: Robot | undefined;
  let bodies: { center: Vector3; semiaxes: Vector3; axes: Float64Array; ellipse: SVGEllipseElement; heavy: boolean }[] = [];
  let joints: (readonly [number, number])[] = [];
  let poses: Float64Array = new Float64Array();
  let scale = 1;
  let middle: Vector3 = [0, 0, 0];

  const origin = (link: number): Vector3 => vector(poses, POSE * link + 9);
  const centre = (link: number): Vector3 => {
    const [x, y, z] = rotate(poses, bodies[link]!.center, POSE * link);
    const o = origin(link);
    return [o[0] + x, o[1] + y, o[2] + z];
  };

  const grips = (ellipse: SVGEllipseElement, link: number): void => {
    let held: Vector3 = [0, 0, 0];
    let from: readonly [number, number] = [0, 0];
    ellipse.addEventListener('pointerdown', (event) => {
      event.stopPropagation();
      ellipse.setPointerCapture(event.pointerId);
      [held, from] = [centre(link), [event.clientX, event.clientY]];
      hand.grab(link, held);
    });
    ellipse.addEventListener('pointermove', (event) => {
      if (!ellipse.hasPointerCapture(event.pointerId)) return;
      // In the plane of the picture, by the pointer's motion to the right and up.
      const perPixel = 1 / element.getScreenCTM()!.a;
      const [right, up] = view.plane();
      const [dx, dy] = [(event.clientX - from[0]) * perPixel, (from[1] - event.clientY) * perPixel];
      hand.move(vector([0, 1, 2].map((k) => held[k]! + dx * right[k]! + dy * up[k]!)));
    });
    for (const end of ['pointerup', 'pointercancel']) ellipse.addEventListener(end, () => { hand.release(); });
  };

  const draw = (): void => {
    if (robot === undefined) return;
    poses = robot.poses();
    set(floor, { d: floorLines(view, scale) });
    if (robot.floats) middle = extent().middle;
    const [x, y] = view.look(middle);
    const window = [x - scale, -y - scale, 2 * scale, 2 * scale];
    set(element, { viewBox: window.map((one) => one.toFixed(4)).join(' ') });
    const at = bodies.map((_, link) => {
      const [right, up] = view.look(origin(link));
      return `${right.toFixed(4)} ${(-up).toFixed(4)}`;
    });
    set(bones, { d: joints.map(([parent, child]) => `M${at[parent]!}L${at[child]!}`).join('') });
    set(knuckles, { d: at.map((point) => `M${point}h0`).join('') });
    const depths = bodies.map(({ ellipse, semiaxes, axes }, link) => {
      const place = centre(link);
      outline(ellipse, view, place, axesInWorld(poses, POSE * link, axes, 0), semiaxes, 0.03 * scale);
      return { ellipse, depth: view.look(place)[2] };
    });
    // The farthest first; an element that the user holds keeps its place in the document.
    if (layer.querySelector(':active') !== null) return;
    const order = depths.sort((a, b) => a.depth - b.depth).map((entry) => entry.ellipse);
    if (order.some((ellipse, i) => layer.children[i] !== ellipse)) layer.append(...order);
  };
  const extent = (): { middle: Vector3; reach: number } => {
    const points = bodies.map(({ heavy }, link) => (heavy ? centre(link) : origin(link)));
    const range = ([0, 1, 2] as const).map((k) => points.map((point) => point[k]));
    const centroid = vector(range.map((values) => (Math.min(...values) + Math.max(...values)) / 2));
    const reach = Math.max(...points.map((point) => Math.hypot(...point.map((x, k) => x - centroid[k]!))), 0.05);
    return { middle: centroid, reach };
  };
  const fit = (): void => {
    const { middle: at, reach } = extent();
    [middle, scale] = [at, 1.45 * reach];
    draw();
  };

  return {
    element,
    draw,
    fit,
    show(next) {
      robot = next;
      poses = robot.poses();
      joints = robot.joints().map(({ parent, child }) => [parent, child] as const);
      bodies = robot.bodies().map(({ name, mass, center, semiaxes, axes }, link) => {
        const visibility = mass > 0 ? 'visible' : 'hidden';
        const ellipse = svg('ellipse', { class: 'link grip', 'data-link': name, visibility });
        grips(ellipse, link);
        // The root mean square of the mass distribution is clearer than the ellipsoid where links overlap.
        const spread = vector(semiaxes.map((a) => a / Math.sqrt(5)));
        return { center: vector(center), semiaxes: spread, axes, ellipse, heavy: mass > 0 };
      });
      layer.replaceChildren(...bodies.map(({ ellipse }) => ellipse));
      fit();
      return Promise.resolve([]);
    },
    look(azimuth, elevation) {
      [view.azimuth, view.elevation] = [azimuth, elevation];
      draw();
    },
    layers: () => undefined,
    glow: () => undefined,
    shared: () => view.shared('camera'),
    restore(values) {
      view.restore(values, 'camera');
      draw();
    },
  };
}
