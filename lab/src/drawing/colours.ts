// The page's few colours, read from the style sheet so that canvases follow the theme.

export type Tone = 'ink' | 'accent' | 'second' | 'muted' | 'line';

export function colour(tone: Tone): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${tone}`).trim();
}

type Listener = () => void;
const listeners = new Set<Listener>();

/** Calls back when the theme changes. */
export function onTheme(listener: Listener): void {
  listeners.add(listener);
}

export function themeChanged(): void {
  listeners.forEach((listener) => { listener(); });
}

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', themeChanged);
