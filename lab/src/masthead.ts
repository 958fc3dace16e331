// The top of the page: what this is, where everything is, light or dark.
import { html } from './element.ts';
import { themeChanged } from './drawing/colours.ts';
import { choice } from './controls/choice.ts';
import type { Widget } from './widgets/frame.ts';

type Theme = 'auto' | 'light' | 'dark';

export function masthead(widgets: readonly Widget[]): HTMLElement {
  const links = [...widgets, { id: 'self-checks', title: 'Self-checks' }];
  const theme = choice<Theme>('Theme', [['auto', 'As the system'], ['light', 'Light'], ['dark', 'Dark']], 'auto', (name) => {
    document.documentElement.dataset['theme'] = name;
    themeChanged();
  });
  return html(
    'header',
    { class: 'masthead' },
    html(
      'div',
      { class: 'title' },
      html('h1', {}, 'Robot dynamics lab'),
      html('p', {}, 'An arm’s dynamics is one matrix M(q) and one scalar V(q). Everything below follows from the two, and you can take hold of it.'),
    ),
    theme.element,
    html('nav', { 'aria-label': 'Experiments' }, html('ol', {}, ...links.map(({ id, title }) => html('li', {}, html('a', { href: `#${id}` }, title))))),
  );
}
