// The frame that every experiment sits in: title, question, picture, controls, plots, equations.
import { formatAddress, type Shared } from '../address.ts';
import { button } from '../controls/choice.ts';
import { html } from '../element.ts';
import mathml from '../equations.tex';

export interface Equation {
  /** Its name in equations.tex. */
  name: string;
  /** The Rust function that computes it. */
  code: string;
  says: string;
}

export interface FrameOptions {
  id: string;
  title: string;
  lede: string;
  picture: Element[];
  controls: Element[];
  below?: HTMLElement[];
  equations: Equation[];
  /** State and parameters, for the address. */
  share: () => Shared;
  /** What the link cannot carry, in a sentence; empty where it carries all. */
  unshared?: () => string;
}

export interface Widget {
  id: string;
  title: string;
  element: HTMLElement;
  /** Takes state and parameters from an address. */
  restore(values: URLSearchParams): void;
}

export function frame(options: FrameOptions): HTMLElement {
  const { id, title, lede, picture, controls, below = [], equations } = options;
  const address = (): string => formatAddress(id, options.share());
  const copied = html('span', { class: 'copied', 'aria-live': 'polite' });
  const share = button('Copy link to this state', () => {
    history.replaceState(null, '', address());
    const but = options.unshared?.() ?? '';
    const said = (text: string): void => { copied.textContent = but === '' ? text : `${text}. ${but}`; };
    navigator.clipboard.writeText(location.href).then(
      () => { said('copied'); },
      () => { said('the link is in the address bar'); },
    );
  }, 'quiet');
  const element = section(id, title, lede,
    html(
      'div',
      { class: 'bench' },
      html('div', { class: 'picture' }, ...picture),
      html('div', { class: 'controls' }, ...controls, html('p', { class: 'share' }, share, copied)),
      ...below,
    ),
    equationList(equations),
  );
  // The address follows whatever was last touched here, once the hand rests.
  let timer = 0;
  const remember = (): void => {
    clearTimeout(timer);
    timer = window.setTimeout(() => { history.replaceState(null, '', address()); }, 250);
  };
  for (const event of ['change', 'pointerup', 'keyup', 'settled']) {
    element.querySelector('.bench')?.addEventListener(event, remember);
  }
  return element;
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

function equationList(equations: Equation[]): HTMLElement {
  const rows = equations.map(({ name, code, says }) => {
    const math = html('span', { class: 'math' });
    const source = mathml[name];
    if (source === undefined) throw new Error(`no equation is named ${name}`);
    math.innerHTML = source;
    // A long formula on a narrow screen scrolls, and then the keyboard must reach it.
    new ResizeObserver(() => {
      if (math.scrollWidth > math.clientWidth) math.tabIndex = 0;
      else math.removeAttribute('tabindex');
    }).observe(math);
    return html('li', {}, math, html('span', { class: 'says' }, says), html('code', {}, code));
  });
  return html('ul', { class: 'equations', 'aria-label': 'Equations, and the Rust function that computes each' }, ...rows);
}
