// Texts that are shown before the physics is loaded: each experiment's title, the passage before it, and its
// description.
import { show } from '../element.ts';
import { onClock, onConstraint, onCoriolis, onHolding, onMass, onTurning } from './passages.ts';

export interface Words {
  title: string;
  lede: string;
  /** The passage of the story before it; omitted if the experiment is shown alone. */
  passage?: () => HTMLElement;
}

/** Distance between the starts of the two pendulums of the map of flips [rad]. */
export const TWIN_APART = 1e-4;

/** By their names in addresses, in the order of the story. Questions come before the experiments that answer
 * them. */
export const WORDS = {
  'opening': {
    title: 'Throw it',
    lede: 'Drag a link and throw it. There is no friction, so the energy from your hand stays in the arm.',
  },
  'predict-first': {
    title: 'Predict first',
    lede: 'Choose an answer before the number shows. Each answer is computed here; the experiments below show why.',
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
    lede: 'Drag the elbow or the tip and release it: the arm falls. K and V change, and their sum E must stay constant. '
      + 'Now switch C q̇ off, and E leaves its line at once. Or fork: a second arm goes on from here with one law changed.',
  },
  'replay': {
    title: 'Replay',
    passage: onClock,
    lede: 'A path is a curve without time, and so without torques. A speed along it determines both. Gravity’s torque is the same '
      + 'at any speed. At 1× the motors are strong enough; at 2× look at their gauges.',
  },
  'workbench': {
    title: 'Workbench',
    passage: onHolding,
    lede: 'Hold a waypoint with a spring, a damper and the weight of the arm. Find gains that settle without overshoot with the arm '
      + 'folded. Now try the same gains stretched: M₁₁ is three times as large, and the arm oscillates.',
  },
  'knife-edge': {
    title: 'Knife-edge',
    passage: onConstraint,
    lede: 'The wheels roll but do not slide: A q̇ = 0. The floor’s sideways force λ is exactly as large as it '
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
      + 'It stays on your machine. Drag a link: while the robot runs, a spring connects it with your hand; while it rests, '
      + 'its joints follow by inverse kinematics. The ellipsoid at your hand is the effective mass by direction. '
      + 'A floating robot falls on the ground, '
      + 'and links touch each other; arrows show contact forces. Links glow by the term of M q̈ + C q̇ + g that you choose.',
  },
  'integrator-race': {
    title: 'Integrator race',
    lede: 'The same fall, four ways to step it. No torque, no friction: the exact energy never changes, so every change is '
      + 'the method’s error. Over a long race it matters more whether the error grows than how small it is.',
  },
  'flip-map': {
    title: 'Map of flips',
    lede: 'Each point is the chapter’s arm, released from rest, and its colour is the time until one of its rods first points straight up. '
      + 'In the plain middle none ever does, for lack of energy. Around it, neighbouring arms diverge. '
      + `Click on a point to release that pendulum beside the map, with a twin that starts ${show(TWIN_APART, 4)} rad away.`,
  },
} as const satisfies Record<string, Words>;

export type Id = keyof typeof WORDS;
