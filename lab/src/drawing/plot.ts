// A plot: one or more lines against time, with units, legend and round ticks. uPlot draws it on a canvas. The
// page provides the names, the values at the cursor, and the text for screen readers.
import type uPlot from 'uplot';

import { html, powerOfTen, scientific, show } from '../element.ts';
import { colour, onTheme, type Tone } from './colours.ts';
import type { PlotGroup } from './plot-group.ts';
import { digitsOf, logTicks } from './ticks.ts';

export interface Line {
  name: string;
  tone: Tone;
  dashed?: boolean;
}

export interface PlotOptions {
  title: string;
  /** Unit of the vertical axis. */
  unit: string;
  lines: Line[];
  /** Logarithmic axis from this smallest value. */
  logFrom?: number;
  /** Smallest range of the axis. */
  atLeast?: [number, number];
  /** Horizontal lines at these values, with names. */
  marks?: { value: number; name: string }[];
  xUnit?: string;
  height?: number;
  /** Plots with a common cursor. */
  group?: PlotGroup;
}

/** Values in order. */
export type List = number[] | Float64Array;

export interface Plot {
  element: HTMLElement;
  /** x and one list of values for each line; lists may be shorter than x. */
  draw(x: List, columns: readonly List[]): void;
}

/** Margins for the axes' numbers, and above and beside the lines. */
const [LEFT, BOTTOM, TOP, RIGHT] = [52, 22, 8, 22];
const FONT = '11px ui-sans-serif, system-ui, sans-serif';

/** Loaded when the first plot becomes visible. */
let library: typeof uPlot | undefined;

export function plot(options: PlotOptions): Plot {
  const { title, unit, lines, height = 150, logFrom } = options;
  const host = html('div', { class: 'chart', role: 'img', 'aria-label': title, style: `height: ${String(height)}px` });
  // The values at the cursor are shown beside the names.
  const values = lines.map(() => html('span', { class: 'at' }));
  const legend = lines.map((line, k) =>
    html('span', { class: `key ${line.tone}${line.dashed ? ' dashed' : ''}` }, line.name, values[k]!),
  );
  const element = html(
    'figure',
    { class: 'plot' },
    html('figcaption', {},
      html('span', { class: 'plot-title' }, `${title}, ${unit}`), html('span', { class: 'legend' }, ...legend)),
    host,
  );
  let last: Parameters<Plot['draw']> = [[], []];
  let chart: uPlot | undefined;
  let cursor: number | undefined;
  let pointed = false;
  // Observers report size and visibility, so that frames need no layout.
  let width = 0;
  let seen = false;
  let said = 0;
  const draw = (...[x, columns]: Parameters<Plot['draw']>): void => {
    last = [x, columns];
    if (width === 0 || !seen) return;
    if (chart !== undefined) chart.setData(table(options, x, columns));
    else if (library !== undefined) chart = made(library);
    else return;
    options.group?.changed();
    const now = performance.now();
    if (now - said < 500) return;
    said = now;
    host.setAttribute('aria-label', describe(options, columns));
  };
  /** The vertical line at the cursor, and the values there. */
  const point = (): void => {
    if (chart === undefined) return;
    const [x] = last;
    const isIn = cursor !== undefined && x.length > 1 && cursor >= x[0]! && cursor <= x.at(-1)!;
    const at = isIn ? chart.valToPos(cursor!, 'x') : undefined;
    if (at === undefined && !pointed) return;
    pointed = at !== undefined;
    chart.setCursor(at === undefined ? { left: -10, top: -10 } : { left: at, top: 0 }, false);
    const k = chart.cursor.idx ?? -1;
    values.forEach((one, line) => {
      const value = last[1][line]?.[k];
      const text = value === undefined ? '' : ` ${logFrom === undefined ? show(value, 3) : scientific(value)}`;
      if (one.textContent !== text) one.textContent = text;
    });
  };
  const made = (Chart: typeof uPlot): uPlot => {
    const fresh = new Chart(
      { ...drawn(options), width, height, hooks: { draw: [(on) => { marks(on, options); }, point] } }, table(options, ...last), host,
    );
    fresh.over.addEventListener('pointermove', ({ offsetX }) => {
      if (last[0].length > 1) options.group?.point(fresh.posToVal(offsetX, 'x'));
    });
    fresh.over.addEventListener('pointerleave', () => { options.group?.point(undefined); });
    return fresh;
  };
  options.group?.add({
    title, unit, canvas: () => chart?.ctx.canvas, names: lines.map(({ name }) => name), data: () => ({ x: last[0], columns: last[1] }),
    cursor: (x) => {
      if (cursor === x) return;
      cursor = x;
      point();
    },
  });
  new ResizeObserver((entries) => {
    width = Math.floor(entries.at(-1)?.contentRect.width ?? 0);
    if (width > 0) chart?.setSize({ width, height });
    draw(...last);
  }).observe(host);
  new IntersectionObserver((entries) => {
    seen = entries.at(-1)?.isIntersecting ?? false;
    if (!seen) return;
    if (library !== undefined) draw(...last);
    else {
      import('uplot').then(({ default: fetched }) => {
        library = fetched;
        draw(...last);
      }, (error: unknown) => { host.textContent = `The plot did not load: ${String(error)}`; });
    }
  }, { rootMargin: '40px' }).observe(host);
  onTheme(() => chart?.redraw());
  return { element, draw };
}

/** The options of uPlot. */
function drawn(options: PlotOptions): Omit<uPlot.Options, 'width' | 'height'> {
  const { lines, logFrom, xUnit = 's' } = options;
  const log = logFrom !== undefined;
  const axis = { stroke: () => colour('muted'), font: FONT, ticks: { show: false } };
  // The page manages the cursor of a group.
  const deaf = (): null => null;
  const plain = (_: uPlot, at: number[], __: number, ___: number, step: number): string[] =>
    at.map((value) => show(value, digitsOf(step)));
  return {
    legend: { show: false },
    padding: [TOP, RIGHT, 0, 0],
    cursor: {
      y: false, drag: { x: false, y: false }, points: { size: 7 },
      bind: {
        mousedown: deaf, mouseup: deaf, click: deaf, dblclick: deaf, mousemove: deaf, mouseleave: deaf, mouseenter: deaf,
      },
    },
    scales: {
      x: { time: false, range: (_, low, high) => [low, low < high ? high : low + 1] },
      y: { ...(log ? { distr: 3, log: 10 } : {}), range: (_, low, high) => range(options, low, high) },
    },
    axes: [
      {
        ...axis, size: BOTTOM, gap: 5, space: 52, grid: { show: false },
        values: (...told) => plain(...told).map((text) => `${text} ${xUnit}`),
      },
      {
        ...axis, size: LEFT, gap: 7, space: 28, grid: { stroke: () => colour('line'), width: 1 }, values: plain,
        ...(log
          ? {
            splits: (_: uPlot, __: number, low: number, high: number) =>
              logTicks(Math.log10(low), Math.log10(high)).map(({ value }) => value),
            filter: (_: uPlot, at: number[]) => at,
            values: (_: uPlot, at: number[]) => at.map((value) => (value === 1 ? '1' : powerOfTen(Math.round(Math.log10(value))))),
          }
          : {}),
      },
    ],
    series: [
      {},
      ...lines.map(({ tone, dashed }) => ({
        stroke: () => colour(tone), width: 1.75, points: { show: false }, ...(dashed ? { dash: [5, 4] } : {}),
      })),
    ],
  };
}

/** Rows of equal length. An empty plot goes from 0 to 1, and a single point gets an axis of length 1. Values
 * below the range of a logarithmic plot are at its bottom. */
function table({ lines, logFrom }: PlotOptions, x: List, columns: readonly List[]): uPlot.AlignedData {
  if (x.length === 0) return [[0, 1], ...lines.map(() => [null, null])];
  const raised = (column: List): List => (logFrom === undefined ? column : column.map((value) => Math.max(value, logFrom)));
  return [x.length === 1 ? [x[0]!, x[0]! + 1] : x, ...lines.map((_, k) => raised(columns[k] ?? []))];
}

/** From the smallest and the largest value, if there are any. */
function range({ atLeast, logFrom }: PlotOptions, least: number | null, most: number | null): [number, number] {
  let [low, high] = [Math.min(least ?? Infinity, atLeast?.[0] ?? Infinity), Math.max(most ?? -Infinity, atLeast?.[1] ?? -Infinity)];
  const some = Number.isFinite(low) && Number.isFinite(high);
  if (logFrom === undefined) {
    const margin = 0.06 * (high - low) || 0.5;
    return some ? [low - margin, high + margin] : [0, 1];
  }
  if (!some) return [logFrom, 1];
  [low, high] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high) + 1e-9)];
  return [10 ** low, 10 ** Math.max(high, low + 1)];
}

/** Dashed horizontal lines with names. */
function marks({ ctx, bbox, valToPos }: uPlot, { marks: all = [] }: PlotOptions): void {
  const ratio = devicePixelRatio;
  ctx.save();
  ctx.font = FONT.replace('11px', `${String(11 * ratio)}px`);
  ctx.textAlign = 'left';
  ctx.textBaseline = 'alphabetic';
  ctx.lineWidth = ratio;
  ctx.setLineDash([2 * ratio, 3 * ratio]);
  ctx.strokeStyle = ctx.fillStyle = colour('muted');
  for (const { value, name } of all) {
    const y = valToPos(value, 'y', true);
    if (y < bbox.top || y > bbox.top + bbox.height) continue;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    ctx.fillText(name, bbox.left + 4 * ratio, y - 4 * ratio);
  }
  ctx.restore();
}

/** The latest values as text, for screen readers. */
function describe({ title, unit, lines, logFrom }: PlotOptions, columns: readonly List[]): string {
  const latest = lines.map(({ name }, k) => {
    const value = columns[k]?.at(-1);
    if (value === undefined) return `${name} none yet`;
    return `${name} ${logFrom === undefined ? value.toFixed(2) : scientific(value)}`;
  });
  return `${title} in ${unit}; latest values: ${latest.join(', ')}`;
}
