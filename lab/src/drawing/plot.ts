// A plot on a canvas: one or more lines against time, with units, legend and round ticks.
import { html, scientific, show } from '../element.ts';
import { colour, onTheme, type Tone } from './colours.ts';
import type { PlotGroup } from './plot-group.ts';
import { linearTicks, logTicks, type Tick } from './ticks.ts';

export interface Line {
  name: string;
  tone: Tone;
  dashed?: boolean;
}

export interface PlotOptions {
  title: string;
  /** Of the vertical axis. */
  unit: string;
  lines: Line[];
  /** Powers of ten, from this smallest value up. */
  logFrom?: number;
  /** Never show less than this range. */
  atLeast?: [number, number];
  /** Horizontal lines at these values, with their names. */
  marks?: { value: number; name: string }[];
  xUnit?: string;
  height?: number;
  /** Plots with one cursor. */
  group?: PlotGroup;
}

export interface Plot {
  element: HTMLElement;
  /** x and one list of values per line; lists may be shorter than x. */
  draw(x: ArrayLike<number>, columns: readonly ArrayLike<number>[]): void;
}

const LEFT = 52;
const RIGHT = 10;
const BOTTOM = 22;
const TOP = 8;

export function plot(options: PlotOptions): Plot {
  const { title, unit, lines, marks = [], height = 150, xUnit = 's' } = options;
  const canvas = html('canvas', { role: 'img', 'aria-label': title, style: `height: ${String(height)}px` });
  // The values under the cursor stand beside the names.
  const values = lines.map(() => html('span', { class: 'at' }));
  const legend = lines.map((line, k) =>
    html('span', { class: `key ${line.tone}${line.dashed ? ' dashed' : ''}` }, line.name, values[k]!),
  );
  const element = html(
    'figure',
    { class: 'plot' },
    html('figcaption', {},
      html('span', { class: 'plot-title' }, `${title}, ${unit}`), html('span', { class: 'legend' }, ...legend)),
    canvas,
  );
  let last: Parameters<Plot['draw']> = [[], []];
  let cursor: number | undefined;
  // Size and sight are told by observers, so that a frame asks for no layout.
  let width = 0;
  let seen = false;
  let said = 0;
  const context = canvas.getContext('2d');
  const draw = (...[x, columns]: Parameters<Plot['draw']>): void => {
    last = [x, columns];
    if (width === 0 || !seen || context === null) return;
    // One canvas pixel for each pixel of the screen.
    const ratio = devicePixelRatio;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    paint(context, width, height, options, x, columns, xUnit, marks);
    point(context, x, columns);
    options.group?.changed();
    const now = performance.now();
    if (now - said < 500) return;
    said = now;
    describe(canvas, title, unit, lines, columns, options.logFrom !== undefined);
  };
  /** A line at the cursor, and what the lines are there. */
  const point = (on: CanvasRenderingContext2D, x: ArrayLike<number>, columns: Parameters<Plot['draw']>[1]): void => {
    const k = cursor === undefined || x.length < 2 ? -1 : nearest(x, cursor);
    if (k >= 0) {
      const [start, end] = [x[0]!, x[x.length - 1]!];
      const at = LEFT + ((x[k]! - start) / (end - start || 1)) * (width - LEFT - RIGHT);
      rule(on, at, TOP, at, height - BOTTOM, colour('ink'));
    }
    values.forEach((one, line) => {
      const value = columns[line]?.[k];
      const text = value === undefined ? '' : ` ${options.logFrom === undefined ? show(value, 3) : scientific(value)}`;
      if (one.textContent !== text) one.textContent = text;
    });
  };
  options.group?.add({
    title, unit, canvas, names: lines.map(({ name }) => name), data: () => ({ x: last[0], columns: last[1] }),
    cursor: (x) => {
      if (cursor === x) return;
      cursor = x;
      draw(...last);
    },
  });
  const follow = (event: PointerEvent): void => {
    const [x] = last;
    if (x.length < 2 || width === 0) return;
    const share = (event.offsetX - LEFT) / (width - LEFT - RIGHT);
    options.group?.point(x[0]! + Math.max(0, Math.min(1, share)) * (x[x.length - 1]! - x[0]!));
  };
  canvas.addEventListener('pointermove', follow);
  canvas.addEventListener('pointerleave', () => { options.group?.point(undefined); });
  new ResizeObserver((entries) => {
    width = entries.at(-1)?.contentRect.width ?? 0;
    draw(...last);
  }).observe(canvas);
  new IntersectionObserver((entries) => {
    seen = entries.at(-1)?.isIntersecting ?? false;
    draw(...last);
  }, { rootMargin: '40px' }).observe(canvas);
  onTheme(() => { draw(...last); });
  return { element, draw };
}

/** The index of the value nearest to x in a rising list. */
function nearest(list: ArrayLike<number>, x: number): number {
  let [low, high] = [0, list.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle]! < x) low = middle;
    else high = middle;
  }
  return x - list[low]! < list[high]! - x ? low : high;
}

function paint(
  context: CanvasRenderingContext2D,
  width: number,
  height: number,
  options: PlotOptions,
  x: ArrayLike<number>,
  columns: readonly ArrayLike<number>[],
  xUnit: string,
  marks: { value: number; name: string }[],
): void {
  context.clearRect(0, 0, width, height);
  const log = options.logFrom !== undefined;
  const floor = options.logFrom ?? 0;
  const scale = (value: number): number => (log ? Math.log10(Math.max(value, floor)) : value);
  const [low, high] = range(options, columns, scale);
  const [start, end] = x.length > 1 ? [x[0]!, x[x.length - 1]!] : [0, 1];
  const toX = (t: number): number => LEFT + ((t - start) / (end - start || 1)) * (width - LEFT - RIGHT);
  const toY = (v: number): number => TOP + ((high - scale(v)) / (high - low)) * (height - TOP - BOTTOM);

  context.font = '11px ui-sans-serif, system-ui, sans-serif';
  context.lineWidth = 1;
  const ticks: Tick[] = log ? logTicks(low, high) : linearTicks(low, high, 4);
  context.textAlign = 'right';
  context.textBaseline = 'middle';
  for (const { value, text } of ticks) {
    const y = Math.round(toY(value)) + 0.5;
    rule(context, LEFT, y, width - RIGHT, y, colour('line'));
    context.fillStyle = colour('muted');
    context.fillText(text, LEFT - 7, y);
  }
  context.textBaseline = 'alphabetic';
  for (const { value, text } of linearTicks(start, end, Math.max(2, Math.floor(width / 110)))) {
    context.textAlign = 'center';
    context.fillStyle = colour('muted');
    context.fillText(`${text} ${xUnit}`, Math.min(toX(value), width - 18), height - 5);
  }
  context.textAlign = 'left';
  for (const { value, name } of marks) {
    const y = toY(value);
    if (y < TOP || y > height - BOTTOM) continue;
    context.setLineDash([2, 3]);
    rule(context, LEFT, y, width - RIGHT, y, colour('muted'));
    context.setLineDash([]);
    context.fillStyle = colour('muted');
    context.fillText(name, LEFT + 4, y - 4);
  }
  columns.forEach((column, k) => {
    const line = options.lines[k]!;
    context.beginPath();
    const count = Math.min(column.length, x.length);
    // No more points than pixels can show.
    const stride = Math.max(1, Math.floor(count / (2 * width)));
    for (let i = 0; i < count; i += stride) {
      const [px, py] = [toX(x[i]!), Math.max(TOP - 4, Math.min(height - BOTTOM + 4, toY(column[i]!)))];
      if (i === 0) context.moveTo(px, py);
      else context.lineTo(px, py);
    }
    context.strokeStyle = colour(line.tone);
    context.lineWidth = 1.75;
    context.setLineDash(line.dashed ? [5, 4] : []);
    context.stroke();
    context.setLineDash([]);
  });
}

function rule(context: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number, style: string): void {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.strokeStyle = style;
  context.lineWidth = 1;
  context.stroke();
}

function range(
  options: PlotOptions,
  columns: readonly ArrayLike<number>[],
  scale: (value: number) => number,
): [number, number] {
  let [low, high] = options.atLeast ? [scale(options.atLeast[0]), scale(options.atLeast[1])] : [Infinity, -Infinity];
  for (const column of columns) {
    for (let i = 0; i < column.length; i += 1) {
      const value = scale(column[i]!);
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  const log = options.logFrom !== undefined;
  if (!Number.isFinite(low) || !Number.isFinite(high)) return log ? [Math.log10(options.logFrom ?? 1), 0] : [0, 1];
  if (log) return [Math.floor(low), Math.ceil(high + 1e-9) === Math.floor(low) ? low + 1 : Math.ceil(high)];
  const margin = 0.06 * (high - low) || 0.5;
  return [low - margin, high + margin];
}

/** The latest values in words, for those who do not see the canvas. */
function describe(
  canvas: HTMLCanvasElement,
  title: string,
  unit: string,
  lines: Line[],
  columns: readonly ArrayLike<number>[],
  log: boolean,
): void {
  const latest = lines.map((line, k) => {
    const column = columns[k];
    const value = column === undefined ? undefined : column[column.length - 1];
    if (value === undefined) return `${line.name} none yet`;
    return `${line.name} ${log ? scientific(value) : value.toFixed(2)}`;
  });
  canvas.setAttribute('aria-label', `${title} in ${unit}; latest values: ${latest.join(', ')}`);
}
