// Equations become MathML when the page is built: no fonts, no scripts, nothing fetched.
import katex from 'katex';
import type { Plugin } from 'vite';

/** A file `name: TeX` per line, imported as an object of MathML by name. */
export function equations(): Plugin {
  return {
    name: 'equations',
    transform(source, id) {
      if (!id.endsWith('.tex')) return null;
      const entries = source
        .split('\n')
        .filter((line) => line.trim() !== '' && !line.startsWith('%'))
        .map((line) => {
          const colon = line.indexOf(':');
          if (colon < 0) throw new Error(`${id}: a line is "name: TeX", found ${line}`);
          return [line.slice(0, colon).trim(), mathml(line.slice(colon + 1).trim())];
        });
      return { code: `export default ${JSON.stringify(Object.fromEntries(entries))};`, map: null };
    },
  };
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
