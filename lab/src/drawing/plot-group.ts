// Plots with a common cursor, a timeline that moves it, their numbers as CSV and their picture as PNG.
import { html, show } from '../element.ts';
import { colour } from './colours.ts';

/** The current contents of a plot. */
export interface Member {
  title: string;
  unit: string;
  /** Its canvas, once it has been visible. */
  canvas: () => HTMLCanvasElement | undefined;
  names: readonly string[];
  data: () => { x: ArrayLike<number>; columns: readonly ArrayLike<number>[] };
  /** Draws the plot again, with or without the cursor. */
  cursor: (x: number | undefined) => void;
}

export interface PlotGroup {
  /** The timeline, shown once there are data. */
  element: HTMLElement;
  add(member: Member): void;
  /** Called with the position of a plot's pointer, undefined when it has left. */
  point(x: number | undefined): void;
  /** Called when the data of a plot has changed. */
  changed(): void;
  csv(): string;
  png(): Promise<Blob>;
  /** The plots' picture, redrawn after every change until it is ended. */
  film(): HTMLCanvasElement;
  endFilm(): void;
}

/** `onScrub` receives the time at the cursor, or undefined for the current state. */
export function plotGroup(onScrub: (x: number | undefined) => void = () => undefined, xName = 't', xUnit = 's'): PlotGroup {
  const members: Member[] = [];
  const range = html('input', { type: 'range', min: 0, max: 1, step: 'any', 'aria-label': `Timeline, ${xUnit}` });
  const text = html('span', { class: 'number' });
  const element = html('div', { class: 'timeline', hidden: true }, html('span', { class: 'timeline-name' }, 'Timeline'), range, text);
  let at: number | undefined;
  let span: [number, number] = [0, 0];
  let shown = NaN;
  const put = (x: number | undefined): void => {
    at = x;
    for (const member of members) member.cursor(x);
    onScrub(x);
    write();
  };
  const write = (): void => {
    const share = at === undefined ? 1 : (at - span[0]) / (span[1] - span[0] || 1);
    // Styles are set only if they differ.
    if (share !== shown) {
      shown = share;
      range.value = String(share);
      range.style.setProperty('--share', `${(100 * share).toFixed(2)}%`);
    }
    const words = at === undefined ? 'now' : `${show(at, 2)} ${xUnit}`;
    if (text.textContent === words) return;
    text.textContent = words;
    range.setAttribute('aria-valuetext', words);
  };
  range.addEventListener('input', () => {
    const share = Number(range.value);
    put(share > 0.999 ? undefined : span[0] + share * (span[1] - span[0]));
  });
  let film: HTMLCanvasElement | undefined;
  let filmed = 0;
  /** All plots that have been visible, one below the other, with their names. */
  const sheet = (onto: HTMLCanvasElement): HTMLCanvasElement => {
    const seen = members.flatMap(({ canvas, ...member }) => {
      const drawn = canvas();
      return drawn !== undefined && drawn.clientWidth > 0 ? [{ ...member, canvas: drawn }] : [];
    });
    const ratio = devicePixelRatio;
    const line = 26 * ratio;
    const width = Math.max(1, ...seen.map(({ canvas }) => canvas.width)) + 24 * ratio;
    const height = seen.reduce((sum, { canvas }) => sum + canvas.height + line, 0) + 12 * ratio;
    if (onto.width !== width) onto.width = width;
    if (onto.height !== height) onto.height = height;
    const context = onto.getContext('2d')!;
    context.fillStyle = colour('paper');
    context.fillRect(0, 0, onto.width, onto.height);
    context.font = `600 ${String(13 * ratio)}px ui-sans-serif, system-ui, sans-serif`;
    context.fillStyle = colour('ink');
    let y = 0;
    for (const { title, unit, names, canvas } of seen) {
      context.fillText(`${title}, ${unit}${names.length > 1 ? `: ${names.join(', ')}` : ''}`, 12 * ratio, y + 0.75 * line);
      context.drawImage(canvas, 12 * ratio, y + line);
      y += line + canvas.height;
    }
    return onto;
  };
  return {
    element,
    add: (member) => members.push(member),
    point: put,
    changed() {
      const x = members[0]?.data().x;
      const some = x !== undefined && x.length > 2;
      if (element.hidden === some) element.hidden = !some;
      if (!some) return;
      if (film !== undefined) {
        filmed ||= requestAnimationFrame(() => {
          filmed = 0;
          if (film !== undefined) sheet(film);
        });
      }
      span = [x[0]!, x[x.length - 1]!];
      if (at !== undefined && (at < span[0] || at > span[1])) put(undefined);
      else write();
    },
    csv() {
      const x = members[0]?.data().x ?? [];
      const columns = members.flatMap(({ names, unit, data }) => {
        const now = data();
        // A scale is not a unit.
        const plain = unit.replace(/(, )?log scale/, '');
        const named = (name = ''): string => (plain === '' ? name : `${name} [${plain}]`);
        return now.x.length === x.length ? now.columns.map((values, k) => ({ name: named(names[k]), values })) : [];
      });
      const quoted = (name: string): string => (/[",]/.test(name) ? `"${name.replace(/"/g, '""')}"` : name);
      const head = [`${xName} [${xUnit}]`, ...columns.map(({ name }) => name)].map(quoted).join(',');
      const rows = Array.from(x, (t, i) => [t, ...columns.map(({ values }) => values[i] ?? '')].join(','));
      return `${[head, ...rows].join('\n')}\n`;
    },
    png() {
      const picture = sheet(html('canvas'));
      return new Promise((resolve, reject) => {
        picture.toBlob((blob) => {
          if (blob === null) reject(new Error('no picture'));
          else resolve(blob);
        });
      });
    },
    film() {
      film = sheet(html('canvas'));
      return film;
    },
    endFilm() {
      film = undefined;
    },
  };
}

/** Saves a file. */
export function download(name: string, content: Blob): void {
  const link = html('a', { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => { URL.revokeObjectURL(link.href); }, 1000);
}
