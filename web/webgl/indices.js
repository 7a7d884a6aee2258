/**
 * Indices as in WebGL 2: in strips and fans, the maximum value restarts the primitive.
 * @module
 */

/** @import { IndexArray, IndexData } from './geometry.js' */

const LIST = 4;
const FAN = 6;

/** @param {IndexArray} array */
export const restartOf = (array) => 2 ** (8 * array.BYTES_PER_ELEMENT) - 1;

/**
 * Returns the number of triangles drawn, without degenerate triangles that join strips.
 * @param {Pick<IndexData, 'array' | 'length' | 'mode'>} indices
 */
export function countTriangles({ array, length, mode }) {
  if (mode < LIST) return 0;
  if (mode === LIST) return Math.floor(length / 3);
  if (!array) return Math.max(length - 2, 0);
  const restart = restartOf(array);
  let count = 0;
  let start = 0;
  for (let i = 0; i < length; i++) {
    if (array[i] === restart) start = i + 1;
    else if (i >= start + 2) {
      const [a, b, c] = [array[mode === FAN ? start : i - 2], array[i - 1], array[i]];
      if (a !== b && b !== c && c !== a) count++;
    }
  }
  return count;
}
