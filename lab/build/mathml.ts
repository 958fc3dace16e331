// Formulas as MathML, rendered when the page is built: no scripts, nothing fetched.
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

function mathml(tex: string): string {
  const html = katex.renderToString(tex, { output: 'mathml', throwOnError: true, displayMode: false });
  const math = /<math[\s\S]*<\/math>/.exec(html)?.[0];
  if (math === undefined) throw new Error(`no MathML for ${tex}`);
  // The TeX source, kept by KaTeX as an annotation, is not for the page.
  return math
    .replace(/<annotation[\s\S]*?<\/annotation>/g, '')
    .replace(/<\/?semantics>/g, '');
}
