// A passage of the story: a question, a prediction to draw, and the answer.
import type { Child } from '../element.ts';
import { html, tied } from '../element.ts';
import { drawnPrediction, type Prediction, type PredictionOptions } from '../controls/drawn-prediction.ts';
import { lightTerms } from '../drawing/terms.ts';
import { formula } from '../widgets/equations.ts';

export interface PassageOptions {
  /** The question. */
  ask: readonly Child[];
  prediction: Omit<PredictionOptions, 'onReveal'>;
  /** The answer with numbers that can be dragged. Created when it is shown. */
  tell: (redraw: () => void) => readonly (readonly Child[])[];
  /** The name of its formula in equations.tex. */
  formula: string;
}

/** The text on one side, the picture on the other. The answer appears with the curve. */
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
