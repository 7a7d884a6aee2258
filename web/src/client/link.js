/**
 * The connection shared by all downloads of a worker: priorities, and a simulated bandwidth.
 * @module
 */

/**
 * A download without data for this long stops blocking those of lower priority, in milliseconds.
 */
const STALLED = 2000;
/**
 * Pieces of the simulated network: the duration of each in seconds, and the minimum size in bytes.
 */
const PIECE_SECONDS = 1 / 64;
const MIN_PIECE = 256;

/** The scheduling state of a download. */
export class Turn {
  #link;
  #priority = 0;
  /** Whether it is downloading or connecting, and the time of its last data. */
  isActive = false;
  last = 0;

  /** @param {Link} link */
  constructor(link) {
    this.#link = link;
  }

  get priority() {
    return this.#priority;
  }

  /** The priority; downloads with the highest priority come first. */
  set priority(priority) {
    this.#priority = Number.isNaN(priority) ? 0 : priority;
    this.#link.wake();
  }

  /** Marks the download as active; call it again when data arrive. */
  begin() {
    this.isActive = true;
    this.last = performance.now();
  }

  /** Marks the download as inactive. */
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
  /** The time when the simulated network will have delivered all requested bytes. */
  #free = 0;

  /** Registers a new download. */
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

  /** Makes all waiting downloads check again. */
  wake() {
    for (const look of [...this.#waiting]) look();
  }

  /**
   * Returns whether downloads of higher priority come first.
   * @param {Turn} turn
   */
  mustWait(turn) {
    const now = performance.now();
    for (const other of this.#turns) {
      if (other.priority > turn.priority && other.isActive && now - other.last < STALLED) return true;
    }
    return false;
  }

  /** Waits until something changes, or until a timeout. */
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

  /** The simulated bandwidth; 0 for unlimited. */
  set bitsPerSecond(/** @type {number} */ bitsPerSecond) {
    this.#bitsPerSecond = bitsPerSecond > 0 ? bitsPerSecond : 0;
    this.#free = 0;
    this.wake();
  }

  /** The maximum size of a delivered piece, in bytes. */
  get pieceBytes() {
    return this.#bitsPerSecond === 0 ? Infinity : Math.max(MIN_PIECE, Math.floor((this.#bitsPerSecond / 8) * PIECE_SECONDS));
  }

  /**
   * Waits as long as the simulated network takes for some bytes.
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
