// A square picture computed coarse to fine: every eighth point, then every fourth, every second, all.

const STRIDES = [8, 4, 2, 1] as const;

export interface Portion {
  /** Size of the block that each point fills until finer ones are computed. */
  stride: number;
  /** Indices of points in row-major order. */
  points: Uint32Array;
}

/** All points of a picture of `size` by `size`, each once, coarse ones first. Portions are small enough that
 * a new view does not wait long. */
export function* portions(size: number, each: number): Generator<Portion> {
  for (const stride of STRIDES) {
    const fresh: number[] = [];
    for (let row = 0; row < size; row += stride) {
      for (let column = 0; column < size; column += stride) {
        const known = stride < STRIDES[0] && row % (2 * stride) === 0 && column % (2 * stride) === 0;
        if (!known) fresh.push(row * size + column);
      }
    }
    for (let k = 0; k < fresh.length; k += each) yield { stride, points: Uint32Array.from(fresh.slice(k, k + each)) };
  }
}

/** Fills the block of a point in a picture of 32-bit pixels: the point itself, and pixels that are not
 * `known`. */
export function fill(
  pixels: Uint32Array, size: number, point: number, stride: number, colour: number, known: (pixel: number) => boolean,
): void {
  const [row, column] = [Math.floor(point / size), point % size];
  for (let y = row; y < Math.min(size, row + stride); y += 1) {
    for (let x = column; x < Math.min(size, column + stride); x += 1) {
      const pixel = y * size + x;
      if (pixel === point || !known(pixel)) pixels[pixel] = colour;
    }
  }
}
