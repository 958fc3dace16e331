// A race on a thread of its own, so that minutes of motion a second cost the page no frame.
import address from '../../wasm/chapter_bg.wasm?url';
import type { Standing } from './standing.ts';
import RaceWorker from './worker.ts?worker&inline';
import type { Setup, Start, Steps } from './worker.ts';

export interface RaceThread {
  /** Begins anew. */
  start(race: Start): void;
  /** Goes on, by so many steps of these as it takes on: while it is busy not more than it can catch up with. */
  advance(steps: number): number;
}

/** The most steps that wait. */
const MOST = 20_000;

/** `onStanding` is told after each start and after all steps that were asked for. */
export async function raceThread(onStanding: (now: Standing) => void): Promise<RaceThread> {
  const response = await fetch(address);
  const module = await WebAssembly.compile(await response.arrayBuffer());
  const worker = new RaceWorker({ name: 'race' });
  const post = (message: Setup | Start | Steps): void => { worker.postMessage(message); };
  post({ module });
  // Answers that are still to come, how many of them are of a race that is no more, and steps that wait for them.
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
