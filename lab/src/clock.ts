// Converts real time to whole steps of a fixed size. The remainder is kept, and long pauses are skipped.

/** Largest real time of one frame in seconds, so that a suspended tab does not race afterwards. */
const LONGEST_FRAME = 0.1;

/** Largest number of steps of one frame: with a tiny step the motion slows down and the page stays
 * responsive. */
const MOST_STEPS = 4000;

export class Accumulator {
  private owed = 0;

  /** The number of steps of `step` seconds that are due after `elapsed` real seconds at a speed. */
  steps(elapsed: number, speed: number, step: number): number {
    this.owed += Math.min(Math.max(elapsed, 0), LONGEST_FRAME) * speed;
    const due = Math.floor(this.owed / step + 1e-9);
    if (due > MOST_STEPS) {
      this.owed = 0;
      return MOST_STEPS;
    }
    this.owed = Math.max(0, this.owed - due * step);
    return due;
  }

  reset(): void {
    this.owed = 0;
  }
}

/** Calls back once a frame while running, with the real seconds since the last frame. */
export class Frames {
  private handle = 0;
  private last = 0;

  constructor(private readonly onFrame: (elapsed: number) => void) {}

  get running(): boolean {
    return this.handle !== 0;
  }

  start(): void {
    if (this.running) return;
    this.last = performance.now();
    const tick = (): void => {
      const now = performance.now();
      const elapsed = (now - this.last) / 1000;
      this.last = now;
      this.handle = requestAnimationFrame(tick);
      this.onFrame(elapsed);
    };
    this.handle = requestAnimationFrame(tick);
  }

  stop(): void {
    cancelAnimationFrame(this.handle);
    this.handle = 0;
  }
}
