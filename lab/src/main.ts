// The page: load the module, build the experiments, follow the address.
import address from '../wasm/chapter_bg.wasm?url';
import { load } from '../lib/dynamics/index.ts';
import { parseAddress } from './address.ts';
import { html } from './element.ts';
import { masthead } from './masthead.ts';
import { selfCheckPanel } from './self-check-panel.ts';
import type { Widget } from './widgets/frame.ts';
import { inertiaEllipse } from './widgets/inertia-ellipse.ts';
import { integratorRace } from './widgets/integrator-race.ts';
import { knifeEdge } from './widgets/knife-edge.ts';
import { lagrangianLab } from './widgets/lagrangian-lab.ts';
import { predictFirst } from './widgets/predict-first.ts';
import { replay } from './widgets/replay.ts';
import { tumblingBrick } from './widgets/tumbling-brick.ts';
import { workbench } from './widgets/workbench.ts';
import { yourRobot } from './widgets/your-robot.ts';

async function main(): Promise<void> {
  const page = document.querySelector('#page')!;
  try {
    await load(address);
  } catch (error) {
    page.append(html('p', { role: 'alert', class: 'message' }, `The physics module did not load: ${String(error)}`));
    return;
  }
  // The questions come before what answers them.
  const widgets: Widget[] = [
    predictFirst(), replay(), lagrangianLab(), inertiaEllipse(), tumblingBrick(), knifeEdge(), workbench(), yourRobot(),
    integratorRace(),
  ];
  // One experiment alone, as pages of the guide show it: index.html?only=knife-edge.
  const only = new URLSearchParams(location.search).get('only');
  const alone = widgets.find((widget) => widget.id === only);
  document.documentElement.classList.toggle('alone', alone !== undefined);
  page.replaceChildren(...(alone !== undefined ? [html('main', {}, alone.element)] : [
    masthead(widgets),
    html('main', {}, ...widgets.map((widget) => widget.element), selfCheckPanel()),
    html('footer', { tabindex: -1 }, html('p', {},
      'Every number here is computed by the Rust library, compiled to WebAssembly. The page only draws and listens.')),
  ]));
  const complaint = html('p', { class: 'message', role: 'alert' });
  page.querySelector('.masthead')?.append(complaint);
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
    goTo(widget.element);
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
