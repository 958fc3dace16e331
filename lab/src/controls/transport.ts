// Play, pause, single step, reset, speed; and what happens when a run fails.
import { numberFrom, type Shared } from '../address.ts';
import { Accumulator, Frames } from '../clock.ts';
import { html, show } from '../element.ts';
import { button, roving } from './choice.ts';
import { slider } from './slider.ts';

export interface Run {
  /** The physics step in seconds. */
  step: () => number;
  /** Whole steps forward; throws with a plain message when the motion fails. */
  advance: (steps: number) => void;
  /** Draws the state. `beat` counts frames while it plays: a picture moves with every one, numbers can be read at every sixth.
   * It is 0 whenever all is to be drawn. */
  draw: (beat: number) => void;
  reset: () => void;
  /** The state in a sentence, spoken when the run pauses. */
  describe: () => string;
  /** Steps that the button "Step" takes. */
  single?: number;
  /** The fastest that the speed slider goes, and where it starts; 4 and 1 unless said. */
  fastest?: number;
  usual?: number;
  /** What must be in sight for it to run; unless said, anything of its picture, its controls and its plots. */
  picture?: Element;
}

export interface Transport {
  element: HTMLElement;
  readonly playing: boolean;
  readonly speed: number;
  play(): void;
  pause(): void;
  setSpeed(speed: number): void;
  /** Its part of the address: the playback speed, where it is not the usual one. */
  shared(): Shared;
  restore(values: URLSearchParams): void;
  /** Shows a message and pauses; an empty one clears it. */
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

  // A run that nobody sees rests.
  let wanted = autoplay && !calm();
  let seen = false;
  const sync = (): void => {
    if (wanted && seen) frames.start();
    else frames.stop();
    playButton.textContent = wanted ? 'Pause' : 'Play';
  };
  let watched = run.picture ?? element;
  const sight = new IntersectionObserver((entries) => {
    // Several may come at once: the last is how things are.
    seen = entries.at(-1)?.isIntersecting ?? false;
    sync();
    // The controls are made before what they stand in: on a phone the picture can be seen without them.
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
