/**
 * Limits the uploads per frame, so that they never block the main thread for long.
 * @module
 */

const MILLISECONDS = 4;
const BYTES = 2 ** 21;
/** The maximum size of one upload, in bytes. */
export const SLICE_BYTES = 2 ** 19;

/** The remaining budget of one frame. */
export class Budget {
  #end = performance.now() + MILLISECONDS;
  #bytes = BYTES;

  /** @param {number} bytes uploaded */
  spend(bytes) {
    this.#bytes -= bytes;
  }

  /** The bytes that may still be uploaded. */
  get bytes() {
    return performance.now() < this.#end ? Math.max(this.#bytes, 0) : 0;
  }
}
