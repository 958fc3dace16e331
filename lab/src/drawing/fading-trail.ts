// The past positions of a point, as a line that fades with age.
import { set, short, svg } from '../element.ts';

const PIECES = 6;

export interface FadingTrail {
  element: SVGGElement;
  /** Oldest first. */
  draw(x: ArrayLike<number>, y: ArrayLike<number>): void;
}

export function fadingTrail(): FadingTrail {
  const pieces = Array.from({ length: PIECES }, (_, k) => svg('path', { class: 'fading', 'stroke-opacity': (k + 1) / PIECES }));
  return {
    element: svg('g', { 'aria-hidden': 'true' }, ...pieces),
    draw(x, y) {
      const each = Math.ceil(x.length / PIECES);
      pieces.forEach((piece, k) => {
        // The last piece ends at the current point; each starts where the previous one ended.
        const end = x.length - (PIECES - 1 - k) * each;
        let d = '';
        for (let i = Math.max(0, end - each - 1); i < end; i += 1) d += `${d === '' ? 'M' : 'L'}${short(x[i]!)} ${short(-y[i]!)}`;
        set(piece, { d });
      });
    },
  };
}
