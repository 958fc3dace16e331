// The outline of a distant ellipsoid: an ellipse.
import { set } from '../element.ts';
import { rotate, type Vector3, type View } from './view.ts';

/** Places an SVG ellipse at the projection of an ellipsoid with semi-axes along the columns of a rotation. */
export function outline(
  ellipse: SVGEllipseElement,
  view: View,
  centre: Vector3,
  columns: readonly Vector3[],
  semiAxes: Vector3,
  least: number,
): void {
  // The projection is {x : xᵀS⁻¹x ≤ 1} with S = Σ aₖ² pₖpₖᵀ, where pₖ are the projected axes.
  let [xx, xy, yy] = [0, 0, 0];
  columns.forEach((column, k) => {
    const [x, y] = view.look(column);
    const square = semiAxes[k]! * semiAxes[k]!;
    xx += square * x * x;
    xy += square * x * y;
    yy += square * y * y;
  });
  const [mean, half] = [(xx + yy) / 2, Math.hypot((xx - yy) / 2, xy)];
  const angle = 0.5 * Math.atan2(2 * xy, xx - yy);
  const [x, y] = view.look(centre);
  set(ellipse, {
    rx: Math.max(least, Math.sqrt(mean + half)),
    ry: Math.max(least, Math.sqrt(Math.max(0, mean - half))),
    transform: `translate(${x.toFixed(4)} ${(-y).toFixed(4)}) rotate(${((-angle * 180) / Math.PI).toFixed(2)})`,
  });
}

/** The columns of R·Q, both in row-major order in flat lists. */
export function axesInWorld(rotation: ArrayLike<number>, at: number, inner: ArrayLike<number>, innerAt: number): Vector3[] {
  return [0, 1, 2].map((k) => rotate(rotation, [inner[innerAt + k]!, inner[innerAt + 3 + k]!, inner[innerAt + 6 + k]!], at));
}
