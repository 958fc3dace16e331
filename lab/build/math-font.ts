// A subset of STIX Two Math with the letters of the page's formulas. Browsers without a mathematical font
// draw formulas without dots and with short brackets.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';

import subset from 'subset-font';
import type { Plugin } from 'vite';

import { formulas } from './mathml.ts';

const EQUATIONS = new URL('../src/equations.tex', import.meta.url);
/** Address of the font for the style sheet. */
const FOLDER = new URL('../generated/', import.meta.url);

export function mathFont(): Plugin {
  return {
    name: 'math-font',
    async buildStart() {
      const source = createRequire(import.meta.url).resolve('@fontsource/stix-two-math/files/stix-two-math-latin-400-normal.woff2');
      const text = Object.values(formulas(readFileSync(EQUATIONS, 'utf8'), EQUATIONS.pathname)).join('');
      mkdirSync(FOLDER, { recursive: true });
      const font = await subset(readFileSync(source), letters(text), { targetFormat: 'woff2', noHinting: true });
      writeFileSync(new URL('math.woff2', FOLDER), font);
    },
  };
}

/** The characters of a formula, and the italic ones that browsers substitute for single letters. */
export function letters(mathml: string): string {
  const plain = mathml.replace(/<[^>]*>/g, '').replace(/&[a-z]+;/g, ' ');
  const all = new Set<string>();
  for (const character of plain) {
    all.add(character);
    all.add(slanted(character));
  }
  return [...all].join('');
}

/** The mathematical italic of a Latin or Greek letter. */
function slanted(letter: string): string {
  if (letter === 'h') return 'ℎ';
  const code = letter.codePointAt(0)!;
  const within = (first: string, last: string): boolean => letter >= first && letter <= last;
  if (within('A', 'Z')) return String.fromCodePoint(0x1d434 + code - 0x41);
  if (within('a', 'z')) return String.fromCodePoint(0x1d44e + code - 0x61);
  if (within('Α', 'Ω')) return String.fromCodePoint(0x1d6e2 + code - 0x391);
  if (within('α', 'ω')) return String.fromCodePoint(0x1d6fc + code - 0x3b1);
  return letter === '∂' ? '𝜕' : letter;
}
