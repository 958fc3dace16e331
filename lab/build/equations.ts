// A file with lines `name: TeX`, imported as an object of MathML by name.
import type { Plugin } from 'vite';

import { formulas } from './mathml.ts';

export function equations(): Plugin {
  return {
    name: 'equations',
    transform(source, id) {
      if (!id.endsWith('.tex')) return null;
      return { code: `export default ${JSON.stringify(formulas(source, id))};`, map: null };
    },
  };
}
