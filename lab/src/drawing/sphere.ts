// Curves on the unit sphere from one viewpoint: solid in front, faint behind.
import { set, short, svg } from '../element.ts';
import type { Vector3, View } from './view.ts';

export interface SphereCurve {
  element: SVGGElement;
  draw(view: View, points: readonly Vector3[]): void;
}

export function sphereCurve(kind: string): SphereCurve {
  const front = svg('path', { class: `curve ${kind}` });
  const back = svg('path', { class: `curve back ${kind}` });
  return {
    element: svg('g', { 'aria-hidden': 'true' }, back, front),
    draw(view, points) {
      const pieces = { front: '', back: '' };
      let side: 'front' | 'back' | undefined;
      let last = '';
      for (const point of points) {
        const [x, y, towards] = view.look(point);
        const here = `${short(x)} ${short(-y)}`;
        const now = towards >= 0 ? 'front' : 'back';
        pieces[now] += side === now ? `L${here}` : `M${last || here}L${here}`;
        [side, last] = [now, here];
      }
      set(front, { d: pieces.front });
      set(back, { d: pieces.back });
    },
  };
}
