// The opening: an arm that the user throws, with mechanical quantities drawn on it.
import { numbered, numberFrom, numbersFrom, type Shared } from '../address.ts';
import { scrub } from '../controls/scrub.ts';
import { shareRow } from '../controls/share.ts';
import { throwing } from '../controls/throwing.ts';
import { transport } from '../controls/transport.ts';
import { energyBars } from '../drawing/energy-bars.ts';
import { legend } from '../drawing/legend.ts';
import { mechanism } from '../drawing/mechanism.ts';
import { armDrawing, type Point } from '../drawing/planar-arm.ts';
import { lightTerms } from '../drawing/terms.ts';
import { html, set, short, show, svg } from '../element.ts';
import { columns, ThrownArm } from '../../lib/dynamics/index.ts';
import { WORDS } from '../story/words.ts';
import { formula } from './equations.ts';
import { remembered, section, type Widget } from './frame.ts';

const LENGTHS = Float64Array.of(0.6, 0.5, 0.4);
const MASSES = [1.2, 1, 0.8];
const POSE = [0.4, 0.8, 0.6];
const ID = 'opening';
/** Half the height of the window [m]; the arm's length is 1.5 m. */
const REACH = 1.72;
/** The impulse of an arrow key [N·s]. */
const IMPULSE = 0.6;

export function opening(): Widget {
  let masses = [...MASSES];
  let gravity = 9.81;
  let begun: { q: ArrayLike<number>; qd: ArrayLike<number> } = { q: POSE, qd: [0, 0, 0] };
  let arm = new ThrownArm(LENGTHS, Float64Array.from(masses), gravity);

  const felt = mechanism(3, 0.62);
  const body = armDrawing('heavy');
  const spring = svg('path', { class: 'spring' });
  const grip = throwing({
    label: 'The arm. Drag a link to throw it; arrow keys strike its tip',
    reach: 0.14,
    grab: (link, along) => {
      arm.grab(link, along);
      clock.play();
    },
    pull: (x, y) => { arm.pullTo(x, y); },
    letGo: () => { arm.letGo(); },
    strike: (x, y) => {
      arm.strike(IMPULSE * x, IMPULSE * y);
      if (!clock.playing) draw();
    },
  });
  const plane = svg('g');
  const picture = svg('svg', {
    class: 'throw', viewBox: `${String(-REACH)} ${String(-REACH)} ${String(2 * REACH)} ${String(2 * REACH)}`, role: 'group',
    'aria-label': 'A planar arm in gravity, hinged in the middle',
  },
  svg('line', { class: 'horizon', x1: -12, x2: 12, y1: 0, y2: 0 }), svg('circle', { class: 'reach', r: 1.5 }), plane);
  plane.append(felt.under, body.element, felt.over, spring, grip.element);
  const bars = energyBars();
  const halfTurn = html('span', { class: 'number', 'data-reading': 'half-turn' });

  const points = (): Point[] => {
    const flat = arm.points;
    return [[0, 0], ...Array.from({ length: 3 }, (_, k): Point => [flat[2 * k]!, flat[2 * k + 1]!])];
  };
  const draw = (beat = 0): void => {
    const at = points();
    body.draw(at);
    grip.place(at);
    felt.draw({
      points: at, q: arm.q, weights: () => arm.weights, stack: () => arm.torqueStack(), mobility: () => arm.tipMobility(),
    }, beat);
    const [px, py, hx, hy] = arm.hand;
    set(spring, { d: px === undefined ? '' : `M${short(px)} ${short(-py!)}L${short(hx!)} ${short(-hy!)}` });
    if (beat % 2 === 0) {
      const [, x, y] = columns(arm.samples(), 3);
      felt.past(x!, y!);
      if (beat % 6 === 0) halfTurn.textContent = show(felt.halfTurn(), 0);
      bars.draw(arm.energyAccount, beat);
    }
  };
  /** Replaces the arm by one with other parameters in the same state. */
  const rebuild = (q: ArrayLike<number>, qd: ArrayLike<number>): void => {
    arm.free();
    arm = new ThrownArm(LENGTHS, Float64Array.from(masses), gravity);
    arm.place(Float64Array.from(q), Float64Array.from(qd));
    draw();
  };
  const begin = (): void => {
    rebuild(begun.q, begun.qd);
  };
  const layers = legend(felt, () => { draw(); });
  const weights = [0, 1, 2].map((k) => scrub({
    label: `Mass of link ${String(k + 1)}, kilograms`, unit: 'kg', min: 0.2, max: 5, step: 0.1, value: masses[k]!,
    term: 'inertial',
    onInput: (value) => {
      masses[k] = value;
      rebuild(arm.q, arm.qd);
    },
  }));
  const pull = scrub({
    label: 'Gravity', unit: 'm/s²', min: 0, max: 25, step: 0.1, value: 9.8, term: 'gravity',
    onInput: (value) => {
      gravity = value;
      rebuild(arm.q, arm.qd);
    },
  });
  const clock = transport({
    step: () => arm.stepLength,
    advance: (steps) => { arm.advance(steps); },
    draw,
    reset: begin,
    describe: () => {
      const { kinetic, potential } = arm.energyAccount;
      const angles = Array.from(arm.q, (q) => show((q * 180) / Math.PI, 0)).join(', ');
      return `Paused at ${show(arm.time, 1)} seconds. Joint angles ${angles} degrees. `
        + `Kinetic energy ${show(kinetic, 1)} joules, potential ${show(potential, 1)}.`;
    },
    single: 20,
    picture,
  }, true);

  const shared = (): Shared => ({
    gravity, ...numbered('m', masses), ...numbered('q', arm.q), ...numbered('v', arm.qd), ...layers.shared(), ...clock.shared(),
  });
  const element = section(ID,
    html('div', { class: 'hero' },
      picture,
      html('div', { class: 'hero-text' },
        html('p', { class: 'hero-formula' }, formula('motion')),
        html('p', {}, 'Each joint shows an arc for each of the three terms, head to tail. In free motion they end where they began: ',
          'u is zero. While you hold the arm, the gap is your hand’s torque. Half a turn of arc is ', halfTurn, ' N·m now.'),
        html('p', {}, 'The links weigh ', weights[0]!.element, ', ', weights[1]!.element, ' and ', weights[2]!.element,
          '; gravity is ', pull.element, '. Drag the numbers.')),
      html('div', { class: 'hero-controls controls' },
        clock.element, layers.element, shareRow(ID, WORDS[ID].title, shared))),
    bars.element,
  );
  lightTerms(element);
  remembered(element, ID, shared);
  begin();
  return {
    id: ID, element,
    restore(values) {
      masses = Array.from(numbersFrom(values, 'm', MASSES), (m) => Math.min(5, Math.max(0.2, m)));
      gravity = Math.min(25, Math.max(0, numberFrom(values, 'gravity', 9.81)));
      weights.forEach((one, k) => { one.set(masses[k]!); });
      pull.set(gravity);
      layers.restore(values);
      clock.restore(values);
      clock.pause();
      begun = { q: numbersFrom(values, 'q', POSE), qd: numbersFrom(values, 'v', [0, 0, 0]) };
      begin();
    },
  };
}
