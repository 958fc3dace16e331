// The map: each point is an arm that starts at rest there, coloured by the time when a rod first points
// straight up.
import { onTheme } from '../drawing/colours.ts';
import { html, show } from '../element.ts';
import { fill, portions } from './refine.ts';
import { LATEST, palette } from './palette.ts';
import type { Pool } from './workers.ts';

/** Number of points in each direction. */
export const SIZE = 512;

/** The view: its centre and half its width, in angles of the two rods from the hanging position [rad]. */
export interface View {
  x: number;
  y: number;
  half: number;
}

export interface FlipPicture {
  element: HTMLCanvasElement;
  /** Computes the view again, coarse first. */
  look(view: View): void;
  /** The time of the first flip at a point of the picture with coordinates from 0 to 1; NaN if not yet
   * computed. */
  at(across: number, down: number): number;
}

export interface Progress {
  /** Number of computed points. */
  share: number;
  /** Number of steps of an arm, seconds since the start of the view, seconds until the coarse picture. */
  steps: number;
  seconds: number;
  coarse: number;
}

export function flipPicture(pool: (view: View) => Pool | undefined, onProgress: (progress: Progress) => void): FlipPicture {
  const canvas = html('canvas', { class: 'flips', width: SIZE, height: SIZE, 'aria-hidden': 'true' });
  const context = canvas.getContext('2d');
  const image = new ImageData(SIZE, SIZE);
  const pixels = new Uint32Array(image.data.buffer);
  let times = new Float32Array(SIZE * SIZE).fill(NaN);
  let colours = palette();
  let asked = 0;
  let used: Pool | undefined;
  let frame = 0;
  let news: Progress | undefined;
  /** Both at most once a frame, for any number of results. */
  const paint = (): void => {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      context?.putImageData(image, 0, 0);
      if (news !== undefined) onProgress(news);
      news = undefined;
    });
  };
  onTheme(() => {
    colours = palette();
    times.forEach((time, k) => { if (!Number.isNaN(time)) pixels[k] = colours.of(time); });
    paint();
  });
  const look = ({ x, y, half }: View): void => {
    used?.forget();
    const computes = used = pool({ x, y, half });
    if (computes === undefined) return;
    asked += 1;
    const mine = asked;
    times = new Float32Array(SIZE * SIZE).fill(NaN);
    const began = performance.now();
    let [known, steps, coarse, left] = [0, 0, 0, 0];
    for (const { stride, points } of portions(SIZE, computes.each)) {
      const starts = new Float64Array(2 * points.length);
      points.forEach((point, k) => {
        const inner = x + half * ((2 * ((point % SIZE) + 0.5)) / SIZE - 1);
        const outer = y - half * ((2 * (Math.floor(point / SIZE) + 0.5)) / SIZE - 1);
        // From the hanging rod to the chapter's angles.
        starts[2 * k] = inner - Math.PI / 2;
        starts[2 * k + 1] = outer - inner;
      });
      left += stride === 8 ? 1 : 0;
      void computes.flips({ starts, duration: LATEST }).then((done) => {
        if (mine !== asked) return;
        points.forEach((point, k) => {
          const time = done.times[k]!;
          times[point] = time;
          fill(pixels, SIZE, point, stride, colours.of(time), (pixel) => !Number.isNaN(times[pixel]!));
        });
        known += points.length;
        steps += done.steps;
        const seconds = (performance.now() - began) / 1000;
        if (stride === 8) {
          left -= 1;
          if (left === 0) coarse = seconds;
        }
        news = { share: known / times.length, steps, seconds, coarse };
        paint();
      });
    }
  };
  return {
    element: canvas,
    look,
    at: (across, down) => {
      const [column, row] = [across, down].map((share) => Math.min(SIZE - 1, Math.max(0, Math.floor(share * SIZE)))) as [number, number];
      return times[row * SIZE + column]!;
    },
  };
}

/** A time as text. */
export function flipWords(time: number): string {
  if (Number.isNaN(time)) return 'not computed yet';
  if (time < -1.5) return 'never: not enough energy';
  if (time < 0) return `not within ${String(LATEST)} s`;
  return `${show(time, 2)} s`;
}
