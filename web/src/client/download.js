/**
 * Downloads a file, in pieces, and goes on where it was when the connection is lost.
 *
 * # Algorithm
 * A request for the rest of the file (`Range`) follows each loss, after a pause that doubles while nothing arrives. `If-Range` has the file's tag, so that the rest belongs to the same file; other
 * sites get no `If-Range`, which they would have to allow, and the tags are compared. Of a whole file that is sent again, what is known is skipped. A download that gets no byte for some time is
 * taken for lost. A server that says when to ask again (503 with `Retry-After`), as one does that makes the file first, is asked again for as long as it says so.
 * @module
 */

/**
 * @import { ConnectionState, ModelError } from './client.js'
 * @import { Link, Turn } from './link.js'
 */

/** The pause after the first loss and the longest one, and the time after which a silent connection counts as lost, in milliseconds. */
const FIRST_PAUSE = 500;
const LONGEST_PAUSE = 15_000;
const SILENCE = 20_000;
/** The tries without a byte before it fails: at first, and after bytes have come. */
const FIRST_TRIES = 2;
const TRIES = 8;
/** How often a server may say that it is busy. */
const MAX_BUSY_ANSWERS = 500;
/** Answers that may be others at the next try. */
const TEMPORARY = new Set([408, 425, 429, 500, 502, 503, 504]);

/** An error that people are told of. */
export class DownloadError extends Error {
  /**
   * @param {ModelError['kind']} kind
   * @param {string} message
   */
  constructor(kind, message) {
    super(message);
    this.kind = kind;
  }
}

/** A loss after which the download goes on. */
class Loss extends Error {
  /**
   * @param {string} message
   * @param {number} pause the milliseconds that the server asks for
   * @param {boolean} isBusy whether the server is there, and answers later
   */
  constructor(message, pause = 0, isBusy = false) {
    super(message);
    this.pause = pause;
    this.isBusy = isBusy;
  }
}

/** Downloads one file. */
export class Download {
  #url;
  #options;
  #link;
  #turn;
  #onState;
  #signal;
  #tag = '';
  #totalBytes = 0;
  /** @type {AbortController | undefined} ends the pause before the next try */
  #pausing;
  /** The tries since bytes have come, without those that a busy server has answered. */
  #tries = 0;
  #busyAnswers = 0;
  /** Whether the server does not say which bytes it sends. */
  #isWithoutRanges = false;
  receivedBytes = 0;

  /**
   * @param {string} url
   * @param {{ headers?: Record<string, string>, credentials?: RequestCredentials }} options
   * @param {Link} link
   * @param {Turn} turn
   * @param {AbortSignal} signal ends it without an error
   * @param {(state: ConnectionState, seconds: number) => void} onState
   */
  constructor(url, options, link, turn, signal, onState) {
    this.#url = url;
    this.#options = options;
    this.#link = link;
    this.#turn = turn;
    this.#signal = signal;
    this.#onState = onState;
  }

  /** Yields the bytes of the file that have not come yet. Throws a `DownloadError`; the download may be continued by another call. */
  async *pieces() {
    for (this.#tries = this.#busyAnswers = 0; ; ) {
      try {
        yield* this.#request();
        return;
      } catch (error) {
        if (this.#signal.aborted) return;
        if (error instanceof DownloadError) throw error;
        // Errors of `fetch` and of its streams are TypeErrors.
        if (!(error instanceof Loss || error instanceof TypeError || (error instanceof DOMException && error.name !== 'AbortError'))) throw error;
        const { pause, isBusy } = error instanceof Loss ? error : { pause: 0, isBusy: false };
        const isLast = isBusy ? ++this.#busyAnswers >= MAX_BUSY_ANSWERS : ++this.#tries >= (this.receivedBytes > 0 ? TRIES : FIRST_TRIES);
        if (isLast) throw new DownloadError('connection', `The connection was lost: ${error.message}`);
        await this.#pause(pause, isBusy);
        if (this.#signal.aborted) return;
      } finally {
        this.#turn.end();
      }
    }
  }

  /**
   * Waits before the next try.
   * @param {number} least the milliseconds that the server asks for
   * @param {boolean} isBusy
   */
  async #pause(least, isBusy) {
    const pause = Math.min(isBusy ? least : Math.max(least, FIRST_PAUSE * 2 ** (this.#tries - 1)), LONGEST_PAUSE);
    this.#onState(isBusy ? 'busy' : 'retrying', pause / 1000);
    const end = performance.now() + pause;
    const pausing = (this.#pausing = new AbortController());
    // The system says that there is a network again.
    globalThis.addEventListener?.('online', () => pausing.abort(), { signal: pausing.signal });
    while (!this.#signal.aborted && !pausing.signal.aborted && performance.now() < end) await this.#link.change(Math.min(end - performance.now(), 250));
    pausing.abort();
  }

  /** Ends the pause before the next try. */
  hurry() {
    this.#pausing?.abort();
    this.#link.wake();
  }

  /** Requests the rest of the file, and yields it. */
  async *#request() {
    const silence = new AbortController();
    const signal = AbortSignal.any([this.#signal, silence.signal]);
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    let timer;
    const expect = () => (timer = setTimeout(() => silence.abort(new Loss('no data for 20 seconds')), SILENCE));
    try {
      this.#onState('connecting', 0);
      this.#turn.begin();
      expect();
      const response = await fetch(this.#url, { headers: this.#requestHeaders(), credentials: this.#options.credentials, signal });
      let skipped = this.#check(response);
      clearTimeout(timer);
      if (!response.body) return;
      const reader = response.body.getReader();
      try {
        for (;;) {
          await this.#waitForTurn();
          this.#onState('loading', 0);
          expect();
          const { value, done } = await reader.read();
          clearTimeout(timer);
          if (done) break;
          this.#turn.begin();
          const rest = value.subarray(Math.min(skipped, value.length));
          skipped -= value.length - rest.length;
          if (rest.length === 0) continue;
          this.#tries = this.#busyAnswers = 0;
          yield* this.#deliver(rest);
        }
      } finally {
        reader.cancel().catch(() => {});
      }
    } finally {
      clearTimeout(timer);
      // Ends what is not read.
      silence.abort();
    }
    if (this.receivedBytes < this.#totalBytes) throw new Loss('the file ended early');
    this.#onState('done', 0);
  }

  async #waitForTurn() {
    while (this.#link.mustWait(this.#turn) && !this.#signal.aborted) {
      this.#onState('waiting', 0);
      // It does not hold up others while it waits.
      this.#turn.isActive = false;
      await this.#link.change();
    }
    this.#signal.throwIfAborted();
    this.#turn.begin();
  }

  /**
   * Yields bytes in the pieces of the simulated network.
   * @param {Uint8Array<ArrayBuffer>} bytes
   */
  async *#deliver(bytes) {
    for (let start = 0; start < bytes.length; ) {
      const piece = bytes.subarray(start, start + this.#link.pieceBytes);
      await this.#link.deliver(piece.length);
      if (this.#signal.aborted) return;
      start += piece.length;
      this.receivedBytes += piece.length;
      this.#turn.begin();
      yield piece;
    }
  }

  #requestHeaders() {
    /** @type {Record<string, string>} */
    const headers = { ...this.#options.headers };
    if (this.receivedBytes === 0 || this.#isWithoutRanges) return headers;
    headers.Range = `bytes=${this.receivedBytes}-`;
    // Tags that are weak do not tell that the bytes are the same.
    if (this.#tag && !this.#tag.startsWith('W/') && this.#isOfThisSite) headers['If-Range'] = this.#tag;
    return headers;
  }

  get #isOfThisSite() {
    const { location } = globalThis;
    return !location || new URL(this.#url).origin === location.origin;
  }

  /**
   * Checks the head of an answer; returns the bytes at its start that are known already.
   * @param {Response} response
   */
  #check(response) {
    const { status, headers } = response;
    if (TEMPORARY.has(status)) {
      const seconds = Number(headers.get('Retry-After'));
      const pause = seconds > 0 ? 1000 * seconds : 0;
      throw new Loss(`the server answers ${status}`, pause, status === 503 && pause > 0);
    }
    if (!response.ok && status !== 416) throw new DownloadError('status', `The server answers ${status} ${response.statusText}`.trim());
    const tag = headers.get('ETag') ?? headers.get('Last-Modified') ?? '';
    const length = Number(headers.get('Content-Length'));
    const [, first, total] = /^bytes (\d+)-\d+\/(\d+|\*)$/.exec(headers.get('Content-Range') ?? '') ?? [];
    // Where the range is not told, its length may tell it.
    const isRest = status === 206 && (first ? Number(first) === this.receivedBytes : length > 0 && length === this.#totalBytes - this.receivedBytes);
    if (this.receivedBytes > 0 && (!isSameTag(this.#tag, tag) || status === 416 || (status === 206 && first && !isRest))) {
      throw new DownloadError('changed', 'The file on the server has changed since its download began.');
    }
    if (status === 206 && !isRest) {
      this.#isWithoutRanges = true;
      throw new Loss('the server does not say which bytes it sends');
    }
    this.#tag = tag;
    const all = status === 206 ? Number(total ?? this.#totalBytes) : headers.has('Content-Encoding') ? NaN : length;
    this.#totalBytes = all > 0 ? all : 0;
    return status === 206 ? 0 : this.receivedBytes;
  }

  /** The bytes of the file; 0 if they are not known. */
  get totalBytes() {
    return this.#totalBytes;
  }
}

/**
 * Returns whether two tags are those of one file, as far as they tell. A tag may be weak in one answer and strong in another, where one of them is compressed.
 * @param {string} a
 * @param {string} b
 */
function isSameTag(a, b) {
  return a === '' || b === '' || a.replace(/^W\//, '') === b.replace(/^W\//, '');
}

/**
 * Yields the bytes of a file that is there.
 * @param {Blob} blob
 * @param {Link} link
 */
export async function* piecesOf(blob, link) {
  for (let start = 0; start < blob.size; ) {
    const end = Math.min(start + Math.min(link.pieceBytes, 1 << 18), blob.size);
    await link.deliver(end - start);
    yield await readPiece(blob.slice(start, end));
    start = end;
  }
}

/** @param {Blob} piece */
async function readPiece(piece) {
  try {
    return new Uint8Array(await piece.arrayBuffer());
  } catch {
    throw new DownloadError('unreadable', 'It may be a folder, or it was changed, moved or deleted after it was chosen.');
  }
}
