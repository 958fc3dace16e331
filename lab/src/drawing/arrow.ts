// An arrow in a picture.
import { set, short, svg } from '../element.ts';

export interface Arrow {
  element: SVGGElement;
  /** From and to in the picture's units (y down). */
  draw(from: readonly [number, number], to: readonly [number, number]): void;
}

export function arrow(kind: string, name: string, head = 0.09): Arrow {
  const line = svg('path', { class: 'shaft' });
  const text = svg('text', { 'text-anchor': 'middle', 'dominant-baseline': 'central' }, name);
  const element = svg('g', { class: `arrow ${kind}`, 'aria-hidden': 'true' }, line, text);
  return {
    element,
    draw([x0, y0], [x1, y1]) {
      const length = Math.hypot(x1 - x0, y1 - y0);
      element.setAttribute('visibility', length < 1e-3 ? 'hidden' : 'visible');
      if (length < 1e-3) return;
      const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
      const size = Math.min(head, length / 2);
      const wing = (side: number): string => `${short(x1 - size * (ux + side * 0.5 * uy))} ${short(y1 - size * (uy - side * 0.5 * ux))}`;
      set(line, { d: `M${short(x0)} ${short(y0)}L${short(x1)} ${short(y1)}M${wing(1)}L${short(x1)} ${short(y1)}L${wing(-1)}` });
      set(text, { x: x1 + 1.7 * head * ux, y: y1 + 1.3 * head * uy });
    },
  };
}
