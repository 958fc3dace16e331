// The worker of the race: receives the chapter's module, then numbers of steps, and returns the state.
import { initSync, Race } from '../../wasm/chapter.js';
import { standing } from './standing.ts';

export interface Setup {
  module: WebAssembly.Module;
}

export interface Start {
  names: string[];
  /** Angles and rates [rad, rad/s], the step and the length of the race [s]. */
  q: Float64Array;
  qd: Float64Array;
  h: number;
  duration: number;
}

export interface Steps {
  steps: number;
}

let race: Race | undefined;
let count = 0;

self.onmessage = ({ data }: MessageEvent<Setup | Start | Steps>): void => {
  if ('module' in data) {
    initSync({ module: data.module });
    return;
  }
  if ('names' in data) {
    race?.free();
    race = new Race(data.names, data.q, data.qd, data.h, data.duration);
    count = data.names.length;
  } else race?.advance(data.steps);
  if (race !== undefined) self.postMessage(standing(race, count));
};
