// Gripping an arm in a picture: by pointer anywhere on a link, by arrow keys at its tip.
import { set, svg } from '../element.ts';
import { polyline, type Point } from '../drawing/planar-arm.ts';

export interface Throwing {
  /** The sensitive elements, for the plane of the picture. */
  element: SVGGElement;
  place(points: readonly Point[]): void;
}

export interface Thrown {
  label: string;
  /** Largest distance from a link at which a pointer grips it [m]. */
  reach: number;
  /** Called when a link is gripped, with the distance from its joint [m]. */
  grab: (link: number, along: number) => void;
  pull: (x: number, y: number) => void;
  letGo: () => void;
  /** Called when an arrow key strikes the tip in that direction. */
  strike: (x: number, y: number) => void;
}

export function throwing(options: Thrown): Throwing {
  let points: readonly Point[] = [];
  const felt = svg('path', { class: 'throw-felt', 'stroke-width': 2 * options.reach });
  const tip = svg('circle', { class: 'throw-tip', r: 0.75 * options.reach });
  const element = svg('g', { class: 'throwing', role: 'application', tabindex: 0, 'aria-label': options.label }, felt, tip);
  const toPicture = (event: PointerEvent): Point => {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(felt.getScreenCTM()!.inverse());
    return [x, -y];
  };
  element.addEventListener('pointerdown', (event) => {
    event.preventDefault();
    element.setPointerCapture(event.pointerId);
    element.classList.add('held');
    const at = toPicture(event);
    const { link, along } = nearest(points, at);
    options.grab(link, along);
    options.pull(...at);
  });
  element.addEventListener('pointermove', (event) => {
    if (element.hasPointerCapture(event.pointerId)) options.pull(...toPicture(event));
  });
  const release = (): void => {
    if (!element.classList.contains('held')) return;
    element.classList.remove('held');
    options.letGo();
  };
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'] as const) element.addEventListener(end, release);
  element.addEventListener('keydown', (event) => {
    const way = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (way === undefined) return;
    event.preventDefault();
    options.strike(way[0]!, way[1]!);
  });
  return {
    element,
    place(next) {
      points = next;
      set(felt, { d: polyline(points) });
      const [x, y] = points.at(-1)!;
      set(tip, { cx: x, cy: -y });
    },
  };
}

/** The link nearest to a point, and the position along it. */
function nearest(points: readonly Point[], [x, y]: Point): { link: number; along: number } {
  let best = { link: 0, along: 0, off: Infinity };
  for (let link = 0; link + 1 < points.length; link += 1) {
    const [[x0, y0], [x1, y1]] = [points[link]!, points[link + 1]!];
    const length = Math.hypot(x1 - x0, y1 - y0);
    const along = Math.max(0, Math.min(length, ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / length));
    const off = Math.hypot(x0 + (along / length) * (x1 - x0) - x, y0 + (along / length) * (y1 - y0) - y);
    if (off < best.off) best = { link, along, off };
  }
  return best;
}
