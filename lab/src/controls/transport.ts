// Play, pause, single step, reset and speed, and messages of failed runs.
import { numberFrom, type Shared } from '../address.ts';
import { Accumulator, Frames } from '../clock.ts';
import { html, show } from '../element.ts';
import { button, roving } from './choice.ts';
import { slider } from './slider.ts';

export interface Run {
  /** The physics step in seconds. */
  step: () => number;
  /** Advances by whole steps; throws with a message if the motion fails. */
  advance: (steps: number) => void;
  /** Draws the state. `beat` counts frames while it plays: pictures change in every frame, numbers in every
   * sixth. It is 0 if everything is to be drawn. */
  draw: (beat: number) => void;
  reset: () => void;
  /** Describes the state in a sentence, announced when the run pauses. */
  describe: () => string;
  /** Number of steps of the button "Step". */
  single?: number;
  /** The largest and the initial playback speed; 4 and 1 by default. */
  fastest?: number;
  usual?: number;
  /** The elements of which one must be visible for the run to go on; by default its picture, controls and
   * plots. */
  picture?: Element;
}

export interface Transport {
  element: HTMLElement;
  readonly playing: boolean;
  readonly speed: number;
  play(): void;
  pause(): void;
  setSpeed(speed: number): void;
  /** Its part of the address: the playback speed if it is not the default. */
  shared(): Shared;
  restore(values: URLSearchParams): void;
  /** Shows a message and pauses; an empty message clears it. */
  say(message: string): void;
}

const calm = (): boolean => matchMedia('(prefers-reduced-motion: reduce)').matches;

export function transport(run: Run, autoplay = false): Transport {
  const accumulator = new Accumulator();
  const { fastest = 4, usual = 1 } = run;
  let speed = usual;
  let cost = { physics: 0, all: 0, frames: 0 };
  let beat = 0;
  const message = html('p', { class: 'message', role: 'alert' });
  const status = html('p', { class: 'visually-hidden', 'aria-live': 'polite' });
  const spent = html('span', { class: 'cost' });

  const guarded = (work: () => void): void => {
    try {
      work();
    } catch (error) {
      say(error instanceof Error ? error.message : String(error));
    }
    run.draw(wanted ? beat : 0);
  };
  const frames = new Frames((elapsed) => {
    const steps = accumulator.steps(elapsed, speed, run.step());
    beat += 1;
    const before = performance.now();
    let physics = 0;
    guarded(() => {
      run.advance(steps);
      physics = performance.now() - before;
    });
    count(physics, performance.now() - before);
  });
  const count = (physics: number, all: number): void => {
    cost = { physics: cost.physics + physics, all: cost.all + all, frames: cost.frames + 1 };
    if (cost.frames < 60) return;
    const mean = cost.physics / cost.frames;
    element.dataset['physicsMs'] = mean.toFixed(4);
    element.dataset['frameMs'] = (cost.all / cost.frames).toFixed(4);
    spent.textContent = `physics ${show(mean, 2)} ms a frame`;
    cost = { physics: 0, all: 0, frames: 0 };
  };
  const playButton = button('Play', () => {
    if (wanted) pause();
    else play();
  }, 'primary');
  const stepButton = button('Step', () => {
    pause();
    guarded(() => { run.advance(run.single ?? 1); });
    status.textContent = run.describe();
  });
  const resetButton = button('Reset', () => {
    say('');
    accumulator.reset();
    guarded(run.reset);
    status.textContent = run.describe();
  });
  const pace = slider({
    label: 'Speed', unit: '×', min: fastest / 80, max: fastest, step: fastest / 80, value: usual,
    onInput: (value) => { speed = value; },
  });
  const element = html(
    'div',
    { class: 'transport' },
    roving(html('div', { class: 'buttons', role: 'toolbar', 'aria-label': 'Run' }, playButton, stepButton, resetButton)),
    pace.element,
    spent,
    message,
    status,
  );

  // A run without a visible element pauses.
  let wanted = autoplay && !calm();
  let seen = false;
  const sync = (): void => {
    if (wanted && seen) frames.start();
    else frames.stop();
    playButton.textContent = wanted ? 'Pause' : 'Play';
  };
  let watched = run.picture ?? element;
  const sight = new IntersectionObserver((entries) => {
    // Several entries may arrive at once; the last is the current state.
    seen = entries.at(-1)?.isIntersecting ?? false;
    sync();
    // The controls are created before their container, since on a phone the picture can be visible without
    // them.
    const bench = element.closest('.bench');
    if (run.picture !== undefined || bench === null || bench === watched) return;
    sight.unobserve(watched);
    watched = bench;
    sight.observe(watched);
  }, { rootMargin: '80px' });
  sight.observe(watched);

  const play = (): void => {
    say('');
    wanted = true;
    sync();
  };
  const pause = (): void => {
    if (!wanted) return;
    wanted = false;
    sync();
    run.draw(0);
    element.dispatchEvent(new Event('settled', { bubbles: true }));
    status.textContent = run.describe();
  };
  const say = (text: string): void => {
    message.textContent = text;
    if (text !== '') pause();
  };
  sync();
  return {
    element,
    get playing() { return wanted; },
    get speed() { return speed; },
    play,
    pause,
    setSpeed(value) { speed = value; pace.set(value); },
    shared: () => (speed === usual ? {} : { speed }),
    restore(values) {
      const asked = numberFrom(values, 'speed', usual);
      speed = Math.min(fastest, Math.max(fastest / 80, asked));
      pace.set(speed);
    },
    say,
  };
}
