// Round numbers along an axis.
import { powerOfTen } from '../element.ts';

export interface Tick {
  value: number;
  text: string;
}

/** Digits after the decimal point of multiples of a round step. */
export function digitsOf(step: number): number {
  const isWhole = (x: number): boolean => Math.abs(x - Math.round(x)) < 1e-9 * x;
  let digits = 0;
  while (digits < 20 && !isWhole(step * 10 ** digits)) digits += 1;
  return digits;
}

/** About `count` multiples of 1, 2 or 5 times a power of ten. */
export function linearTicks(low: number, high: number, count: number): Tick[] {
  const rough = (high - low) / Math.max(1, count);
  if (!(rough > 0) || !Number.isFinite(rough)) return [];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10);
  const digits = digitsOf(step);
  const ticks: Tick[] = [];
  // Adding zero turns −0 into 0.
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) {
    ticks.push({ value: k * step + 0, text: (k * step).toFixed(digits).replace('-', '−') });
  }
  return ticks;
}

/** Powers of ten between two exponents, at most six of them. */
export function logTicks(low: number, high: number): Tick[] {
  const stride = Math.max(1, Math.ceil((high - low) / 5));
  const ticks: Tick[] = [];
  for (let exponent = Math.ceil(low); exponent <= high; exponent += 1) {
    if ((Math.ceil(high) - exponent) % stride !== 0) continue;
    const value = 10 ** exponent;
    ticks.push({ value, text: exponent === 0 ? '1' : powerOfTen(exponent) });
  }
  return ticks;
}
