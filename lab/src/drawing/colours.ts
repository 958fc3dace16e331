// The page's colours, read from the style sheet once for each theme, so that canvases follow it and frames
// need no style lookups.

export type Tone = 'ink' | 'accent' | 'second' | 'muted' | 'line';

type Name = Tone | 'panel' | 'paper' | 'wash' | 'field';
const known = new Map<Name, string>();

export function colour(name: Name): string {
  let text = known.get(name);
  if (text === undefined) {
    text = resolved(getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
    known.set(name, text);
  }
  return text;
}

/** Resolves light-dark() for the current theme. */
function resolved(text: string): string {
  const probe = document.createElement('span');
  probe.style.color = text;
  document.documentElement.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
}

type Listener = () => void;
const listeners = new Set<Listener>();

/** Calls back when the theme changes. */
export function onTheme(listener: Listener): void {
  listeners.add(listener);
}

export function themeChanged(): void {
  known.clear();
  listeners.forEach((listener) => { listener(); });
}

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', themeChanged);
