// The one door to the WebAssembly build of the chapter.
import init, { initSync } from '../../wasm/chapter.js';

export * as engine from '../../wasm/chapter.js';

/** Loads the module from an address. Call once, before anything else of this library. */
export async function load(address: string | URL): Promise<void> {
  await init({ module_or_path: address });
}

/** Loads the module from its bytes: for Node, and for pages that carry it inside. */
export function loadBytes(bytes: BufferSource): void {
  initSync({ module: bytes });
}

/** Numbers as the library gives them. */
export type Vector = Float64Array | readonly number[];

export function floats(vector: Vector): Float64Array {
  return vector instanceof Float64Array ? vector : Float64Array.from(vector);
}

/** A flat list cut into rows of equal width. */
export function rows(flat: Float64Array, width: number): number[][] {
  const count = Math.floor(flat.length / width);
  return Array.from({ length: count }, (_, row) => Array.from(flat.subarray(row * width, (row + 1) * width)));
}
