// Hides content until it is revealed: before that, it is not on the page, not even for screen readers.
import { html } from '../element.ts';

export interface HiddenAnswer {
  element: HTMLElement;
  lift(): void;
}

export function hiddenAnswer(hint: string, ...hidden: Element[]): HiddenAnswer {
  const inside = html('div', { class: 'unveiled', hidden: true }, ...(hidden as HTMLElement[]));
  const cover = html('p', { class: 'veil' }, hint);
  return {
    element: html('div', { class: 'veiled' }, cover, inside),
    lift() {
      cover.remove();
      inside.hidden = false;
    },
  };
}
