// What is not to be known yet: nothing of it is on the page, for eyes or for screen readers, until it is lifted.
import { html } from '../element.ts';

export interface Veil {
  element: HTMLElement;
  lift(): void;
}

export function veil(hint: string, ...hidden: Element[]): Veil {
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
