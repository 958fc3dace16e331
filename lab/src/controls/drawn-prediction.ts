// A prediction that the user draws before the curve shows: by mouse or finger, or point by point with arrow
// keys.
import { html, set, short, show, svg } from '../element.ts';
import { linearTicks } from '../drawing/ticks.ts';
import { button } from './choice.ts';

export interface PredictionOptions {
  /** The axes. */
  label: string;
  x: { name: string; from: number; to: number; unit: string };
  y: { name: string; from: number; to: number; unit: string };
  /** The true curve at the given places. */
  curve: (x: readonly number[]) => ArrayLike<number>;
  /** Called when the curve is shown, with the mean distance of the drawing as a fraction of the height, if
   * there is one. */
  onReveal: (off: number | undefined) => void;
}

export interface Prediction {
  element: HTMLElement;
  /** Draws the curve again after one of its numbers has changed. */
  redraw(): void;
}

/** Number of drawn points, and the ratio of computed to drawn points. */
const PLACES = 33;
const FINER = 6;
const [WIDTH, HEIGHT] = [10, 6];

export function drawnPrediction(options: PredictionOptions): Prediction {
  const { label, x, y, curve, onReveal } = options;
  const along = (count: number): number[] => Array.from({ length: count }, (_, k) => x.from + ((x.to - x.from) * k) / (count - 1));
  const places = along(PLACES);
  const fine = along(FINER * (PLACES - 1) + 1);
  const drawn: (number | undefined)[] = places.map(() => undefined);
  let revealed = false;
  let cursor = (PLACES - 1) / 2;

  const across = (k: number): number => (WIDTH * k) / (PLACES - 1);
  const down = (value: number): number => HEIGHT * (1 - (value - y.from) / (y.to - y.from));
  const guess = svg('path', { class: 'guess' });
  const answer = svg('path', { class: 'answer-curve' });
  const mark = svg('circle', { class: 'cursor', r: 0.16, visibility: 'hidden' });
  const hint = svg('text', { class: 'hint', x: WIDTH / 2, y: HEIGHT / 2 - 0.35, 'text-anchor': 'middle' }, 'draw here');
  const zero = y.from < 0 && y.to > 0 ? [svg('line', { class: 'axes', x1: 0, x2: WIDTH, y1: down(0), y2: down(0) })] : [];
  const ticks = [
    ...linearTicks(x.from, x.to, 5).map(({ value, text }) => svg('text', {
      x: (WIDTH * (value - x.from)) / (x.to - x.from), y: HEIGHT + 0.5, 'text-anchor': 'middle',
    }, text)),
    ...linearTicks(y.from, y.to, 5).map(({ value, text }) => svg('text', { x: -0.15, y: down(value) + 0.12, 'text-anchor': 'end' }, text)),
  ];
  const sheet = svg('rect', { class: 'sheet', width: WIDTH, height: HEIGHT });
  const picture = svg('svg', {
    class: 'prediction', viewBox: `-1.1 -0.75 ${String(WIDTH + 1.5)} ${String(HEIGHT + 1.9)}`, role: 'application', tabindex: 0,
    'aria-label': `${label}. Left and right select a point, up and down draw it, Enter shows the curve`,
  },
  sheet, ...zero, ...ticks,
  svg('text', { class: 'axis-name', x: WIDTH, y: HEIGHT + 1.02, 'text-anchor': 'end' }, `${x.name}, ${x.unit}`),
  svg('text', { class: 'axis-name', x: -1, y: -0.35 }, `${y.name}, ${y.unit}`),
  hint, guess, answer, mark);
  const said = html('p', { class: 'visually-hidden', 'aria-live': 'polite' });
  const offBy = html('p', { class: 'off-by' });

  const drawGuess = (): void => {
    let d = '';
    drawn.forEach((value, k) => {
      if (value !== undefined) d += `${d === '' ? 'M' : 'L'}${short(across(k))} ${short(down(value))}`;
    });
    set(guess, { d });
    if (d !== '' || revealed) hint.remove();
    else guess.before(hint);
  };
  const put = (k: number, value: number): void => {
    drawn[k] = Math.min(y.to, Math.max(y.from, value));
  };
  let last: { k: number; value: number } | undefined;
  let before: typeof drawn = [];
  const pointer = (event: PointerEvent): void => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(sheet.getScreenCTM()!.inverse());
    const k = Math.round(Math.min(1, Math.max(0, at.x / WIDTH)) * (PLACES - 1));
    const value = y.from + (1 - at.y / HEIGHT) * (y.to - y.from);
    put(k, value);
    // A fast pointer skips places.
    if (last !== undefined) {
      const [from, to] = [last, { k, value }];
      const step = Math.sign(to.k - from.k);
      for (let i = from.k + step; step !== 0 && i !== to.k; i += step) {
        put(i, from.value + ((to.value - from.value) * (i - from.k)) / (to.k - from.k));
      }
    }
    last = { k, value };
    drawGuess();
  };
  sheet.addEventListener('pointerdown', (event) => {
    if (revealed) return;
    event.preventDefault();
    picture.focus({ preventScroll: true });
    sheet.setPointerCapture(event.pointerId);
    last = undefined;
    before = [...drawn];
    pointer(event);
  });
  // A vertical swipe scrolls the page and draws nothing.
  sheet.addEventListener('pointercancel', () => {
    drawn.splice(0, PLACES, ...before);
    drawGuess();
  });
  sheet.addEventListener('pointermove', (event) => {
    if (sheet.hasPointerCapture(event.pointerId)) pointer(event);
  });
  picture.addEventListener('keydown', (event) => {
    const side = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const up = { ArrowUp: 1, ArrowDown: -1, PageUp: 5, PageDown: -5 }[event.key];
    if (event.key === 'Enter') reveal();
    if (side === undefined && up === undefined) return;
    event.preventDefault();
    const before = drawn[cursor] ?? (y.from + y.to) / 2;
    if (side !== undefined) {
      cursor = Math.min(PLACES - 1, Math.max(0, cursor + side));
      if (!revealed) put(cursor, drawn[cursor] ?? before);
    } else if (!revealed) put(cursor, before + (up! * (y.to - y.from)) / 40);
    drawGuess();
    set(mark, { cx: across(cursor), cy: down(drawn[cursor] ?? before), visibility: 'visible' });
    const truth = revealed ? `; it is ${show(answers[cursor]!, 2)}` : '';
    const mine = drawn[cursor] === undefined ? 'nothing drawn' : `you drew ${show(drawn[cursor]!, 2)} ${y.unit}`;
    said.textContent = `${x.name} ${show(places[cursor]!, 2)} ${x.unit}: ${mine}${truth}`;
  });

  let answers: ArrayLike<number> = [];
  const redraw = (): void => {
    if (!revealed) return;
    const values = curve(fine);
    answers = places.map((_, k) => values[FINER * k]!);
    const clipped = Array.from(values, (value) => Math.min(y.to, Math.max(y.from, value)));
    set(answer, { d: clipped.map((value, k) => `${k === 0 ? 'M' : 'L'}${short(across(k / FINER))} ${short(down(value))}`).join('') });
  };
  const reveal = (): void => {
    // The physics may still be loading.
    if (revealed || document.documentElement.dataset['ready'] === undefined) return;
    revealed = true;
    redraw();
    hint.remove();
    showing.remove();
    picture.classList.add('revealed');
    const pairs = drawn.flatMap((value, k) => (value === undefined ? [] : [Math.abs(value - answers[k]!)]));
    const off = pairs.length === 0 ? undefined : pairs.reduce((sum, one) => sum + one, 0) / pairs.length / (y.to - y.from);
    if (off !== undefined) {
      const share = `On average you were ${show(100 * off, 0)} % of the height away.`;
      offBy.textContent = off < 0.06 ? `Very close. ${share}` : off < 0.15 ? `Close. ${share}` : share;
    }
    onReveal(off);
  };
  // On the keyboard, Enter in the picture does this.
  const showing = button('Show the curve', reveal);
  showing.tabIndex = -1;
  return { element: html('div', { class: 'predicting' }, picture, showing, offBy, said), redraw };
}
