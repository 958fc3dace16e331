// A race in a worker, so that minutes of motion per second do not block the page.
import address from '../../wasm/chapter_bg.wasm?url';
import type { Standing } from './standing.ts';
import RaceWorker from './worker.ts?worker&inline';
import type { Setup, Start, Steps } from './worker.ts';

export interface RaceThread {
  /** Starts again. */
  start(race: Start): void;
  /** Asks for more steps. While the worker is busy, the number of waiting steps is limited. */
  advance(steps: number): number;
}

/** Largest number of waiting steps. */
const MOST = 20_000;

/** `onStanding` is called after each start and after the requested steps. */
export async function raceThread(onStanding: (now: Standing) => void): Promise<RaceThread> {
  const response = await fetch(address);
  const module = await WebAssembly.compile(await response.arrayBuffer());
  const worker = new RaceWorker({ name: 'race' });
  const post = (message: Setup | Start | Steps): void => { worker.postMessage(message); };
  post({ module });
  // Outstanding answers, the number of them that belong to an older race, and waiting steps.
  let [open, stale, waiting] = [0, 0, 0];
  const go = (): void => {
    if (open > 0 || waiting === 0) return;
    open += 1;
    post({ steps: waiting });
    waiting = 0;
  };
  worker.onmessage = ({ data }: MessageEvent<Standing>) => {
    open -= 1;
    if (stale > 0) stale -= 1;
    else onStanding(data);
    go();
  };
  return {
    start(race) {
      [stale, waiting] = [open, 0];
      open += 1;
      post(race);
    },
    advance(steps) {
      const taken = Math.min(steps, MOST - waiting);
      waiting += taken;
      go();
      return taken;
    },
  };
}
