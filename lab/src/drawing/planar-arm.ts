// A planar arm: links, joints, trail. The picture's unit is the metre, with y up.
import { set, short, svg } from '../element.ts';

export type Point = readonly [number, number];

export interface PlanarPicture {
  element: SVGSVGElement;
  /** The group for elements in the plane. */
  plane: SVGGElement;
}

/** A square window of half-width `reach` metres around (x, y). */
export function planarPicture(label: string, reach: number, [x, y]: Point = [0, 0]): PlanarPicture {
  const plane = svg('g');
  const element = svg(
    'svg',
    {
      class: 'plane',
      viewBox: `${String(x - reach)} ${String(-y - reach)} ${String(2 * reach)} ${String(2 * reach)}`,
      role: 'group',
      'aria-label': label,
    },
    svg('line', { class: 'horizon', x1: x - reach, x2: x + reach, y1: 0, y2: 0 }),
    plane,
  );
  return { element, plane };
}

export interface ArmDrawing {
  element: SVGGElement;
  /** Points from the base outwards. */
  draw(points: readonly Point[]): void;
}

export function armDrawing(kind = ''): ArmDrawing {
  const links = svg('path', { class: `links ${kind}` });
  const joints = svg('g', { class: `joints ${kind}` });
  const element = svg('g', { 'aria-hidden': 'true' }, links, joints);
  return {
    element,
    draw(points) {
      set(links, { d: polyline(points) });
      points.slice(0, -1).forEach(([x, y], i) => {
        const joint = joints.children[i] ?? joints.appendChild(svg('circle', { r: 0.055 }));
        set(joint, { cx: x, cy: -y });
      });
    },
  };
}

export function polyline(points: readonly Point[], closed = false): string {
  const steps = points.map(([x, y], i) => `${i === 0 ? 'M' : 'L'}${short(x)} ${short(-y)}`);
  return steps.join('') + (closed ? 'Z' : '');
}

/** The last `most` points of a track given by its coordinates. */
export function track(x: ArrayLike<number>, y: ArrayLike<number>, most = Infinity): string {
  let d = '';
  for (let i = Math.max(0, x.length - most); i < x.length; i += 1) d += `${d === '' ? 'M' : 'L'}${short(x[i]!)} ${short(-y[i]!)}`;
  return d;
}

/** Base, elbow and tip from the list x, y, x, y. */
export function armPoints(flat: ArrayLike<number>): Point[] {
  return [[0, 0], [flat[0]!, flat[1]!], [flat[2]!, flat[3]!]];
}
