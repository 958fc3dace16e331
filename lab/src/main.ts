// The page: first its texts, then the physics, the experiments, and the state in the address. With ?only=NAME
// it shows one experiment.
import address from '../wasm/chapter_bg.wasm?url';
import { load } from '../lib/dynamics/index.ts';
import { aloneFrom, parseAddress } from './address.ts';
import { html } from './element.ts';
import { masthead } from './masthead.ts';
import { type Id, WORDS } from './story/words.ts';
import { outline } from './widgets/frame.ts';

const IDS = Object.keys(WORDS) as Id[];

async function main(): Promise<void> {
  const page = document.querySelector('#page')!;
  const only = aloneFrom(location.search);
  const theme = new URLSearchParams(location.search).get('theme');
  if (theme === 'light' || theme === 'dark') document.documentElement.dataset['theme'] = theme;
  const complaint = html('p', { class: 'message', role: 'alert' });
  const chosen = only === undefined ? IDS : IDS.filter((id) => id === only);
  const none = html('p', { class: 'message', role: 'alert' }, `There is no experiment named “${only ?? ''}”; there are ${IDS.join(', ')}.`);
  // All texts are in place before the physics is loaded.
  const experiments = html('main', {}, ...(chosen.length === 0 ? [none] : chosen.map(outline)));
  if (only === undefined) {
    page.replaceChildren(masthead(complaint), experiments);
  } else {
    document.documentElement.dataset['alone'] = only;
    document.documentElement.classList.add('alone');
    document.title = `${chosen[0] === undefined ? 'Not found' : WORDS[chosen[0]].title} · Robot dynamics lab`;
    page.replaceChildren(complaint, experiments);
  }
  let makers: typeof import('./experiments.ts');
  try {
    [makers] = await Promise.all([import('./experiments.ts'), load(address)]);
  } catch (error) {
    complaint.textContent = `The experiments did not load: ${String(error)}`;
    return;
  }
  const widgets = chosen.map((id) => makers.EXPERIMENTS[id]());
  if (only === undefined) {
    experiments.append(makers.selfCheckPanel());
    page.append(html('footer', { tabindex: -1 }, html('p', {},
      'Every number here is computed by the Rust library, compiled to WebAssembly. The page only draws and handles input.')));
  }
  const follow = (): void => {
    const { widget: id, values } = parseAddress(location.hash);
    const widget = widgets.find((candidate) => candidate.id === id);
    if (widget === undefined) return;
    try {
      if ([...values].length > 0) widget.restore(values);
      complaint.textContent = '';
    } catch (error) {
      // An address may be invalid; the experiment then keeps its state.
      const why = error instanceof Error ? error.message : String(error);
      complaint.textContent = `The address is invalid: ${why}.`;
    }
    if (only === undefined) goTo(widget.element);
  };
  follow();
  addEventListener('hashchange', follow);
  document.documentElement.dataset['ready'] = 'true';
}

/** Scrolls to an element. Elements on the way get their layout and move it, so this repeats until it stays.
 */
function goTo(place: HTMLElement, tries = 12): void {
  const before = place.getBoundingClientRect().top;
  place.scrollIntoView({ behavior: 'instant' });
  requestAnimationFrame(() => {
    if (tries > 0 && Math.abs(place.getBoundingClientRect().top - before) > 1) goTo(place, tries - 1);
  });
}

void main();
