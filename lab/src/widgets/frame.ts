// The layout of an experiment: title, question, picture, controls, plots, equations.
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
  /** Its plots, with timeline and downloads. */
  plots?: PlotGroup;
  /** State and parameters, for the address. */
  share: () => Shared;
  /** The state that the link does not contain, in a sentence; empty if it contains all. */
  unshared?: () => string;
}

export interface Widget {
  id: string;
  element: HTMLElement;
  /** Sets state and parameters from an address. */
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
      // The timeline is below the plots, which come first.
      ...below.slice(0, 1),
      ...(options.plots === undefined ? [] : [options.plots.element]),
      ...below.slice(1),
    ),
    equationList(equations),
  );
  remembered(element.querySelector('.bench')!, id, options.share);
  return element;
}

/** The address follows the last change here, after a pause. */
export function remembered(element: Element, id: string, shared: () => Shared): void {
  let timer = 0;
  const remember = (): void => {
    clearTimeout(timer);
    timer = window.setTimeout(() => { history.replaceState(null, '', formatAddress(id, shared())); }, 250);
  };
  for (const event of ['change', 'pointerup', 'keyup', 'settled', 'moved']) element.addEventListener(event, remember);
}

/** Sections that are on the page before their experiments. */
const outlines = new Map<Id, HTMLElement>();

/** An experiment's section while the physics is loading: all its texts, and space for the rest. */
export function outline(id: Id): HTMLElement {
  const element = worded(id);
  element.append(html('p', { class: 'outline' }, 'The experiment is on its way.'));
  outlines.set(id, element);
  return element;
}

/** An experiment's section: the existing one, or a new one. */
export function section(id: Id, ...content: HTMLElement[]): HTMLElement {
  const element = outlines.get(id) ?? worded(id);
  outlines.delete(id);
  element.querySelector('.outline')?.remove();
  element.append(...content);
  return element;
}

/** Title, story and lede, with a link past them for keyboard users. */
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
  // First the story, then the description of the experiment.
  if (passage !== undefined && !isAlone()) element.append(passage(), said);
  else header.append(said);
  return element;
}
