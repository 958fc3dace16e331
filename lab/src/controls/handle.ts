// A point in a picture that can be moved by mouse, touch or arrow keys.
import { set, show, svg } from '../element.ts';

export interface HandleOptions {
  label: string;
  unit: string;
  min: number;
  max: number;
  /** Called with the pointer's position in the picture's units (y down). */
  onDrag: (x: number, y: number) => void;
  /** Called with the change that an arrow key asks for, in the handle's unit. */
  onNudge: (by: number, axis: 'x' | 'y') => void;
  nudge: number;
  onGrab?: () => void;
  onRelease?: () => void;
  /** For pointers only, since a slider beside the picture gives keyboard access to the same number. */
  doubled?: boolean;
  /** Radius of the visible part; the sensitive part is larger. */
  radius: number;
}

export interface Handle {
  element: SVGGElement;
  place(x: number, y: number, value: number): void;
}

export function handle(options: HandleOptions): Handle {
  const { label, unit, min, max, radius, nudge, doubled = false } = options;
  const element = svg(
    'g',
    { class: 'handle', role: 'slider', tabindex: doubled ? -1 : 0, 'aria-label': label, 'aria-valuemin': min, 'aria-valuemax': max },
    svg('circle', { class: 'felt', r: 2.4 * radius }),
    svg('circle', { class: 'seen', r: radius }),
  );
  const circles = [...element.children];
  const toPicture = (event: PointerEvent): DOMPoint => {
    const matrix = element.ownerSVGElement!.getScreenCTM()!.inverse();
    return new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
  };
  element.addEventListener('pointerdown', (event) => {
    event.preventDefault();
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    element.classList.add('held');
    options.onGrab?.();
  });
  element.addEventListener('pointermove', (event) => {
    if (!element.hasPointerCapture(event.pointerId)) return;
    const { x, y } = toPicture(event);
    options.onDrag(x, y);
  });
  const release = (): void => {
    if (!element.classList.contains('held')) return;
    element.classList.remove('held');
    options.onRelease?.();
  };
  element.addEventListener('pointerup', release);
  element.addEventListener('pointercancel', release);
  element.addEventListener('keydown', (event) => {
    const times = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (times === undefined) return;
    event.preventDefault();
    options.onNudge(times * nudge, /Left|Right/.test(event.key) ? 'x' : 'y');
  });
  let latest = NaN;
  let timer = 0;
  const say = (): void => {
    timer = 0;
    set(element, { 'aria-valuenow': show(latest, 3).replace('−', '-'), 'aria-valuetext': `${show(latest, 3)} ${unit}` });
  };
  return {
    element,
    place(x, y, value) {
      // Moving circles costs less per frame than moving a group.
      for (const circle of circles) set(circle, { cx: x, cy: y });
      const isFirst = Number.isNaN(latest);
      latest = value;
      if (isFirst || document.activeElement === element) say();
      // Screen readers are not told of values that change sixty times a second.
      else if (timer === 0) timer = window.setTimeout(say, 250);
    },
  };
}
