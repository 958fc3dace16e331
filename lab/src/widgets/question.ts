// A question with a few answers, of which one is right; choosing any shows the right one.
import { roving } from '../controls/choice.ts';
import { html } from '../element.ts';

export function question(
  text: string,
  answers: readonly string[],
  right: number,
  onAnswer: (correct: boolean) => void = () => undefined,
): HTMLElement {
  const said = html('p', { class: 'verdict', 'aria-live': 'polite' });
  const buttons = answers.map((answer, i) =>
    html('button', {
      type: 'button',
      click: () => {
        buttons.forEach((one, k) => { one.className = k === right ? 'right' : k === i ? 'wrong' : ''; });
        said.textContent = i === right ? 'Yes.' : `No: ${answers[right]!}.`;
        onAnswer(i === right);
      },
    }, answer),
  );
  const row = roving(html('div', { class: 'button-row', role: 'toolbar', 'aria-label': 'Answers' }, ...buttons));
  return html('div', { class: 'question', role: 'group', 'aria-label': text }, html('p', {}, text), row, said);
}
