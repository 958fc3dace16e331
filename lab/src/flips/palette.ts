// Colours of first flips: light for early, dark for late, by the logarithm of the time, from the page's
// colours.
import { colour } from '../drawing/colours.ts';

/** The range of the scale [s]. */
export const SOONEST = 0.4;
export const LATEST = 20;
const SHADES = 256;

export interface Palette {
  /** The pixel of a time: −1 for a flip after the end, −2 for never. */
  of(time: number): number;
}

type Rgb = readonly [number, number, number];

function rgb(name: Parameters<typeof colour>[0]): Rgb {
  const found = (colour(name).match(/[\d.]+/g) ?? []).map(Number);
  return [found[0] ?? 0, found[1] ?? 0, found[2] ?? 0];
}

function pixel([r, g, b]: Rgb): number {
  // Little-endian: alpha is the highest byte.
  return ((255 << 24) | (Math.round(b) << 16) | (Math.round(g) << 8) | Math.round(r)) >>> 0;
}

export function palette(): Palette {
  const stops = (['panel', 'accent', 'second', 'ink'] as const).map(rgb);
  const shades = Uint32Array.from({ length: SHADES }, (_, k) => {
    const at = (k / (SHADES - 1)) * (stops.length - 1);
    const [from, to] = [stops[Math.floor(at)]!, stops[Math.min(stops.length - 1, Math.floor(at) + 1)]!];
    const mix = (i: 0 | 1 | 2): number => from[i] + (to[i] - from[i]) * (at - Math.floor(at));
    return pixel([mix(0), mix(1), mix(2)]);
  });
  const [never, late] = [pixel(rgb('line')), pixel(rgb('ink'))];
  const range = Math.log(LATEST / SOONEST);
  return {
    of(time) {
      if (time < -1.5) return never;
      if (time < 0) return late;
      const share = Math.log(Math.max(time, SOONEST) / SOONEST) / range;
      return shades[Math.min(SHADES - 1, Math.floor(share * SHADES))]!;
    },
  };
}
