// The head of the page: its title, links to the experiments, and the theme.
import { html } from './element.ts';
import { themeChanged } from './drawing/colours.ts';
import { WORDS } from './story/words.ts';
import { choice, roving } from './controls/choice.ts';

type Theme = 'auto' | 'light' | 'dark';

export function masthead(complaint: HTMLElement): HTMLElement {
  const links = [...Object.entries(WORDS).map(([id, { title }]) => [id, title] as const), ['self-checks', 'Self-checks'] as const];
  const themes = [['auto', 'System'], ['light', 'Light'], ['dark', 'Dark']] as const;
  const theme = choice<Theme>('Theme', themes, 'auto', (name) => {
    document.documentElement.dataset['theme'] = name;
    themeChanged();
  });
  const toFirst = (event: MouseEvent): void => {
    event.preventDefault();
    const heading = document.querySelector<HTMLElement>('main h2');
    heading?.focus();
    heading?.scrollIntoView();
  };
  return html(
    'header',
    { class: 'masthead' },
    html('a', { class: 'skip', href: '#', click: toFirst }, 'Skip to the experiments'),
    html(
      'div',
      { class: 'title' },
      html('h1', {}, 'Robot dynamics lab'),
      html('p', {},
        'An arm’s dynamics is one matrix M(q) and one scalar V(q). ',
        'Everything below follows from these two, and you can try it.'),
    ),
    theme.element,
    // One tab stop; arrow keys move along the list.
    roving(html('nav', { 'aria-label': 'Experiments' },
      html('ol', {}, ...links.map(([id, title]) => html('li', {}, html('a', { href: `#${id}` }, title)))))),
    complaint,
  );
}
