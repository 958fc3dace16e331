// Whether a module with vector registers can be loaded. A module cannot test it at run time.

/** (module (func (result v128) i32.const 0 i8x16.splat i8x16.popcnt)) */
const MODULE = Uint8Array.of(
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
);

/** Whether this engine accepts it. */
export function hasSimd128() {
  return WebAssembly.validate(MODULE);
}
