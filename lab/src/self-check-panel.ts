// The chapter's numbers, computed by this page on this machine.
import { html, powerOfTen } from './element.ts';
import { selfChecks } from '../lib/dynamics/index.ts';

export function selfCheckPanel(): HTMLElement {
  const summary = html('p', { class: 'lede' }, 'Not run yet.');
  const body = html('tbody');
  const table = html(
    'table',
    {},
    html('thead', {}, html('tr', {},
      ...['Quantity', 'Chapter', 'Computed'].map((text) => html('th', { scope: 'col' }, text)),
      html('th', { scope: 'col' }, html('span', { class: 'visually-hidden' }, 'Result')))),
    body,
  );
  const panel = html(
    'section',
    { id: 'self-checks', class: 'widget', 'aria-labelledby': 'self-checks-title' },
    html('header', {}, html('h2', { id: 'self-checks-title', tabindex: -1 }, 'Self-checks'), summary),
    html('div', { class: 'table', tabindex: 0, role: 'region', 'aria-label': 'Results of the self-checks' }, table),
  );
  const run = (): void => {
    const checks = selfChecks();
    const passed = checks.filter((check) => check.passed).length;
    summary.textContent = `${String(passed)} of ${String(checks.length)} numbers agree with the chapter.`;
    panel.dataset['failed'] = String(checks.length - passed);
    body.replaceChildren(
      ...checks.map((check) =>
        html(
          'tr',
          { class: check.passed ? 'passed' : 'failed' },
          html('th', { scope: 'row' }, check.name),
          html('td', {}, printed(check.expected)),
          html('td', {}, printed(check.found)),
          html('td', {}, check.passed ? '✓ agrees' : '✗ differs'),
        ),
      ),
    );
  };
  // They take a fraction of a second, and are computed when the panel becomes visible.
  new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    run();
  }).observe(panel);
  return panel;
}

/** With true minus signs and powers of ten. */
function printed(text: string): string {
  return text.replace(/e([+-]\d+)/g, (_, exponent: string) => `·${powerOfTen(Number(exponent))}`).replace(/-/g, '−');
}
