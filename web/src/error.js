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

/** A fault whose place is known to the caller. */
export class Fault {
  /**
   * @param {string} found
   * @param {string} expected
   */
  constructor(found, expected) {
    this.found = found;
    this.expected = expected;
  }
}
