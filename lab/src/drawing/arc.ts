// Arcs of circles in a picture with y down, by angles that increase counter-clockwise.
import { short } from '../element.ts';

const MOST = 1.9 * Math.PI;

/** An arc of a given length from an angle; limited to almost a full turn. */
export function arc([x, y]: readonly [number, number], radius: number, from: number, by: number): string {
  const span = Math.max(-MOST, Math.min(MOST, by));
  const at = (angle: number): string => `${short(x + radius * Math.cos(angle))} ${short(-y - radius * Math.sin(angle))}`;
  const large = Math.abs(span) > Math.PI ? 1 : 0;
  return `M${at(from)}A${short(radius)} ${short(radius)} 0 ${String(large)} ${span > 0 ? '0' : '1'} ${at(from + span)}`;
}

/** The same with an arrowhead, if it is long enough. */
export function turning(centre: readonly [number, number], radius: number, from: number, by: number, head: number): string {
  const span = Math.max(-MOST, Math.min(MOST, by));
  if (Math.abs(span) * radius < 0.02) return '';
  const size = Math.min(head, 0.6 * Math.abs(span) * radius);
  const end = from + span;
  const back = end - (Math.sign(span) * size) / radius;
  const wing = (r: number): string =>
    `${short(centre[0] + r * Math.cos(back))} ${short(-centre[1] - r * Math.sin(back))}`;
  const tip = `${short(centre[0] + radius * Math.cos(end))} ${short(-centre[1] - radius * Math.sin(end))}`;
  return `${arc(centre, radius, from, span)}M${wing(radius + 0.55 * size)}L${tip}L${wing(radius - 0.55 * size)}`;
}

/** A sector of a disc. */
export function wedge(centre: readonly [number, number], radius: number, from: number, by: number): string {
  return `${arc(centre, radius, from, by)}L${short(centre[0])} ${short(-centre[1])}Z`;
}
