/**
 * The connection that all downloads of a worker share: whose turn it is, and a simulated bandwidth.
 * @module
 */

/** A download that brings nothing for so long does not hold up those of lower priority, in milliseconds. */
const STALLED = 2000;
/** Pieces of a simulated network: the time that each takes, in seconds, and the fewest bytes. */
const PIECE_SECONDS = 1 / 64;
const MIN_PIECE = 256;

/** A download's place among the others. */
export class Turn {
  #link;
  #priority = 0;
  /** Whether it downloads or tries to, and when it has last got something. */
  isActive = false;
  last = 0;

  /** @param {Link} link */
  constructor(link) {
    this.#link = link;
  }

  get priority() {
    return this.#priority;
  }

  /** Downloads of the highest priority come first. */
  set priority(priority) {
    this.#priority = Number.isNaN(priority) ? 0 : priority;
    this.#link.wake();
  }

  /** Notes that it downloads, or has got something. */
  begin() {
    this.isActive = true;
    this.last = performance.now();
  }

  /** Notes that it does not download. */
  end() {
    this.isActive = false;
    this.#link.wake();
  }
}

/** The connection that downloads share. */
export class Link {
  /** @type {Set<Turn>} */
  #turns = new Set();
  /** @type {Set<() => void>} */
  #waiting = new Set();
  #bitsPerSecond = 0;
  /** When the simulated network has delivered all that was asked for. */
  #free = 0;

  /** Returns the turn of a new download. */
  join() {
    const turn = new Turn(this);
    this.#turns.add(turn);
    return turn;
  }

  /** @param {Turn} turn */
  leave(turn) {
    this.#turns.delete(turn);
    this.wake();
  }

  /** Lets all that wait look again. */
  wake() {
    for (const look of [...this.#waiting]) look();
  }

  /**
   * Returns whether others come first.
   * @param {Turn} turn
   */
  mustWait(turn) {
    const now = performance.now();
    for (const other of this.#turns) {
      if (other.priority > turn.priority && other.isActive && now - other.last < STALLED) return true;
    }
    return false;
  }

  /** Waits until something changes, or some time is over. */
  async change(milliseconds = STALLED / 4) {
    await new Promise((resolve) => {
      const look = () => {
        clearTimeout(timer);
        this.#waiting.delete(look);
        resolve(undefined);
      };
      const timer = setTimeout(look, milliseconds);
      this.#waiting.add(look);
    });
  }

  /** Simulates a network; 0 for none. */
  set bitsPerSecond(/** @type {number} */ bitsPerSecond) {
    this.#bitsPerSecond = bitsPerSecond > 0 ? bitsPerSecond : 0;
    this.#free = 0;
    this.wake();
  }

  /** The most bytes that are delivered at once. */
  get pieceBytes() {
    return this.#bitsPerSecond === 0 ? Infinity : Math.max(MIN_PIECE, Math.floor((this.#bitsPerSecond / 8) * PIECE_SECONDS));
  }

  /**
   * Waits for the time that the simulated network takes for some bytes.
   * @param {number} bytes
   */
  async deliver(bytes) {
    if (this.#bitsPerSecond === 0) return;
    const now = performance.now();
    this.#free = Math.max(this.#free, now) + (bytes * 8000) / this.#bitsPerSecond;
    const free = this.#free;
    while (this.#free >= free && performance.now() < free) await this.change(free - performance.now());
  }
}
