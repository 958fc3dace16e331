// A passage of the story: a sentence or two that ask, a prediction drawn beside them, and what comes of it.
import type { Child } from '../element.ts';
import { html, tied } from '../element.ts';
import { drawnPrediction, type Prediction, type PredictionOptions } from '../controls/drawn-prediction.ts';
import { lightTerms } from '../drawing/terms.ts';
import { formula } from '../widgets/equations.ts';

export interface PassageOptions {
  /** What is known and what is asked. */
  ask: readonly Child[];
  prediction: Omit<PredictionOptions, 'onReveal'>;
  /** What the curve says, with numbers that can be dragged. Made when it is shown. */
  tell: (redraw: () => void) => readonly (readonly Child[])[];
  /** The name of the formula that explains it, in equations.tex. */
  formula: string;
}

/** The text on one side, the picture on the other; the answer's words come with its curve. */
export function passage(options: PassageOptions): HTMLElement {
  const answer = html('div', { class: 'passage-text tells', hidden: true });
  const drawing: Prediction = drawnPrediction({
    ...options.prediction,
    onReveal: () => {
      const paragraphs = options.tell(() => { drawing.redraw(); }).map((text) => html('p', {}, ...text));
      answer.append(html('p', { class: 'passage-formula' }, formula(options.formula)), ...paragraphs);
      answer.hidden = false;
    },
  });
  const ask = options.ask.map((part) => (typeof part === 'string' ? tied(part) : part));
  const element = html('div', { class: 'passage' },
    html('p', { class: 'passage-text' }, ...ask), drawing.element, answer);
  lightTerms(element);
  return element;
}
