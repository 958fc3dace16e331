// A box in space. It is convex, so only the faces towards the viewer are drawn.
import { set, short, svg } from '../element.ts';
import { rotate, vector, type Vector3, type View } from './view.ts';

const LIGHT: Vector3 = [0.35, 0.55, 0.76];

export interface BoxDrawing {
  element: SVGGElement;
  draw(view: View, rotation: ArrayLike<number>, halves: Vector3): void;
}

export function boxDrawing(): BoxDrawing {
  const faces = Array.from({ length: 6 }, (_, i) => svg('path', { class: `face axis-${String(i >> 1)}` }));
  const element = svg('g', { class: 'box', 'aria-hidden': 'true' }, ...faces);
  return {
    element,
    draw(view, rotation, halves) {
      faces.forEach((face, i) => {
        const [axis, sign] = [i >> 1, i % 2 === 0 ? 1 : -1];
        const unit = vector([0, 1, 2].map((k) => (k === axis ? sign : 0)));
        const [right, up, towards] = view.look(rotate(rotation, unit));
        if (towards <= 0) {
          face.setAttribute('visibility', 'hidden');
          return;
        }
        const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) => {
          const corner = [0, 0, 0];
          [corner[axis], corner[u], corner[v]] = [sign * halves[axis]!, a! * halves[u]!, b! * halves[v]!];
          const [x, y] = view.look(rotate(rotation, vector(corner)));
          return `${short(x)} ${short(-y)}`;
        });
        const lit = Math.max(0, right * LIGHT[0] + up * LIGHT[1] + towards * LIGHT[2]);
        set(face, { d: `M${corners.join('L')}Z`, visibility: 'visible' });
        face.style.setProperty('--lit', `${(18 + 52 * lit).toFixed(1)}%`);
      });
    },
  };
}
