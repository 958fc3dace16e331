// The frame that every experiment sits in: title, question, picture, controls, plots, equations.
import { formatAddress, isAlone, type Shared } from '../address.ts';
import { shareRow } from '../controls/share.ts';
import type { PlotGroup } from '../drawing/plot-group.ts';
import { html } from '../element.ts';
import { equationList, type Equation } from './equations.ts';

export interface FrameOptions {
  id: string;
  title: string;
  lede: string;
  picture: Element[];
  controls: Element[];
  below?: HTMLElement[];
  equations: Equation[];
  /** Its plots, to go along and to take away. */
  plots?: PlotGroup;
  /** State and parameters, for the address. */
  share: () => Shared;
  /** The passage of the story that leads to it; left out where the experiment stands alone. */
  passage?: () => HTMLElement;
  /** What the link cannot carry, in a sentence; empty where it carries all. */
  unshared?: () => string;
}

export interface Widget {
  id: string;
  element: HTMLElement;
  /** Takes state and parameters from an address. */
  restore(values: URLSearchParams): void;
}

export function frame(options: FrameOptions): HTMLElement {
  const { id, title, lede, picture, controls, below = [], equations } = options;
  const story = options.passage === undefined || isAlone() ? [] : [options.passage()];
  const element = section(id, title, lede,
    html(
      'div',
      { class: 'bench' },
      html('div', { class: 'picture' }, ...picture),
      html('div', { class: 'controls' }, ...controls, shareRow(id, title, options.share, options)),
      ...below,
      ...(options.plots === undefined ? [] : [options.plots.element]),
    ),
    equationList(equations),
  );
  // First the story, then what the experiment is.
  if (story.length > 0) element.querySelector('header')?.after(...story, element.querySelector('.lede')!);
  remembered(element.querySelector('.bench')!, id, options.share);
  return element;
}

/** The address follows whatever was last touched here, once the hand rests. */
export function remembered(element: Element, id: string, shared: () => Shared): void {
  let timer = 0;
  const remember = (): void => {
    clearTimeout(timer);
    timer = window.setTimeout(() => { history.replaceState(null, '', formatAddress(id, shared())); }, 250);
  };
  for (const event of ['change', 'pointerup', 'keyup', 'settled', 'moved']) element.addEventListener(event, remember);
}

/** An experiment's section, with a way past it for those who go by keys. */
export function section(id: string, title: string, lede: string, ...content: HTMLElement[]): HTMLElement {
  const past = html('a', { class: 'skip', href: '#', click: (event: MouseEvent) => {
    event.preventDefault();
    const next = element.nextElementSibling;
    const heading = next?.querySelector<HTMLElement>('h2') ?? document.querySelector<HTMLElement>('footer');
    heading?.focus();
    heading?.scrollIntoView();
  } }, `Skip “${title}”`);
  const element = html(
    'section',
    { id, class: 'widget', 'aria-labelledby': `${id}-title` },
    past,
    html('header', {}, html('h2', { id: `${id}-title`, tabindex: -1 }, title), html('p', { class: 'lede' }, lede)),
    ...content,
  );
  return element;
}

