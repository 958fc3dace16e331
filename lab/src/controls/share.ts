// Sharing of an experiment: a link to its state, and HTML that embeds it in another page.
import { aloneAddress, formatAddress, isAlone, type Shared } from '../address.ts';
import { download, type PlotGroup } from '../drawing/plot-group.ts';
import { html } from '../element.ts';
import { button, roving } from './choice.ts';
import { filmButton } from './film.ts';

/** Size of the frame: enough for the picture with its controls beside it. */
const HEIGHT = 760;

export interface Shares {
  /** The part of the state that the link does not contain. */
  unshared?: () => string;
  /** Plots whose numbers and picture can be saved. */
  plots?: PlotGroup;
}

export function shareRow(id: string, title: string, shared: () => Shared, { unshared = () => '', plots }: Shares = {}): HTMLElement {
  const said = html('span', { class: 'copied', 'aria-live': 'polite' });
  const code = html('textarea', {
    class: 'embed-code', rows: 3, readonly: true, hidden: true, 'aria-label': `HTML that embeds “${title}”`,
  });
  const say = (text: string): void => {
    const but = unshared();
    said.textContent = but === '' ? text : `${text}. ${but}`;
  };
  const link = button('Copy link to this state', () => {
    code.hidden = true;
    history.replaceState(null, '', formatAddress(id, shared()));
    navigator.clipboard.writeText(location.href).then(
      () => { say('copied'); },
      () => { say('the link is in the address bar'); },
    );
  }, 'quiet');
  const embed = button('Embed', () => {
    const address = aloneAddress(location.href, id, shared());
    // The browser escapes the attributes.
    code.value = html('iframe', {
      src: address, title, width: '100%', height: HEIGHT, loading: 'lazy', style: 'border: 0',
    }).outerHTML;
    code.hidden = false;
    code.select();
    navigator.clipboard.writeText(code.value).then(
      () => { say('copied: HTML for a web page'); },
      () => { say('HTML for a web page'); },
    );
  }, 'quiet');
  const files = plots === undefined ? [] : [
    button('CSV', () => {
      download(`${id}.csv`, new Blob([plots.csv()], { type: 'text/csv' }));
      said.textContent = 'the plots’ numbers';
    }, 'quiet'),
    button('PNG', () => {
      void plots.png().then((picture) => { download(`${id}.png`, picture); });
      said.textContent = 'the plots’ picture';
    }, 'quiet'),
    filmButton({
      begin: () => {
        said.textContent = 'the plots are recorded while the experiment runs';
        return plots.film();
      },
      end: () => {
        plots.endFilm();
        said.textContent = 'the plots’ video';
      },
      name: () => id, title: 'Video', kind: 'quiet',
    }),
  ];
  const row = roving(html('div', { class: 'share-buttons', role: 'toolbar', 'aria-label': `Share “${title}”` }, link, embed, ...files));
  // In an experiment shown alone, a link to the whole page.
  const home = isAlone()
    ? [html('a', { class: 'home', href: `${location.pathname}#${id}`, target: '_blank', rel: 'noopener' }, 'All of the lab')]
    : [];
  return html('div', { class: 'share' }, row, ...home, said, code);
}
