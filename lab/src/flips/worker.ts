// A worker of the map of flips: receives the module, then starts, and returns times.
import * as portable from '../../wasm/flips.js';
import * as inRegisters from '../../wasm/flips_simd128.js';

export interface Setup {
  module: WebAssembly.Module;
  simd128: boolean;
  /** Lengths and masses of the rods, gravity, and the step [s]. */
  arm: readonly [number, number, number, number, number, number];
}

export interface Job {
  /** q₁, q₂, q₁, q₂, … [rad], from rest. */
  starts: Float64Array;
  duration: number;
}

export interface Done {
  /** First flips, in the order of the starts. */
  times: Float32Array;
  /** Number of steps of an arm. */
  steps: number;
}

let map: portable.FlipMap | inRegisters.FlipMap | undefined;

self.onmessage = ({ data }: MessageEvent<Setup | Job>): void => {
  if ('module' in data) {
    const engine = data.simd128 ? inRegisters : portable;
    engine.initSync({ module: data.module });
    map = new engine.FlipMap(...data.arm);
    return;
  }
  if (map === undefined) throw new Error('a job arrived before the module was loaded');
  const before = map.steps;
  const times = map.firstFlips(data.starts, data.duration);
  const done: Done = { times, steps: map.steps - before };
  self.postMessage(done, { transfer: [times.buffer] });
};
