/** An error in a stream. The part decoded before it can still be drawn. */
export class StreamError extends Error {
  /**
   * @param {string} at the chunk and its byte offset
   * @param {string} found
   * @param {string} expected
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
 * Throws a stream error whose location the caller adds.
 * @param {string} found
 * @param {string} expected
 * @returns {never}
 */
export function fail(found, expected) {
  throw new StreamError('', found, expected);
}
