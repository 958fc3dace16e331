// Terms that are highlighted together in the formula, the sentence and the picture. An element with data-term
// names a term; one with data-lights affects or explains it.

/** Highlights the term under the pointer or the focus within an element, and for a moment a term that has
 * changed. */
export function lightTerms(root: HTMLElement): void {
  let timer = 0;
  const light = (name: string | undefined): void => {
    for (const one of root.querySelectorAll('[data-term]')) {
      one.classList.toggle('lit', name !== undefined && one.getAttribute('data-term') === name);
    }
    root.classList.toggle('lighting', name !== undefined);
  };
  const named = (event: Event): string | undefined =>
    event.target instanceof Element
      ? event.target.closest('[data-lights]')?.getAttribute('data-lights')
        ?? event.target.closest('math [data-term]')?.getAttribute('data-term') ?? undefined
      : undefined;
  for (const over of ['pointerover', 'focusin', 'moved']) {
    root.addEventListener(over, (event) => {
      const name = named(event);
      if (name === undefined && over !== 'pointerover') return;
      clearTimeout(timer);
      light(name);
      if (over === 'moved') timer = window.setTimeout(() => { light(undefined); }, 1500);
    });
  }
  root.addEventListener('pointerleave', () => { light(undefined); });
  root.addEventListener('focusout', () => { light(undefined); });
}
