// The page: its head, then the module, the experiments, and what the address says. With ?only=NAME one experiment stands alone.
import address from '../wasm/chapter_bg.wasm?url';
import { load } from '../lib/dynamics/index.ts';
import { aloneFrom, parseAddress } from './address.ts';
import { html } from './element.ts';
import { masthead } from './masthead.ts';
import { selfCheckPanel } from './self-check-panel.ts';
import { EXPERIMENTS } from './experiments.ts';

async function main(): Promise<void> {
  const page = document.querySelector('#page')!;
  const only = aloneFrom(location.search);
  const theme = new URLSearchParams(location.search).get('theme');
  if (theme === 'light' || theme === 'dark') document.documentElement.dataset['theme'] = theme;
  const complaint = html('p', { class: 'message', role: 'alert' });
  const waiting = html('p', { class: 'cost' }, 'The experiments are on their way.');
  // What this is, and what there is, can be read before the physics has come.
  page.replaceChildren(...(only === undefined ? [masthead(EXPERIMENTS, complaint)] : []), waiting);
  try {
    await load(address);
  } catch (error) {
    page.append(html('p', { role: 'alert', class: 'message' }, `The physics module did not load: ${String(error)}`));
    return;
  } finally {
    waiting.remove();
  }
  const chosen = only === undefined ? EXPERIMENTS : EXPERIMENTS.filter(([id]) => id === only);
  const widgets = chosen.map(([, , make]) => make());
  if (only === undefined) {
    page.append(
      html('main', {}, ...widgets.map((widget) => widget.element), selfCheckPanel()),
      html('footer', { tabindex: -1 }, html('p', {},
        'Every number here is computed by the Rust library, compiled to WebAssembly. The page only draws and listens.')),
    );
  } else {
    document.documentElement.dataset['alone'] = only;
    document.documentElement.classList.add('alone');
    document.title = `${chosen[0]?.[1] ?? 'Nothing here'} · Robot dynamics lab`;
    const known = EXPERIMENTS.map(([id]) => id).join(', ');
    const none = html('p', { class: 'message', role: 'alert' }, `There is no experiment named “${only}”; there are ${known}.`);
    page.replaceChildren(complaint, html('main', {}, ...(widgets.length === 0 ? [none] : widgets.map((widget) => widget.element))));
  }
  const follow = (): void => {
    const { widget: id, values } = parseAddress(location.hash);
    const widget = widgets.find((candidate) => candidate.id === id);
    if (widget === undefined) return;
    try {
      if ([...values].length > 0) widget.restore(values);
      complaint.textContent = '';
    } catch (error) {
      // What an address says is not to be trusted: the experiment stays as it was.
      const why = error instanceof Error ? error.message : String(error);
      complaint.textContent = `The address could not be followed: ${why}.`;
    }
    if (only === undefined) goTo(widget.element);
  };
  follow();
  addEventListener('hashchange', follow);
  document.documentElement.dataset['ready'] = 'true';
}

/** What lies between is laid out on the way, and moves the place: until it stays. */
function goTo(place: HTMLElement, tries = 12): void {
  const before = place.getBoundingClientRect().top;
  place.scrollIntoView({ behavior: 'instant' });
  requestAnimationFrame(() => {
    if (tries > 0 && Math.abs(place.getBoundingClientRect().top - before) > 1) goTo(place, tries - 1);
  });
}

void main();
