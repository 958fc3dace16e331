import { beforeAll, describe, expect, it } from 'vitest';

import { loadFromDisk } from './load-from-disk.ts';
import { selfChecks } from './self-checks.ts';

beforeAll(loadFromDisk);

describe('self-checks', () => {
  it('reproduce every number of the chapter', () => {
    const checks = selfChecks();
    expect(checks.length).toBeGreaterThan(35);
    expect(checks.filter((check) => !check.passed)).toEqual([]);
  });
});
