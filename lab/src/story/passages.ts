// The story's passages, one before each experiment of the chapter: question, prediction, answer.
import { type Scrub, scrub } from '../controls/scrub.ts';
import { html, show } from '../element.ts';
import { Brick, KnifeEdge, Reach2R, Replay } from '../../lib/dynamics/index.ts';
import { passage } from './passage.ts';

const TURN = { name: 'q₂', from: -Math.PI, to: Math.PI, unit: 'rad' };

/** The mass of the outer rod as a number in a sentence. */
function outerRod(onInput: (mass: number) => void): Scrub {
  return scrub({ label: 'Mass of the outer rod', unit: 'kg', min: 0.2, max: 5, step: 0.1, value: 1, term: 'inertial', onInput });
}

/** Before the inertia ellipse: the effect of M. */
export function onMass(): HTMLElement {
  let outer = 1;
  const fastest = (q2: number): number => Reach2R.uniform(1, 2, 1, outer, 9.81).inertiaEllipse([0, q2]).semiAxes[0]!;
  return passage({
    ask: ['An arm in motion has energy, and the matrix M(q) says how much: K = ½ q̇ᵀM q̇. Turn that around. You have half a joule ',
      'and may spend it on any mixture of the two joint speeds. How fast can you make the arm’s joints go? It depends on the elbow. ',
      'Draw the greatest speed |q̇| as q₂ goes once around.'],
    prediction: {
      label: 'The greatest joint speed for half a joule, against the elbow’s angle', x: TURN,
      y: { name: 'greatest |q̇|', from: 0, to: 5, unit: 'rad/s' }, curve: (x) => x.map(fastest),
    },
    formula: 'story-mass',
    tell: (redraw) => {
      const at = html('span', { class: 'number' });
      const draw = (): void => {
        at.textContent = `${show(fastest(0), 2)} rad/s stretched and ${show(fastest(Math.PI), 2)} folded`;
        redraw();
      };
      const mass = outerRod((value) => {
        outer = value;
        draw();
      });
      draw();
      return [
        ['It is ', at, '. The cheapest motion swings the inner link one way and the outer one back, so that the masses hardly move. ',
          'Stretched, that works best.'],
        ['Give the outer rod ', mass.element, ' instead: a heavier arm is slower for the same half joule, whatever the elbow’s angle.'],
      ];
    },
  });
}

/** Before the Lagrangian lab: the effect of a changing M. */
export function onCoriolis(): HTMLElement {
  let bend = Math.PI / 2;
  const push = (rate: number): number => Reach2R.workedExample().velocityProduct([0, bend], [rate, 0])[1]!;
  return passage({
    ask: ['M changes as the arm bends, and motion with a changing M needs additional forces: C q̇. Let the inner joint turn at ',
      'q̇₁ with the elbow at a right angle and still. Gravity aside, what torque does joint 2 need to keep the elbow so? Draw it for both ',
      'directions of turning.'],
    prediction: {
      label: 'The torque C q̇ of joint 2 against the speed of joint 1', x: { name: 'q̇₁', from: -4, to: 4, unit: 'rad/s' },
      y: { name: '(C q̇)₂', from: -10, to: 10, unit: 'N·m' }, curve: (x) => x.map(push),
    },
    formula: 'story-coriolis',
    tell: (redraw) => {
      const at = html('span', { class: 'number' });
      const rate = scrub({
        label: 'Speed of joint 1', unit: 'rad/s', min: -4, max: 4, step: 0.1, value: 2, term: 'rate', onInput: () => { draw(); },
      });
      const draw = (): void => {
        at.textContent = `${show(push(rate.value), 2)} N·m`;
        redraw();
      };
      const elbow = scrub({
        label: 'Angle of the elbow', unit: '°', min: -180, max: 180, step: 5, value: 90, term: 'coupling',
        onInput: (degrees) => {
          bend = (degrees * Math.PI) / 180;
          draw();
        },
      });
      draw();
      return [
        ['Turning at ', rate.element, ' takes ', at, '. Either way round it has the same sign, since the speed is squared: the outer rod ',
          'tends outwards in both cases.'],
        ['With the elbow at ', elbow.element, ' the parabola is steeper or flatter. Straight, at 0° or 180°, there is no elbow to open.'],
      ];
    },
  });
}

/** Before the replay: the effect of the speed along a path. */
export function onClock(): HTMLElement {
  let motion: Replay | undefined;
  const peak = (times: number): number => (motion ??= new Replay()).peakTorque(times)[0]!;
  return passage({
    ask: ['So forces follow from speed. Now give the arm a path, a closed curve in its two angles, and play it k times as fast. ',
      'Draw the largest torque that joint 1 needs on the way.'],
    prediction: {
      label: 'The peak torque of joint 1 against the playing speed', x: { name: 'k', from: 0, to: 2.5, unit: 'times as fast' },
      y: { name: 'peak |τ₁|', from: 0, to: 90, unit: 'N·m' }, curve: (x) => x.map((k) => peak(Math.max(k, 0.01))),
    },
    formula: 'story-clock',
    tell: () => {
      const at = html('span', { class: 'number' });
      const times = scrub({
        label: 'Playing speed', unit: 'times', min: 0, max: 2.5, step: 0.05, value: 1, term: 'rate', onInput: () => { draw(); },
      });
      const draw = (): void => {
        at.textContent = `${show(peak(Math.max(times.value, 0.01)), 1)} N·m`;
      };
      draw();
      return [
        ['Played ', times.element, ' as fast the peak is ', at, '. Creeping along, only gravity is left. ',
          'A little faster the peak may even fall, where the motion helps. ',
          'The part of the motion grows with the square of k: so do accelerations, and C q̇ is quadratic in the speeds.'],
      ];
    },
  });
}

/** Before the workbench: the inertia at a joint's motor. */
export function onHolding(): HTMLElement {
  let outer = 1;
  const inertia = (q2: number): number => Reach2R.uniform(1, 2, 1, outer, 9.81).mass([0, q2])[0]![0]!;
  return passage({
    ask: ['To hold the arm somewhere, joint 1 gets a spring and a damper. How they act depends on the inertia at the joint, and that is ',
      'M₁₁. You know it stretched, bent at a right angle and folded. Draw all of it.'],
    prediction: {
      label: 'M₁₁ against the elbow’s angle', x: TURN, y: { name: 'M₁₁', from: 0, to: 8, unit: 'kg·m²' }, curve: (x) => x.map(inertia),
    },
    formula: 'mass11',
    tell: (redraw) => {
      const at = html('span', { class: 'number' });
      const draw = (): void => {
        at.textContent = `${show(inertia(0), 2)} kg·m² stretched, ${show(inertia(Math.PI), 2)} folded`;
        redraw();
      };
      const mass = outerRod((value) => {
        outer = value;
        draw();
      });
      draw();
      return [
        ['A cosine, and the outer rod makes all of it: with ', mass.element, ' out there it is ', at, '. ',
          'The damper that stops a folded arm without overshoot is too weak for a stretched one.'],
      ];
    },
  });
}

/** Before the knife-edge: the constraint force. */
export function onConstraint(): HTMLElement {
  let mass = 2;
  let turning = 1;
  const side = (speed: number): number => {
    const blade = new KnifeEdge(mass, 0.5, 0.25);
    blade.place(Float64Array.of(0, 0, 0), speed, turning);
    const lambda = blade.lambda;
    blade.free();
    return lambda;
  };
  return passage({
    ask: ['Motors push as we command. The floor pushes a wheel sideways exactly as hard as it takes to keep it from ',
      'slipping. A chassis of 2 kg turns left at 1 rad/s while it rolls at speed v. Draw the sideways force λ on it, counted to the ',
      'right, for driving backwards, standing, and driving forwards.'],
    prediction: {
      label: 'The side force against the forward speed', x: { name: 'v', from: -3, to: 3, unit: 'm/s' },
      y: { name: 'λ', from: -10, to: 10, unit: 'N' }, curve: (x) => x.map(side),
    },
    formula: 'story-side',
    tell: (redraw) => [
      ['A straight line. The floor bends the path of ', scrub({
        label: 'Mass of the chassis', unit: 'kg', min: 0.5, max: 5, step: 0.1, value: 2, term: 'mass',
        onInput: (value) => {
          mass = value;
          redraw();
        },
      }).element, ' that turns at ', scrub({
        label: 'Turning', unit: 'rad/s', min: -3, max: 3, step: 0.1, value: 1, term: 'turn',
        onInput: (value) => {
          turning = value;
          redraw();
        },
      }).element, ', and pushes to the left, hence the sign. It does no work, since the wheel does not move that way.'],
    ],
  });
}

/** Before the brick: motion without torque. */
export function onTurning(): HTMLElement {
  let nudge = 0.05;
  const spun = (times: readonly number[]): number[] => {
    const brick = new Brick(0.3, 0.2, 0.1, 1000);
    brick.spin(Float64Array.of(nudge, 6, nudge));
    let now = 0;
    const rates = times.map((t) => {
      const due = Math.round(t * 1000) - now;
      brick.advance(due);
      now += due;
      return brick.omega[1]!;
    });
    brick.free();
    return rates;
  };
  return passage({
    ask: ['Last, a free brick without joints and floor, spun about its middle axis at 6 rad/s with a small nudge about the other two. ',
      'No torque acts. Draw its rate of turning about that axis over ten seconds.'],
    prediction: {
      label: 'The spin about the middle axis against time', x: { name: 't', from: 0, to: 10, unit: 's' },
      y: { name: 'ω about the middle axis', from: -7, to: 7, unit: 'rad/s' }, curve: spun,
    },
    formula: 'story-brick',
    tell: (redraw) => [
      ['It turns over, and back, and over again, with a nudge of ', scrub({
        label: 'Nudge', unit: 'rad/s', min: 0.01, max: 2, step: 0.01, value: 0.05, term: 'nudge',
        onInput: (value) => {
          nudge = value;
          redraw();
        },
      }).element, '. The product of the two small rates drives the large one; a smaller nudge only delays the flips. ',
      'The brick’s own axes move, while its angular momentum is constant in space.'],
    ],
  });
}
