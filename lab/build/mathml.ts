// Formulas as MathML, rendered at build time without scripts or downloads.
import katex from 'katex';

/** The lines `name: TeX` of a file, as MathML by name. */
export function formulas(source: string, id: string): Record<string, string> {
  const entries = source
    .split('\n')
    .filter((line) => line.trim() !== '' && !line.startsWith('%'))
    .map((line) => {
      const colon = line.indexOf(':');
      if (colon < 0) throw new Error(`${id}: a line is "name: TeX", found ${line}`);
      return [line.slice(0, colon).trim(), mathml(line.slice(colon + 1).trim())];
    });
  return Object.fromEntries(entries) as Record<string, string>;
}

/** `\\term{name}{…}` marks a part of a formula that the page can highlight: it carries data-term="name". */
const TERM = /\\term\{([a-z0-9-]+)\}/g;

function mathml(source: string): string {
  // KaTeX marks the term by a unique colour.
  const names: string[] = [];
  const tex = source.replace(TERM, (_, name: string) => {
    names.push(name);
    return `\\textcolor{#fe${(names.length - 1).toString(16).padStart(4, '0')}}`;
  });
  const html = katex.renderToString(tex, { output: 'mathml', throwOnError: true, displayMode: false });
  const math = /<math[\s\S]*<\/math>/.exec(html)?.[0];
  if (math === undefined) throw new Error(`no MathML for ${source}`);
  // The page does not need the TeX source, which KaTeX keeps as an annotation.
  return math
    .replace(/<annotation[\s\S]*?<\/annotation>/g, '')
    .replace(/<\/?semantics>/g, '')
    .replace(/mathcolor="#fe([0-9a-f]{4})"/g, (_, index: string) => `class="term" data-term="${names[Number.parseInt(index, 16)]!}"`);
}
