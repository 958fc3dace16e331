// The frame that every experiment sits in: title, question, picture, controls, plots, equations.
import { formatAddress, isAlone, type Shared } from '../address.ts';
import { shareRow } from '../controls/share.ts';
import type { PlotGroup } from '../drawing/plot-group.ts';
import { html, tied } from '../element.ts';
import { type Id, WORDS, type Words } from '../story/words.ts';
import { equationList, type Equation } from './equations.ts';

export interface FrameOptions {
  id: Id;
  picture: Element[];
  controls: Element[];
  below?: HTMLElement[];
  equations: Equation[];
  /** Its plots, to go along and to take away. */
  plots?: PlotGroup;
  /** State and parameters, for the address. */
  share: () => Shared;
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
  const { id, picture, controls, below = [], equations } = options;
  const element = section(id,
    html(
      'div',
      { class: 'bench' },
      html('div', { class: 'picture' }, ...picture),
      html('div', { class: 'controls' }, ...controls, shareRow(id, WORDS[id].title, options.share, options)),
      // The timeline stands below the plots, which come first.
      ...below.slice(0, 1),
      ...(options.plots === undefined ? [] : [options.plots.element]),
      ...below.slice(1),
    ),
    equationList(equations),
  );
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

/** Sections that stand on the page before their experiments. */
const outlines = new Map<Id, HTMLElement>();

/** An experiment's section while the physics is on its way: all of its words, and room for the rest. */
export function outline(id: Id): HTMLElement {
  const element = worded(id);
  element.append(html('p', { class: 'outline' }, 'The experiment is on its way.'));
  outlines.set(id, element);
  return element;
}

/** An experiment's section: what stands on the page already, or a new one. */
export function section(id: Id, ...content: HTMLElement[]): HTMLElement {
  const element = outlines.get(id) ?? worded(id);
  outlines.delete(id);
  element.querySelector('.outline')?.remove();
  element.append(...content);
  return element;
}

/** Title, story and lede, with a way past it all for those who go by keys. */
function worded(id: Id): HTMLElement {
  const { title, lede, passage }: Words = WORDS[id];
  const past = html('a', { class: 'skip', href: '#', click: (event: MouseEvent) => {
    event.preventDefault();
    const next = element.nextElementSibling;
    const heading = next?.querySelector<HTMLElement>('h2') ?? document.querySelector<HTMLElement>('footer');
    heading?.focus();
    heading?.scrollIntoView();
  } }, `Skip “${title}”`);
  const said = html('p', { class: 'lede' }, tied(lede));
  const header = html('header', {}, html('h2', { id: `${id}-title`, tabindex: -1 }, title));
  const element = html('section', { id, class: `widget ${id}`, 'aria-labelledby': `${id}-title` }, past, header);
  // First the story, then what the experiment is.
  if (passage !== undefined && !isAlone()) element.append(passage(), said);
  else header.append(said);
  return element;
}
