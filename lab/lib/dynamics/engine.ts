// Access to the WebAssembly build of the chapter.
import init, { initSync } from '../../wasm/chapter.js';

export * as engine from '../../wasm/chapter.js';

/** Loads the module from an address. Must be called once, before everything else of this library. */
export async function load(address: string | URL): Promise<void> {
  await init({ module_or_path: address });
}

/** Loads the module from its bytes, for Node and for pages that contain it. */
export function loadBytes(bytes: BufferSource): void {
  initSync({ module: bytes });
}

/** Numbers as the library returns them. */
export type Vector = Float64Array | readonly number[];

export function floats(vector: Vector): Float64Array {
  return vector instanceof Float64Array ? vector : Float64Array.from(vector);
}

/** Numbers of a fixed count: `tuple(arm.q, 2)` is a pair. Throws for another length. */
export type Tuple<N extends number, T extends number[] = []> = T['length'] extends N ? T : Tuple<N, [...T, number]>;

export function tuple<N extends 2 | 3 | 4>(list: ArrayLike<number>, count: N): Tuple<N> {
  if (list.length !== count) throw new Error(`${String(count)} numbers were expected, ${String(list.length)} came`);
  return Array.from(list) as Tuple<N>;
}

/** The columns of a flat list of rows, for plots and trails. */
export function columns(flat: Float64Array, width: number): Float64Array[] {
  const count = Math.floor(flat.length / width);
  return Array.from({ length: width }, (_, k) => {
    const column = new Float64Array(count);
    for (let row = 0, at = k; row < count; row += 1, at += width) column[row] = flat[at]!;
    return column;
  });
}

/** Splits a flat list into rows of equal width. */
export function rows(flat: Float64Array, width: number): number[][] {
  const count = Math.floor(flat.length / width);
  return Array.from({ length: count }, (_, row) => Array.from(flat.subarray(row * width, (row + 1) * width)));
}
