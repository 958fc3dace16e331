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
  const widgets: Widget[] = [replay(), lagrangianLab(), inertiaEllipse(), tumblingBrick(), knifeEdge(), workbench(), predictFirst(), yourRobot(), integratorRace()];
  page.replaceChildren(
    masthead(widgets),
    html('main', {}, ...widgets.map((widget) => widget.element), selfCheckPanel()),
    html('footer', {}, html('p', {}, 'Every number here is computed by the Rust library, compiled to WebAssembly. The page only draws and listens.')),
  );
  const follow = (): void => {
    const { widget: id, values } = parseAddress(location.hash);
    const widget = widgets.find((candidate) => candidate.id === id);
    if (widget === undefined) return;
    if ([...values].length > 0) widget.restore(values);
    widget.element.scrollIntoView();
  };
  follow();
  addEventListener('hashchange', follow);
  document.documentElement.dataset['ready'] = 'true';
}

void main();
