// The term of the equation of motion that sets the brightness of links, and the value of the brightest.
import { wordFrom, type Shared } from '../address.ts';
import { choice } from '../controls/choice.ts';
import { html, show } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { type Glow, loadsOf, TERMS, type Term } from './terms.ts';

type Word = Term | 'off';
const WORDS: readonly (readonly [Word, string])[] = [['off', 'nothing'], ...TERMS];

export interface GlowControl {
  element: HTMLElement;
  /** For a newly loaded robot. */
  suit(robot: Robot): void;
  /** The current brightnesses; undefined for none. */
  now(): Glow['links'] | undefined;
  /** The joint with the largest load, as text. */
  write(): void;
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

/** Three significant digits without an exponent. */
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
