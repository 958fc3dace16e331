// The energy balance of an arm as two bars of equal length: its energy, and the sources of that energy.
import { html, scientific, show } from '../element.ts';

export interface EnergyBars {
  element: HTMLElement;
  draw(account: { kinetic: number; potential: number; start: number; work: number; unaccounted: number }, beat: number): void;
}

export function energyBars(): EnergyBars {
  const bit = (tone: string): HTMLElement => html('span', { class: `fill ${tone}` });
  const [kinetic, potential, start, gain, loss] = ['second', 'muted', 'ink', 'accent', 'accent striped'].map(bit) as
    [HTMLElement, HTMLElement, HTMLElement, HTMLElement, HTMLElement];
  const number = (key: string): HTMLElement => html('span', { class: 'number', 'data-reading': key });
  const [k, v, e, w, off] = ['K', 'V', 'start', 'work', 'off'].map(number) as
    [HTMLElement, HTMLElement, HTMLElement, HTMLElement, HTMLElement];
  const line = (label: string, bits: HTMLElement[], ...text: (HTMLElement | string)[]): HTMLElement =>
    html('div', { class: 'book' },
      html('span', { class: 'book-name' }, label),
      html('span', { class: 'book-track', 'aria-hidden': 'true' }, ...bits),
      html('span', { class: 'book-text' }, ...text));
  let most = 0;
  /** Places a segment between two fractions of the width by a transform, which needs no layout. */
  const put = (one: HTMLElement, from: number, to: number): void => {
    one.style.transform = `translateX(${(100 * from).toFixed(3)}%) scaleX(${Math.max(0, to - from).toFixed(5)})`;
  };
  return {
    element: html('div', { class: 'energy-account', role: 'group', 'aria-label': 'Energy' },
      line('Energy', [kinetic, potential],
        html('span', { class: 'key second' }, 'K '), k, ' J + ', html('span', { class: 'key muted' }, 'V '), v, ' J'),
      line('Sources', [start, gain, loss],
        html('span', { class: 'key ink' }, 'at the start '), e, ' J + ', html('span', { class: 'key accent' }, 'by hand '), w, ' J'),
      html('p', { class: 'book-off' }, 'The two differ by ', off, ' J, the error of the steps.')),
    draw(account, beat) {
      const has = account.kinetic + account.potential;
      most = Math.max(most * 0.999, 1.08 * Math.max(has, account.start, 1));
      put(kinetic, 0, account.kinetic / most);
      put(potential, account.kinetic / most, has / most);
      const given = account.start + account.work;
      put(start, 0, Math.min(account.start, given) / most);
      put(gain, account.start / most, given / most);
      // Energy that the hand removed is marked as a loss.
      put(loss, given / most, account.start / most);
      if (beat % 6 !== 0) return;
      const write = (one: HTMLElement, text: string): void => { if (one.textContent !== text) one.textContent = text; };
      write(k, show(account.kinetic, 1));
      write(v, show(account.potential, 1));
      write(e, show(account.start, 1));
      write(w, show(account.work, 1));
      write(off, scientific(Math.abs(account.unaccounted)));
    },
  };
}
