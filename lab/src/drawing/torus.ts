// The torus of two joint angles, cut open to a square; a curve that leaves on one side enters on the opposite
// one.
import { set, short, svg } from '../element.ts';

export interface Torus {
  element: SVGSVGElement;
  path(points: readonly (readonly [number, number])[]): void;
  point(q1: number, q2: number): void;
}

const TURN = 2 * Math.PI;

export function torus(label: string): Torus {
  const curve = svg('path', { class: 'trail' });
  const dot = svg('circle', { class: 'dot', r: 0.1 });
  const element = svg(
    'svg',
    { class: 'torus', viewBox: '-4.2 -3.5 8.4 7.3', role: 'img', 'aria-label': label },
    svg('rect', { class: 'square', x: -Math.PI, y: -Math.PI, width: TURN, height: TURN }),
    svg('path', { class: 'axes', d: `M${short(-Math.PI)} 0H${short(Math.PI)}M0 ${short(-Math.PI)}V${short(Math.PI)}` }),
    svg('text', { x: Math.PI + 0.15, y: 0.1 }, 'q₁'),
    svg('text', { x: 0, y: -Math.PI - 0.12, 'text-anchor': 'middle' }, 'q₂'),
    svg('text', { x: -Math.PI, y: Math.PI + 0.4, 'text-anchor': 'middle' }, '−π'),
    svg('text', { x: Math.PI, y: Math.PI + 0.4, 'text-anchor': 'middle' }, 'π'),
    curve,
    dot,
  );
  const within = (angle: number): number => angle - TURN * Math.round(angle / TURN);
  return {
    element,
    path(points) {
      let d = '';
      let before: readonly [number, number] | undefined;
      for (const point of points) {
        const [x, y] = [within(point[0]), within(point[1])];
        const jumps = before === undefined || Math.abs(x - before[0]) > Math.PI || Math.abs(y - before[1]) > Math.PI;
        d += `${jumps ? 'M' : 'L'}${short(x)} ${short(-y)}`;
        before = [x, y];
      }
      set(curve, { d });
    },
    point(q1, q2) {
      set(dot, { cx: within(q1), cy: -within(q2) });
    },
  };
}
