/**
 * Downloads a file in pieces, and resumes when the connection is lost.
 *
 * # Algorithm
 * After a connection loss, the rest of the file is requested with `Range`, after a delay that
 * doubles while nothing arrives. `If-Range` with the file's tag ensures that the rest belongs to
 * the same file. Cross-origin servers would have to allow `If-Range`, so the tags are compared
 * instead. If the server sends the whole file again, known bytes are skipped. A connection without
 * data for some time counts as lost. If the server answers 503 with `Retry-After`, for example
 * while it packs the file, the request is repeated after that time.
 * @module
 */

/**
 * @import { ConnectionState, ModelError } from './client.js'
 * @import { Link, Turn } from './link.js'
 */

/**
 * The first and the maximum delay after a loss, and the time after which a silent connection counts
 * as lost, in milliseconds.
 */
const FIRST_PAUSE = 500;
const LONGEST_PAUSE = 15_000;
const SILENCE = 20_000;
/** The number of tries without data before the download fails: before and after the first bytes. */
const FIRST_TRIES = 2;
const TRIES = 8;
/** The maximum number of busy answers of a server. */
const MAX_BUSY_ANSWERS = 500;
/** Status codes that are worth a retry. */
const TEMPORARY = new Set([408, 425, 429, 500, 502, 503, 504]);

/** An error that is reported to users. */
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

/** A connection loss after which the download resumes. */
class Loss extends Error {
  /**
   * @param {string} message
   * @param {number} pause the delay requested by the server, in milliseconds
   * @param {boolean} isBusy whether the server is available but asked to retry later
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
  /**
   * Ends the delay before the next try.
   * @type {AbortController | undefined}
   */
  #pausing;
  /** The tries since the last bytes, not counting busy answers. */
  #tries = 0;
  #busyAnswers = 0;
  /** Whether the server sends ranges without `Content-Range`. */
  #isWithoutRanges = false;
  receivedBytes = 0;

  /**
   * @param {string} url
   * @param {{ headers?: Record<string, string>, credentials?: RequestCredentials }} options
   * @param {Link} link
   * @param {Turn} turn
   * @param {AbortSignal} signal ends the download without an error
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

  /** Yields the remaining bytes of the file. Throws a `DownloadError`; call it again to resume. */
  async *pieces() {
    for (this.#tries = this.#busyAnswers = 0; ; ) {
      try {
        yield* this.#request();
        return;
      } catch (error) {
        if (this.#signal.aborted) return;
        if (error instanceof DownloadError) throw error;
        // `fetch` and its streams throw TypeErrors.
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
   * @param {number} least the delay requested by the server, in milliseconds
   * @param {boolean} isBusy
   */
  async #pause(least, isBusy) {
    const pause = Math.min(isBusy ? least : Math.max(least, FIRST_PAUSE * 2 ** (this.#tries - 1)), LONGEST_PAUSE);
    this.#onState(isBusy ? 'busy' : 'retrying', pause / 1000);
    const end = performance.now() + pause;
    const pausing = (this.#pausing = new AbortController());
    // Retry at once when the system reports a network connection.
    globalThis.addEventListener?.('online', () => pausing.abort(), { signal: pausing.signal });
    while (!this.#signal.aborted && !pausing.signal.aborted && performance.now() < end) await this.#link.change(Math.min(end - performance.now(), 250));
    pausing.abort();
  }

  /** Ends the delay before the next try. */
  hurry() {
    this.#pausing?.abort();
    this.#link.wake();
  }

  /** Requests the rest of the file and yields it. */
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
      // Cancels the unread rest.
      silence.abort();
    }
    if (this.receivedBytes < this.#totalBytes) throw new Loss('the file ended early');
    this.#onState('done', 0);
  }

  async #waitForTurn() {
    while (this.#link.mustWait(this.#turn) && !this.#signal.aborted) {
      this.#onState('waiting', 0);
      // Does not block other downloads while it waits.
      this.#turn.isActive = false;
      await this.#link.change();
    }
    this.#signal.throwIfAborted();
    this.#turn.begin();
  }

  /**
   * Yields bytes in pieces of the simulated network.
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
    // Equal weak tags do not guarantee equal bytes.
    if (this.#tag && !this.#tag.startsWith('W/') && this.#isOfThisSite) headers['If-Range'] = this.#tag;
    return headers;
  }

  get #isOfThisSite() {
    const { location } = globalThis;
    return !location || new URL(this.#url).origin === location.origin;
  }

  /**
   * Checks the headers of a response. Returns the number of leading bytes that are already known.
   * @param {Response} response
   */
  #check(response) {
    const { status, headers } = response;
    if (TEMPORARY.has(status)) {
      const seconds = Number(headers.get('Retry-After'));
      const pause = seconds > 0 ? 1000 * seconds : 0;
      throw new Loss(`the server responded with ${status}`, pause, status === 503 && pause > 0);
    }
    if (!response.ok && status !== 416) throw new DownloadError('status', `The server responded with ${status} ${response.statusText}`.trim());
    const tag = headers.get('ETag') ?? headers.get('Last-Modified') ?? '';
    const length = Number(headers.get('Content-Length'));
    const [, first, total] = /^bytes (\d+)-\d+\/(\d+|\*)$/.exec(headers.get('Content-Range') ?? '') ?? [];
    // Without `Content-Range`, the length can identify the rest.
    const isRest = status === 206 && (first ? Number(first) === this.receivedBytes : length > 0 && length === this.#totalBytes - this.receivedBytes);
    if (this.receivedBytes > 0 && (!isSameTag(this.#tag, tag) || status === 416 || (status === 206 && first && !isRest))) {
      throw new DownloadError('changed', 'The file on the server has changed since its download began.');
    }
    if (status === 206 && !isRest) {
      this.#isWithoutRanges = true;
      throw new Loss('the server did not send Content-Range');
    }
    this.#tag = tag;
    const all = status === 206 ? Number(total ?? this.#totalBytes) : headers.has('Content-Encoding') ? NaN : length;
    this.#totalBytes = all > 0 ? all : 0;
    return status === 206 ? 0 : this.receivedBytes;
  }

  /** The size of the file in bytes; 0 if unknown. */
  get totalBytes() {
    return this.#totalBytes;
  }
}

/**
 * Checks whether two tags can belong to the same file. A tag may be weak in one response and strong
 * in another if one of them is compressed.
 * @param {string} a
 * @param {string} b
 */
function isSameTag(a, b) {
  return a === '' || b === '' || a.replace(/^W\//, '') === b.replace(/^W\//, '');
}

/**
 * Yields the bytes of a local file.
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
    throw new DownloadError('unreadable', 'It may be a directory, or it was changed, moved or deleted after it was selected.');
  }
}
