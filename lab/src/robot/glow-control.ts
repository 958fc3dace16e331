// Which term of the equation of motion the links glow by, and how much the brightest stands for.
import { wordFrom, type Shared } from '../address.ts';
import { choice } from '../controls/choice.ts';
import { html, show } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { type Glow, loadsOf, TERMS, type Term } from './terms.ts';

type Word = Term | 'off';
const WORDS: readonly (readonly [Word, string])[] = [['off', 'nothing'], ...TERMS];

export interface GlowControl {
  element: HTMLElement;
  /** For a robot that was just loaded. */
  suit(robot: Robot): void;
  /** As the robot is now; undefined where nothing is to glow. */
  now(): Glow['links'] | undefined;
  /** The brightest joint, in words. */
  write(): void;
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

/** Three digits that count, in plain figures. */
const digits = (x: number): number => Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(x))));

export function glowControl(onChange: () => void): GlowControl {
  let loads: ((term: Term) => Glow) | undefined;
  let most: Glow['most'];
  const brightest = html('span', { class: 'number', 'data-reading': 'brightest' });
  const key = html('span', { class: 'glow-key', hidden: true }, html('span', { class: 'glow-scale', 'aria-hidden': 'true' }), brightest);
  const by = choice<Word>('Links glow by', WORDS, 'off', () => {
    onChange();
    write();
  });
  const write = (): void => {
    key.hidden = by.value === 'off';
    const words = most === undefined ? 'no joint is loaded' : `${show(most.amount, digits(most.amount))} ${most.unit}, ${most.joint}`;
    if (brightest.textContent !== words) brightest.textContent = words;
  };
  return {
    element: html('div', { class: 'glow' }, by.element, key),
    suit(robot) { loads = loadsOf(robot); },
    now() {
      const glow = by.value === 'off' ? undefined : loads?.(by.value);
      most = glow?.most;
      return glow?.links;
    },
    write,
    shared: () => (by.value === 'off' ? {} : { glow: by.value }),
    restore(values) { by.set(wordFrom(values, 'glow', WORDS.map(([word]) => word), 'off')); },
  };
}
