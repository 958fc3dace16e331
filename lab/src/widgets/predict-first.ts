// Predict first: the chapter's short questions, each answered by a computed number.
import { html, scientific, show } from '../element.ts';
import { energyDrift, FallingArm, PolarMass, Reach2R } from '../../lib/dynamics/index.ts';
import { section, type Widget } from './frame.ts';
import { question } from './question.ts';

interface Card {
  text: string;
  answers: readonly string[];
  right: number;
  /** The number behind the answer, computed when it is shown. */
  because: () => string;
}

const cards: readonly Card[] = [
  {
    text: 'Two rods of a metre, the inner of 2 kg, the outer of 1 kg, make an arm. Its M₁₁, the inertia at joint 1, is 2 kg·m² '
      + 'bent at a right angle. And stretched, q₂ = 0?',
    answers: ['1', '2', '3', '4'],
    right: 2,
    because: () => `M₁₁(q₂ = 0) = ${show(m11(0), 4)} kg·m²: the outer link is as far from joint 1 as it can be.`,
  },
  {
    text: 'And folded back on itself, q₂ = π?',
    answers: ['0', '1', '1.5', '2'],
    right: 1,
    because: () => `M₁₁(q₂ = π) = ${show(m11(Math.PI), 4)} kg·m²: a third of the stretched arm’s.`,
  },
  {
    text: 'A point mass of 2 kg in polar coordinates, 1.5 m out. Γ²₁₂ is …',
    answers: ['0', '1.5', '3', '6'],
    right: 2,
    because: () => {
      const symbol = PolarMass.of(2).christoffel([1.5, 0.7])[1]![0]![1]!;
      return `Γ²₁₂ = m r = ${show(symbol, 4)} kg·m: even a point mass has C q̇ ≠ 0, since the coordinates are curved.`;
    },
  },
  {
    text: 'Folded, q₂ = π, the inertia ellipse is …',
    answers: ['long along q̇₁', 'long along q̇₂', 'a circle'],
    right: 1,
    because: () => {
      const { semiAxes } = Reach2R.workedExample().inertiaEllipse([0, Math.PI]);
      return `Semi-axes ${show(semiAxes[0]!, 3)} and ${show(semiAxes[1]!, 3)} rad/s, the longer one nearer to q̇₂.`;
    },
  },
  {
    text: 'Leave C q̇ out and let the arm fall. Its energy …',
    answers: ['stays', 'drifts far away', 'only decreases'],
    right: 1,
    because: () => {
      const arm = new FallingArm(1, 2, 1, 1, 9.81);
      arm.place(Float64Array.of(Math.PI / 4, Math.PI / 2), Float64Array.of(0, 0));
      arm.setCoriolis(false);
      arm.advance(10_000);
      const { drift, energies: { total, start } } = arm;
      arm.free();
      const ends = `ends at ${show(total, 1)} J instead of ${show(start, 1)} J`;
      return `In ten seconds it is off by up to ${show(100 * drift, 0)} %, and ${ends}.`;
    },
  },
  {
    text: 'Explicit Euler on the same fall: the energy …',
    answers: ['grows', 'shrinks', 'stays'],
    right: 0,
    because: () => {
      const start = { q: [Math.PI / 4, Math.PI / 2], qd: [0, 0] };
      const arm = Reach2R.workedExample();
      const euler = energyDrift(arm, start, 1e-3, 10_000, 'explicit-euler');
      const rk4 = scientific(energyDrift(arm, start, 1e-3, 10_000));
      return `Off by ${show(100 * euler, 0)} % after ten seconds in steps of a millisecond; Runge–Kutta 4 by ${rk4}.`;
    },
  },
  {
    text: 'The same path twice as fast. The part of the torque that the motion needs grows …',
    answers: ['twofold', 'fourfold', 'eightfold'],
    right: 1,
    because: () => 'b ṡ²: the square of the speed. Gravity’s part does not change.',
  },
];

function m11(q2: number): number {
  return Reach2R.workedExample().mass([0, q2])[0]![0]!;
}

export function predictFirst(): Widget {
  const score = html('p', { class: 'score', 'aria-live': 'polite' }, `0 of ${String(cards.length)} answered.`);
  const results = new Map<number, boolean>();
  const list = cards.map((card, index) => {
    const because = html('p', { class: 'because' });
    const asked = question(card.text, card.answers, card.right, (correct) => {
      because.textContent = card.because();
      // The first answer counts.
      if (!results.has(index)) results.set(index, correct);
      const good = [...results.values()].filter(Boolean).length;
      score.textContent = `${String(results.size)} of ${String(cards.length)} answered, ${String(good)} right at the first try.`;
    });
    return html('li', {}, asked, because);
  });
  const element = section('predict-first', html('ol', { class: 'cards' }, ...list), score);
  return { id: 'predict-first', element, restore: () => undefined };
}
