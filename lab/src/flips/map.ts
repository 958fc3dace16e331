// The map itself: each point an arm that starts at rest there, coloured by when a rod of it first points straight up.
import { onTheme } from '../drawing/colours.ts';
import { html, show } from '../element.ts';
import { fill, portions } from './refine.ts';
import { LATEST, palette } from './palette.ts';
import type { Pool } from './workers.ts';

/** Points across and down. */
export const SIZE = 512;

/** What is seen: the middle, and half the width, in angles of the two rods from where they hang [rad]. */
export interface View {
  x: number;
  y: number;
  half: number;
}

export interface FlipPicture {
  element: HTMLCanvasElement;
  /** Computes the view anew, coarse first. */
  look(view: View): void;
  /** The time of the first flip at a point of the picture, both counted from 0 to 1; NaN where it is not known yet. */
  at(across: number, down: number): number;
}

export interface Progress {
  /** Of all points. */
  share: number;
  /** Steps of one arm taken, seconds since the view was asked for, seconds until the coarse picture stood. */
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
  /** Both once a frame, however many portions came. */
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
        // From where a rod hangs, to the chapter's angles.
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

/** A time in words. */
export function flipWords(time: number): string {
  if (Number.isNaN(time)) return 'not computed yet';
  if (time < -1.5) return 'never: it has not the energy';
  if (time < 0) return `not within ${String(LATEST)} s`;
  return `${show(time, 2)} s`;
}
