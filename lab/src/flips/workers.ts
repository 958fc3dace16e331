// The workers that compute the map of flips: as many as the machine has processors, each with the module's registers where the browser
// has them. They share no memory, so that the page needs no headers of its server, and a single file can start them.
import portable from '../../wasm/flips_bg.wasm?url';
import simd128 from '../../wasm/flips_simd128_bg.wasm?url';
import { hasSimd128 } from '../../lib/dynamics/simd128.ts';
import FlipWorker from './worker.ts?worker&inline';
import type { Done, Job, Setup } from './worker.ts';

const MOST = 8;

/** What computes the map: these workers, or a graphics card. */
export interface Pool {
  /** How it computes, in words. */
  readonly says: string;
  /** How many starts it is best given at once. */
  readonly each: number;
  /** Times of first flips, in the order of the starts, and the steps of one arm that were taken. */
  flips(starts: Float64Array, duration: number): Promise<{ times: Float32Array; steps: number }>;
  /** What has not been begun is not done. */
  forget(): void;
}

export async function flipWorkers(arm: Setup['arm']): Promise<Pool> {
  const registers = hasSimd128();
  const response = await fetch(registers ? simd128 : portable);
  const module = await WebAssembly.compile(await response.arrayBuffer());
  const count = Math.max(1, Math.min(MOST, navigator.hardwareConcurrency || 2));
  interface Waiting { job: Job; resolve: (done: Done) => void; reject: (error: Error) => void }
  let waiting: Waiting[] = [];
  let id = 0;
  const idle: Worker[] = [];
  const next = (): void => {
    const worker = waiting.length > 0 ? idle.pop() : undefined;
    if (worker === undefined) return;
    const { job, resolve, reject } = waiting.shift()!;
    worker.onmessage = ({ data }: MessageEvent<Done>) => {
      idle.push(worker);
      resolve(data);
      next();
    };
    worker.onerror = (event) => { reject(new Error(event.message)); };
    worker.postMessage(job);
  };
  for (let k = 0; k < count; k += 1) {
    const worker = new FlipWorker({ name: `flips-${String(k)}` });
    worker.postMessage({ module, simd128: registers, arm } satisfies Setup);
    idle.push(worker);
  }
  return {
    says: `double precision; ${String(count)} ${count === 1 ? 'worker' : 'workers'}, `
      + (registers ? 'four arms at once in WebAssembly’s registers (simd128)' : 'one arm at a time: no registers here'),
    each: 1024,
    flips: (starts, duration) => new Promise((resolve, reject) => {
      id += 1;
      waiting.push({ job: { id, starts, duration }, resolve, reject });
      next();
    }),
    forget() {
      waiting = [];
    },
  };
}
