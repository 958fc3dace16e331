// What can be read before the physics has come: each experiment's title, the passage that leads to it, what it is.
import { show } from '../element.ts';
import { onClock, onConstraint, onCoriolis, onHolding, onMass, onTurning } from './passages.ts';

export interface Words {
  title: string;
  lede: string;
  /** The passage of the story that leads to it; left out where the experiment stands alone. */
  passage?: () => HTMLElement;
}

/** How far the second pendulum of the map of flips starts from the first [rad]. */
export const TWIN_APART = 1e-4;

/** By the names that addresses use, in the order of the story. The questions come before what answers them. */
export const WORDS = {
  'opening': {
    title: 'Throw it',
    lede: 'Take hold of a link and throw it. Nothing rubs: what your hand puts in stays in.',
  },
  'predict-first': {
    title: 'Predict first',
    lede: 'Say what you think before the number shows. Each answer is computed on the spot; the experiments below show why.',
  },
  'inertia-ellipse': {
    title: 'Inertia ellipse',
    passage: onMass,
    lede: 'How fast can the joints turn for one half joule? Every pair of velocities on the ellipse q̇ᵀM q̇ = 1 costs the same. '
      + 'Long axis: easy. Short axis: hard.',
  },
  'lagrangian-lab': {
    title: 'Lagrangian lab',
    passage: onCoriolis,
    lede: 'Drag the elbow or the tip, let go, and the arm falls. K and V trade places; their sum E must stay on its line. '
      + 'Now switch C q̇ off: a small lie, and E leaves its line at once. Or fork: a ghost goes on from here with one law changed.',
  },
  'replay': {
    title: 'Replay',
    passage: onClock,
    lede: 'A path is a curve; it has no clock and so no torques. Give it a clock and it has both. Gravity’s part stays what it was '
      + 'at any speed. At 1× the motors manage; at 2× look at their gauges.',
  },
  'workbench': {
    title: 'Workbench',
    passage: onHolding,
    lede: 'Hold a waypoint with a spring, a damper and the weight of the arm. Find gains that settle crisply with the arm '
      + 'folded. Now try the same gains stretched: M₁₁ is three times as large, and the arm rings.',
  },
  'knife-edge': {
    title: 'Knife-edge',
    passage: onConstraint,
    lede: 'The wheels roll but do not slide: A q̇ = 0. The floor answers with a sideways force λ, exactly as large as it '
      + 'must be. Push from the side as hard as you like: the chassis does not move that way.',
  },
  'tumbling-brick': {
    title: 'Tumbling brick',
    passage: onTurning,
    lede: 'No torque acts, so L stays fixed in space. Spin the brick about its longest axis, its shortest, and its middle one, and watch '
      + 'where the axes go.',
  },
  'your-robot': {
    title: 'Your robot',
    lede: 'Choose a robot, open a URDF or MJCF file, or drop one anywhere on the page, alone or in a folder or zip with its meshes. '
      + 'It never leaves your machine. Take hold of a link and pull: while it runs, a spring follows your hand; while it rests, '
      + 'the joints give way. The ellipsoid at your hand is the mass you feel, direction by direction. What floats falls on the ground, '
      + 'links touch each other; the arrows are what pushes them. Links glow by the term of M q̈ + C q̇ + g that you choose.',
  },
  'integrator-race': {
    title: 'Integrator race',
    lede: 'The same fall, four ways to step it. No torque, no friction: the exact energy never changes, so every change is '
      + 'the method’s own. Over a long race it is not the smallest error that counts but whether it grows.',
  },
  'flip-map': {
    title: 'Map of flips',
    lede: 'Each point is the chapter’s arm, let go at rest, and its colour is the time until one of its rods first points straight up. '
      + 'In the plain middle none ever does: the energy is missing. Around it neighbours part ways. '
      + `Click on a point, and that pendulum falls beside the map, with a twin that starts ${show(TWIN_APART, 4)} rad away.`,
  },
} as const satisfies Record<string, Words>;

export type Id = keyof typeof WORDS;
