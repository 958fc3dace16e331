// Angles for display and for handles.

/** The angle in (−π, π]. */
export function wrap(angle: number): number {
  const turns = angle / (2 * Math.PI);
  return angle - 2 * Math.PI * Math.ceil(turns - 0.5);
}
