// Mechanical quantities drawn on an arm: angles, weights, joint torques, the effective mass at the tip, and
// its trail.
import { set, short, svg } from '../element.ts';
import { turning, wedge } from './arc.ts';
import { arrow } from './arrow.ts';
import { fadingTrail } from './fading-trail.ts';
import type { Point } from './planar-arm.ts';

export const LAYERS = ['angles', 'weights', 'torques', 'mass', 'trail'] as const;
export type Layer = (typeof LAYERS)[number];

/** The data of the drawing. Expensive quantities are functions, called only if they are shown. */
export interface Felt {
  /** From the base outwards. */
  points: readonly Point[];
  q: ArrayLike<number>;
  /** Centre of mass and weight of each link: x, y, N. */
  weights: () => ArrayLike<number>;
  /** M q̈ of every joint, then C q̇, then g, and their sum if the arm is driven or damped. */
  stack: () => ArrayLike<number>;
  /** J M⁻¹ Jᵀ of the tip: larger and smaller eigenvalue, direction of the larger. */
  mobility: () => ArrayLike<number>;
}

export interface MechanismDrawing {
  /** Layers below and above the links. */
  under: SVGGElement;
  over: SVGGElement;
  /** Letters are redrawn every third frame. */
  draw(felt: Felt, beat: number): void;
  /** The tip's past positions, oldest first. */
  past(x: ArrayLike<number>, y: ArrayLike<number>): void;
  show(layer: Layer, on: boolean): void;
  /** The torque of half a turn of arc [N·m]. It follows the largest torque and decreases slowly. */
  halfTurn(): number;
}

const PARTS = ['inertial', 'coriolis', 'gravity', 'drive'] as const;
const DIGITS = '₁₂₃';
/** The smallest torque that the longest arc stands for [N·m], and the length of that arc [rad]. */
const TORQUE = 15;
const LARGEST = 1.2 * Math.PI;
/** Metres of arrow for a newton, for an arm of unit size. */
const PER_NEWTON = 0.017;
/** Metres of ellipse for √(1/kg), for an arm of unit size. */
const PER_MOBILITY = 0.13;

/** For an arm of that many joints; `size` is about the length of a link in metres. */
export function mechanism(count: number, size = 1): MechanismDrawing {
  // One path for each kind of part of all joints, since every changed path costs style and layout work per
  // frame.
  const angles = svg('path', { class: 'angle' });
  const names = Array.from({ length: count }, (_, i) =>
    svg('text', { class: 'name', 'text-anchor': 'middle', 'dominant-baseline': 'central' }, `q${DIGITS[i]!}`));
  const parts = PARTS.map((part) => svg('path', { class: `torque ${part}`, 'data-term': part }));
  const arrows = names.map((_, i) => arrow('muted weight', `m${DIGITS[i]!}g`, 0.07 * size));
  const ellipse = svg('ellipse', { class: 'tip-mass' });
  const axis = svg('path', { class: 'tip-axis' });
  const trail = fadingTrail();
  const layers: Record<Layer, SVGGElement[]> = {
    angles: [svg('g', {}, angles, ...names)],
    weights: [svg('g', { 'data-term': 'gravity' }, ...arrows.map((one) => one.element))],
    torques: [svg('g', {}, ...parts)],
    mass: [svg('g', {}, ellipse, axis)],
    trail: [trail.element],
  };
  const style = `--size: ${String(size)}`;
  const layer = (...inside: SVGGElement[]): SVGGElement => svg('g', { class: 'felt-by', style, 'aria-hidden': 'true' }, ...inside);
  const under = layer(...layers.trail, ...layers.angles, ...layers.mass);
  const over = layer(...layers.torques, ...layers.weights);
  let widest = TORQUE;

  const drawAngles = ({ points, q }: Felt, beat: number): void => {
    let before = 0;
    let lines = '';
    names.forEach((name, i) => {
      const turn = within(q[i]!);
      const centre = points[i]!;
      const radius = 0.2 * size;
      const [dx, dy] = [0.33 * size * Math.cos(before), -0.33 * size * Math.sin(before)];
      lines += `M${short(centre[0])} ${short(-centre[1])}l${short(dx)} ${short(dy)}${wedge(centre, radius, before, turn)}`;
      const middle = before + turn / 2;
      const [x, y] = [centre[0] + 1.5 * radius * Math.cos(middle), -centre[1] - 1.5 * radius * Math.sin(middle)];
      if (beat % 3 === 0) set(name, { x, y });
      before += turn;
    });
    angles.setAttribute('d', lines);
  };
  const drawTorques = ({ points, q, stack: ask }: Felt): void => {
    const stack = ask();
    // Head to tail: the sum of the first three drives the joint.
    let direction = 0;
    widest = Math.max(TORQUE, 0.985 * widest);
    for (let i = 0; i < count; i += 1) {
      let sum = 0;
      for (let part = 0; part < 3; part += 1) {
        sum += stack[part * count + i] ?? 0;
        widest = Math.max(widest, Math.abs(sum), Math.abs(stack[part * count + i] ?? 0));
      }
    }
    const scale = LARGEST / widest;
    const drawn = PARTS.map(() => '');
    for (let i = 0; i < count; i += 1) {
      direction += q[i]!;
      let from = direction;
      for (let part = 0; part < PARTS.length; part += 1) {
        const by = scale * (stack[part * count + i] ?? 0);
        const start = part === 3 ? direction : from;
        drawn[part] += turning(points[i]!, (0.34 + 0.055 * part) * size, start, by, 0.07 * size);
        from += by;
      }
    }
    parts.forEach((path, part) => { set(path, { d: drawn[part]! }); });
  };
  const drawTip = ({ points, mobility: ask }: Felt): void => {
    const mobility = ask();
    const [x, y] = points.at(-1)!;
    const [greater, smaller] = [0, 1].map((k) => PER_MOBILITY * size * Math.sqrt(mobility[k]!)) as [number, number];
    const degrees = (-Math.atan2(mobility[3]!, mobility[2]!) * 180) / Math.PI;
    set(ellipse, {
      rx: greater, ry: Math.max(smaller, 0.008 * size), transform: `translate(${short(x)} ${short(-y)}) rotate(${degrees.toFixed(2)})`,
    });
    const [dx, dy] = [greater * mobility[2]!, greater * mobility[3]!];
    set(axis, { d: `M${short(x - dx)} ${short(-y + dy)}L${short(x + dx)} ${short(-y - dy)}` });
  };
  const shown = new Set<Layer>(LAYERS);
  return {
    under,
    over,
    draw(felt, beat) {
      if (shown.has('angles')) drawAngles(felt, beat);
      if (shown.has('weights')) {
        const weights = felt.weights();
        arrows.forEach((one, i) => {
          const [x, y, newtons] = [0, 1, 2].map((k) => weights[3 * i + k]!) as [number, number, number];
          one.draw([x, -y], [x, -y + newtons * PER_NEWTON * size]);
        });
      }
      if (shown.has('torques')) drawTorques(felt);
      if (shown.has('mass')) drawTip(felt);
    },
    past(x, y) {
      if (shown.has('trail')) trail.draw(x, y);
    },
    show(layer, on) {
      if (on) shown.add(layer);
      else shown.delete(layer);
      for (const one of layers[layer]) one.setAttribute('visibility', on ? 'visible' : 'hidden');
      // Arrows of a hidden group hide themselves, so contents must follow the group.
      if (layer === 'weights') over.classList.toggle('weightless', !on);
    },
    halfTurn: () => (widest * Math.PI) / LARGEST,
  };
}

/** The angle in (−π, π]. */
function within(angle: number): number {
  return angle - 2 * Math.PI * Math.ceil(angle / (2 * Math.PI) - 0.5);
}
