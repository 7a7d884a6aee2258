/**
 * How much of a frame uploads may take, so that the main thread is never blocked for long.
 * @module
 */

const MILLISECONDS = 4;
const BYTES = 2 ** 21;
/** The most bytes of one upload. */
export const SLICE_BYTES = 2 ** 19;

/** What is left of the budget of one frame. */
export class Budget {
  #end = performance.now() + MILLISECONDS;
  #bytes = BYTES;

  /** @param {number} bytes that are uploaded */
  spend(bytes) {
    this.#bytes -= bytes;
  }

  /** The bytes that may still be uploaded. */
  get bytes() {
    return performance.now() < this.#end ? Math.max(this.#bytes, 0) : 0;
  }
}
