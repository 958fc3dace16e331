// An orthographic view of the world, z up, turned by dragging or by arrow keys.
import { numberFrom, type Shared } from '../address.ts';
import { svg } from '../element.ts';

export type Vector3 = readonly [number, number, number];

/** Three numbers of a list. */
export function vector(list: ArrayLike<number>, at = 0): Vector3 {
  return [list[at]!, list[at + 1]!, list[at + 2]!];
}

export class View {
  constructor(
    public azimuth = -0.9,
    public elevation = 0.42,
  ) {
    this.began = [azimuth, elevation];
  }

  private readonly began: readonly [number, number];

  /** Right, up and towards the viewer. The picture's y points down, so the second is negated there. */
  look([x, y, z]: Vector3): [number, number, number] {
    const [sa, ca] = [Math.sin(this.azimuth), Math.cos(this.azimuth)];
    const [se, ce] = [Math.sin(this.elevation), Math.cos(this.elevation)];
    const across = -sa * x + ca * y;
    const away = ca * x + sa * y;
    return [across, ce * z - se * away, se * z + ce * away];
  }

  /** The picture's right and up, in the world. */
  plane(): readonly [Vector3, Vector3] {
    const [sa, ca] = [Math.sin(this.azimuth), Math.cos(this.azimuth)];
    const [se, ce] = [Math.sin(this.elevation), Math.cos(this.elevation)];
    return [[-sa, ca, 0], [-se * ca, -se * sa, ce]];
  }

  /** Its part of the address, if the view was turned. */
  shared(name: string): Shared {
    const [azimuth, elevation] = this.began;
    if (this.azimuth === azimuth && this.elevation === elevation) return {};
    return { [`${name}-azimuth`]: this.azimuth, [`${name}-elevation`]: this.elevation };
  }

  restore(values: URLSearchParams, name: string): void {
    this.azimuth = numberFrom(values, `${name}-azimuth`, this.began[0]);
    this.elevation = Math.max(-1.5, Math.min(1.5, numberFrom(values, `${name}-elevation`, this.began[1])));
  }

  turn(right: number, up: number): void {
    this.azimuth -= right;
    this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + up));
  }
}

/** A picture that can be turned. */
export function spatialPicture(label: string, view: View, reach: number, onTurn: () => void): SVGSVGElement {
  const element = svg('svg', {
    class: 'space',
    viewBox: `${String(-reach)} ${String(-reach)} ${String(2 * reach)} ${String(2 * reach)}`,
    role: 'group',
    tabindex: 0,
    'aria-label': `${label}. Drag or use the arrow keys to look from another side.`,
  });
  let last: readonly [number, number] = [0, 0];
  element.addEventListener('pointerdown', (event) => {
    if (event.target instanceof Element && event.target.closest('.grip')) return;
    element.setPointerCapture(event.pointerId);
    last = [event.clientX, event.clientY];
  });
  element.addEventListener('pointermove', (event) => {
    if (!element.hasPointerCapture(event.pointerId)) return;
    const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
    last = [event.clientX, event.clientY];
    // A vertical swipe scrolls the page.
    view.turn(dx * 0.01, event.pointerType === 'touch' ? 0 : dy * 0.01);
    onTurn();
  });
  element.addEventListener('keydown', (event) => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (by === undefined || event.target !== element) return;
    event.preventDefault();
    view.turn(by[0]! * 0.1, by[1]! * 0.1);
    onTurn();
  });
  return element;
}

/** R v, with R in row-major order in a flat list from `at`. */
export function rotate(rotation: ArrayLike<number>, [x, y, z]: Vector3, at = 0): [number, number, number] {
  const row = (i: number): number =>
    rotation[at + 3 * i]! * x + rotation[at + 3 * i + 1]! * y + rotation[at + 3 * i + 2]! * z;
  return [row(0), row(1), row(2)];
}

/** Lines on the ground z = 0 around the origin, at a round distance, as a path. */
export function floorLines(view: View, reach: number): string {
  const spacing = 10 ** Math.ceil(Math.log10(reach / 5)) / 2;
  const at = (x: number, y: number): string => {
    const [right, up] = view.look([x * spacing, y * spacing, 0]);
    return `${right.toFixed(4)} ${(-up).toFixed(4)}`;
  };
  const lines = [-4, -3, -2, -1, 0, 1, 2, 3, 4].map((k) => `M${at(k, -4)}L${at(k, 4)}M${at(-4, k)}L${at(4, k)}`);
  return lines.join('');
}
