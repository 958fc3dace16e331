// The workers that compute the map of flips, one for each processor, with vector registers if the browser
// supports them. They share no memory, so the page needs no special headers and works as a single file.
import portable from '../../wasm/flips_bg.wasm?url';
import simd128 from '../../wasm/flips_simd128_bg.wasm?url';
import { hasSimd128 } from '../../lib/dynamics/simd128.ts';
import { queue } from './queue.ts';
import FlipWorker from './worker.ts?worker&inline';
import type { Done, Job, Setup } from './worker.ts';

const MOST = 8;

/** The means of computing the map: these workers, or a graphics card. */
export interface Pool {
  /** A description for the page. */
  readonly says: string;
  /** Best number of starts in one call. */
  readonly each: number;
  flips(job: Job): Promise<Done>;
  /** Drops the jobs that have not started. */
  forget(): void;
}

export async function flipWorkers(arm: Setup['arm']): Promise<Pool> {
  const registers = hasSimd128();
  const response = await fetch(registers ? simd128 : portable);
  const module = await WebAssembly.compile(await response.arrayBuffer());
  const count = Math.max(1, Math.min(MOST, navigator.hardwareConcurrency || 2));
  const runners = Array.from({ length: count }, (_, k) => {
    const worker = new FlipWorker({ name: `flips-${String(k)}` });
    worker.postMessage({ module, simd128: registers, arm } satisfies Setup);
    const asked: { resolve: (done: Done) => void; reject: (error: Error) => void }[] = [];
    worker.onmessage = ({ data }: MessageEvent<Done>) => { asked.shift()?.resolve(data); };
    worker.onerror = (event) => { asked.splice(0).forEach(({ reject }) => { reject(new Error(event.message)); }); };
    return (job: Job) => new Promise<Done>((resolve, reject) => {
      asked.push({ resolve, reject });
      worker.postMessage(job);
    });
  });
  // Each worker has its next job early, so that none waits for the page.
  const { run, forget } = queue([...runners, ...runners]);
  return {
    says: `double precision; ${String(count)} ${count === 1 ? 'worker' : 'workers'}, `
      + (registers ? 'four arms at once in vector registers (simd128)' : 'one arm at a time, without vector registers'),
    each: 1024,
    flips: run,
    forget,
  };
}
