// The linter checks TypeScript only; this test checks the width of style sheets.
import { readdirSync, readFileSync } from 'node:fs';

import { expect, it } from 'vitest';

const WIDTH = 140;

it('no style sheet has a line that is too long', () => {
  const folder = new URL('./', import.meta.url);
  const sheets = readdirSync(folder).filter((name) => name.endsWith('.css'));
  expect(sheets.length).toBeGreaterThan(4);
  for (const name of sheets) {
    readFileSync(new URL(name, folder), 'utf8').split('\n').forEach((line, k) => {
      expect(line.length, `${name}:${String(k + 1)}`).toBeLessThanOrEqual(WIDTH);
    });
  }
});
