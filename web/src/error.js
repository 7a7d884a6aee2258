/** A fault of a stream: what came before it stays drawable. */
export class StreamError extends Error {
  /**
   * @param {string} at the chunk and the byte at which it starts
   * @param {string} found what is there
   * @param {string} expected what should be there
   */
  constructor(at, found, expected) {
    super(`${at}: found ${found}, expected ${expected}`);
    this.name = 'StreamError';
    this.at = at;
    this.found = found;
    this.expected = expected;
  }
}

/**
 * Throws a fault whose place is known to the caller.
 * @param {string} found
 * @param {string} expected
 * @returns {never}
 */
export function fail(found, expected) {
  throw new StreamError('', found, expected);
}
