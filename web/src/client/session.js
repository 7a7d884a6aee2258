/**
 * A model in the worker, from its download to the messages to the page.
 *
 * ```text
 * download ─▶ pieces ─▶ GlbReader ─▶ document, binary
 *                           └─▶ received chunks ─▶ decoder ─▶ MeshBuffers ─▶ update
 * ```
 * # Algorithm
 * 1. Arriving bytes are split into chunks and queued. Chunks are decoded one at a time, yielding to
 *    the event loop in between.
 * 2. Changes are sent when the page has taken the previous update, and either the queue is empty or
 *    enough time has passed. This bounds the share of time spent on finding changes.
 * 3. To show fewer chunks, a new decoder starts with the first one. Refinements cannot be undone,
 *    but decoding is fast.
 * @module
 */
import { readChunkHead } from '../chunk.js';
import { CHUNK_HEADER_BYTES, EXTENSION, JSON_START } from '../container.js';
import { Decoder, USUAL_LIMITS } from '../decoder.js';
import { fail, StreamError } from '../error.js';
import { GlbReader } from '../glb.js';
import { Waiting } from '../growth.js';
import { Strips } from '../strips.js';
import { Download, DownloadError, piecesOf } from './download.js';
import { MeshBuffers } from './mesh_buffers.js';

/**
 * @import { ChunkFigures, ConnectionState, LoadOptions, MeshUpdate, ModelError, Progress } from './client.js'
 * @import { Link } from './link.js'
 */

/** The maximum duration of decoding before it yields to the event loop, in milliseconds. */
const SLICE = 12;
/**
 * While chunks are queued, an update waits for the longer of this interval in milliseconds and
 * `BUILD_SHARE` times the duration of the last build.
 */
const MIN_INTERVAL = 60;
const BUILD_SHARE = 3;
/** The interval of progress messages in milliseconds while no update is sent. */
const PROGRESS_INTERVAL = 100;
/**
 * The maximum number of primitives that a stream refines, because each update covers all parts of a
 * mesh.
 */
const MAX_PRIMITIVES = 2 ** 16;

/**
 * A chunk that has arrived.
 * @typedef {object} Chunk
 * @property {Uint8Array | undefined} bytes removed after decoding, unless the file is kept
 * @property {number} stream
 * @property {number} end file offset of the end of the chunk
 */

/** One model. */
export class Session {
  #post;
  #link;
  #turn;
  /** @type {LoadOptions} */
  #options = {};
  #isClosed = false;
  #downloading = new AbortController();
  #reader = new GlbReader(undefined, true);
  /** @type {Download | undefined} */
  #download;
  #receivedBytes = 0;
  #totalBytes = 0;
  /** The received bytes of the binary chunk before the stream. */
  #binaryBytes = 0;
  /**
   * Whether all bytes have arrived, or an error ended the download. The error is reported after all
   * chunks before it are shown.
   */
  #hasArrived = false;
  /** @type {ModelError | undefined} */
  #error;
  /** Bytes of the next chunk. */
  #waiting = new Waiting();
  /** @type {Chunk[]} */
  #chunks = [];
  /** @type {ChunkFigures[]} */
  #newChunks = [];
  /** The number of chunks decoded, and the number to decode. */
  #shown = 0;
  #target = Infinity;
  /** The number of chunks up to the last one with a base mesh. */
  #bases = 0;
  #decoder = new Decoder();
  /** @type {Map<number, MeshBuffers>} */
  #buffers = new Map();
  /**
   * The drawn parts of each mesh.
   * @type {Map<number, number[] | undefined>}
   */
  #parts = new Map();
  /**
   * The meshes changed since the last update.
   * @type {Set<number>}
   */
  #changed = new Set();
  #isTaken = true;
  #isPaused = false;
  #isDecoding = false;
  /** Whether chunks are decoded again that were shown before. */
  #isGoingBack = false;
  /** The maximum number of chunks shown so far. */
  #mostShown = 0;
  /** Whether decoding or building an update failed; nothing more is done then. */
  #hasFailed = false;
  #hasToldEnd = false;
  #lastUpdate = -Infinity;
  #lastBuild = 0;
  #lastProgress = -Infinity;
  #decodeMilliseconds = 0;
  #buildMilliseconds = 0;
  /** @type {ConnectionState | undefined} */
  #state;

  /**
   * @param {(message: any, transfer?: Transferable[]) => void} post sends a message to the page
   * @param {Link} link
   */
  constructor(post, link) {
    this.#post = post;
    this.#link = link;
    this.#turn = link.join();
  }

  /**
   * Handles a message of the page.
   * @param {any} message
   */
  receive(message) {
    switch (message.type) {
      case 'load':
        return this.#load(message.source, message.options);
      case 'taken':
        this.#isTaken = true;
        return this.#decode();
      case 'priority':
        this.#turn.priority = message.priority;
        return;
      case 'pause':
        this.#isPaused = true;
        return;
      case 'resume':
        this.#isPaused = false;
        this.#link.wake();
        return this.#decode();
      case 'retry':
        this.#download?.hurry();
        if (this.#error?.kind !== 'connection' || !this.#download) return;
        this.#error = undefined;
        this.#hasArrived = false;
        this.#hasToldEnd = false;
        this.#run(this.#download.pieces());
        return;
      case 'show':
        return this.#show(message.chunkCount);
      case 'close':
        this.#isClosed = true;
        this.#downloading.abort();
        this.#link.leave(this.#turn);
        return;
    }
  }

  /**
   * @param {import('./client.js').Source} source
   * @param {LoadOptions} options
   */
  #load(source, options) {
    this.#options = options;
    this.#reader = new GlbReader(options.limits?.chunkBytes, true);
    this.#turn.priority = options.priority ?? 0;
    this.#decoder = this.#newDecoder();
    if (typeof source === 'string') {
      const tell = (/** @type {ConnectionState} */ state, /** @type {number} */ seconds) => this.#tellState(state, seconds);
      this.#download = new Download(source, options, this.#link, this.#turn, this.#downloading.signal, tell);
      this.#run(this.#download.pieces());
      return;
    }
    const blob = source instanceof Blob ? source : new Blob([/** @type {ArrayBuffer} */ (source)]);
    this.#totalBytes = blob.size;
    this.#run(piecesOf(blob, this.#link));
  }

  #newDecoder() {
    const { limits, output } = this.#options;
    return new Decoder({ ...limits, ...(output === 'lists' ? {} : { strips: Strips, isLazy: true }) });
  }

  /**
   * @param {ConnectionState} state
   * @param {number} [seconds]
   */
  #tellState(state, seconds = 0) {
    if (state === this.#state && state !== 'retrying') return;
    this.#state = state;
    this.#post({ type: 'connection', state, seconds });
  }

  /**
   * Processes the bytes of the file as they arrive.
   * @param {AsyncGenerator<Uint8Array>} pieces
   */
  async #run(pieces) {
    try {
      for await (const piece of pieces) {
        if (this.#isOver) return;
        this.#take(piece);
        this.#decode();
        await this.#waitWhilePaused();
      }
      if (this.#isOver) return;
      this.#checkEnd();
      this.#totalBytes = this.#receivedBytes;
      this.#tellState('done');
    } catch (error) {
      if (this.#isOver) return;
      this.#error = this.#explain(error);
      this.#turn.end();
    }
    this.#hasArrived = true;
    this.#post({ type: 'progress', progress: this.#progress() });
    this.#decode();
  }

  get #isOver() {
    return this.#isClosed || this.#hasFailed;
  }

  async #waitWhilePaused() {
    while (this.#isPaused && !this.#isOver) {
      this.#tellState('paused');
      this.#turn.end();
      await this.#link.change();
    }
  }

  /**
   * Converts an error to a message for users.
   * @param {unknown} error
   * @returns {ModelError}
   */
  #explain(error) {
    if (error instanceof DownloadError) return { kind: error.kind, message: error.message };
    if (error instanceof StreamError) return { kind: this.#reader.json ? 'damaged' : 'not-glb', message: error.message };
    return { kind: 'limit', message: error instanceof Error ? error.message : String(error) };
  }

  #checkEnd() {
    const end = this.#receivedBytes;
    // A file may end after its JSON; this is treated as an empty binary chunk.
    if (end >= JSON_START && !this.#reader.json) this.#take(new Uint8Array(CHUNK_HEADER_BYTES));
    this.#receivedBytes = end;
    const { json, fileBytes } = this.#reader;
    const fail = (/** @type {string} */ found, /** @type {string} */ expected) => {
      throw new StreamError(`byte ${end}`, found, expected);
    };
    if (!json) fail('the end of the file', 'a GLB');
    if (this.#waiting.length > 0) fail('the end of the stream', 'the rest of a chunk');
    if (end < fileBytes) fail('the end of the file', `${fileBytes} bytes, as its header says`);
  }

  /**
   * Assigns bytes of the file to its sections.
   * @param {Uint8Array} piece
   */
  #take(piece) {
    const reader = this.#reader;
    const hadJson = reader.json !== undefined;
    const stream = reader.update(piece);
    this.#receivedBytes += piece.length;
    if (!reader.json) return;
    this.#totalBytes = this.#download?.totalBytes || reader.fileBytes;
    if (!hadJson) {
      this.#parts = partsOf(reader.json);
      this.#post({ type: 'document', json: reader.json, binaryBytes: reader.beforeBytes });
    }
    if (reader.before.length > 0) {
      const bytes = reader.before.slice();
      this.#post({ type: 'binary', bytes, start: this.#binaryBytes }, [bytes.buffer]);
      this.#binaryBytes += reader.before.length;
    }
    if (stream.length > 0) this.#cut(stream);
    const now = performance.now();
    if (now - this.#lastProgress < PROGRESS_INTERVAL) return;
    this.#lastProgress = now;
    this.#post({ type: 'progress', progress: this.#progress() });
  }

  /**
   * Splits bytes of the stream into chunks.
   * @param {Uint8Array} stream
   */
  #cut(stream) {
    const known = this.#waiting.length;
    const count = this.#chunks.length;
    let rest = known > 0 ? this.#waiting.add(stream) : stream;
    const most = this.#options.limits?.chunkBytes ?? USUAL_LIMITS.chunkBytes;
    for (let head; (head = readChunkHead(rest)); ) {
      // The decoder rejects the header of a chunk that is too large.
      const length = head.headBytes + (head.payloadBytes > most ? 0 : head.payloadBytes);
      if (rest.length < length) break;
      this.#addChunk(rest.slice(0, length), head);
      rest = rest.subarray(length);
    }
    if (known > 0 && this.#chunks.length === count) return;
    const left = rest.slice();
    this.#waiting = new Waiting();
    this.#waiting.add(left);
  }

  /**
   * @param {Uint8Array} bytes
   * @param {import('../chunk.js').ChunkHead} head
   */
  #addChunk(bytes, { stream, triangles, error, visits }) {
    const start = this.#chunks.length > 0 ? this.#chunks[this.#chunks.length - 1].end : this.#reader.streamStart;
    const end = start + bytes.length;
    this.#chunks.push({ bytes, stream, end });
    // The decoder rejects other errors.
    if (Number.isFinite(error)) this.#newChunks.push({ stream, end, triangles, error });
    if (visits === 0) this.#bases = this.#chunks.length;
  }

  /** Sends the chunks received to the page. */
  #tellChunks() {
    if (this.#newChunks.length > 0) this.#post({ type: 'chunks', chunks: this.#newChunks });
    this.#newChunks = [];
  }

  /** The number of chunks to show. */
  get #wanted() {
    return Math.min(Math.max(this.#target, this.#bases), this.#chunks.length);
  }

  /** @param {number} chunkCount */
  #show(chunkCount) {
    this.#target = Number.isNaN(chunkCount) ? Infinity : chunkCount;
    if (this.#wanted < this.#shown) {
      if (!this.#options.keepBytes) return;
      this.#decoder = this.#newDecoder();
      this.#buffers.clear();
      this.#shown = 0;
      this.#decodeMilliseconds = 0;
      this.#buildMilliseconds = 0;
      this.#isGoingBack = true;
    }
    this.#decode();
  }

  /** Decodes the received chunks that are to be shown, and sends updates. */
  async #decode() {
    if (this.#isDecoding) return;
    this.#isDecoding = true;
    try {
      this.#tellChunks();
      while (this.#canDecode) await this.#decodeChunks();
    } catch (error) {
      this.#stop(error);
    }
    this.#isDecoding = false;
    if (this.#isClosed || !this.#isTaken || this.#shown < this.#wanted) return;
    const isToTellEnd = this.#isComplete && !this.#hasToldEnd;
    if (isToTellEnd) for (const stream of this.#buffers.keys()) this.#changed.add(stream);
    try {
      if (isToTellEnd || this.#changed.size > 0) this.#sendUpdate();
    } catch (error) {
      this.#changed.clear();
      this.#stop(error);
    }
    if (this.#hasToldEnd || !(this.#error || this.#isComplete)) return;
    this.#hasToldEnd = true;
    if (this.#error) this.#post({ type: 'error', error: this.#error });
  }

  /**
   * Stops the download after an error in the data.
   * @param {unknown} error
   */
  #stop(error) {
    this.#error = this.#explain(error);
    this.#hasArrived = true;
    this.#hasFailed = true;
    this.#downloading.abort();
    this.#link.leave(this.#turn);
    this.#chunks.length = this.#shown;
  }

  /** Whether a chunk can be decoded. While paused, only chunks that were shown before. */
  get #canDecode() {
    const end = this.#isPaused ? Math.min(this.#wanted, this.#mostShown) : this.#wanted;
    return !this.#isClosed && this.#shown < end;
  }

  async #decodeChunks() {
    let end = performance.now() + SLICE;
    while (this.#canDecode) {
      const start = performance.now();
      this.#decodeChunk();
      const now = performance.now();
      this.#decodeMilliseconds += now - start;
      const interval = Math.max(MIN_INTERVAL, BUILD_SHARE * this.#lastBuild);
      if (this.#isTaken && !this.#isGoingBack && now - this.#lastUpdate > interval) this.#sendUpdate();
      if (now < end) continue;
      await pause();
      end = performance.now() + SLICE;
    }
  }

  #decodeChunk() {
    const chunk = this.#chunks[this.#shown];
    // Bytes are kept until they are decoded.
    this.#decoder.update(/** @type {Uint8Array} */ (chunk.bytes));
    if (!this.#options.keepBytes) chunk.bytes = undefined;
    this.#shown++;
    this.#mostShown = Math.max(this.#mostShown, this.#shown);
    this.#changed.add(chunk.stream);
  }

  /** Sends the changes. */
  #sendUpdate() {
    const start = performance.now();
    const isLast = this.#isComplete;
    /** @type {MeshUpdate[]} */
    const meshes = [];
    for (const stream of this.#changed) {
      const part = this.#decoder.part(stream);
      if (!part || !this.#parts.has(stream)) continue;
      let buffers = this.#buffers.get(stream);
      if (!buffers) this.#buffers.set(stream, (buffers = new MeshBuffers(stream, this.#parts.get(stream), this.#options.output ?? 'strips')));
      meshes.push(buffers.update(part, isLast));
    }
    this.#changed.clear();
    this.#isGoingBack = false;
    this.#isTaken = false;
    const now = performance.now();
    this.#lastUpdate = now;
    this.#lastBuild = now - start;
    this.#buildMilliseconds += now - start;
    const transfer = meshes.flatMap(({ positions, attributes, parts }) => [
      positions.buffer,
      ...attributes.map(({ array }) => array.buffer),
      ...parts.flatMap(({ ranges }) => ranges.map(({ array }) => array.buffer)),
    ]);
    this.#post({ type: 'update', update: { meshes, progress: this.#progress() } }, transfer);
  }

  get #isComplete() {
    return this.#hasArrived && !this.#error && this.#shown === this.#chunks.length;
  }

  /** @returns {Progress} */
  #progress() {
    return {
      receivedBytes: this.#receivedBytes,
      shownBytes: this.#isComplete ? this.#receivedBytes : this.#shown > 0 ? this.#chunks[this.#shown - 1].end : 0,
      totalBytes: this.#totalBytes,
      shownChunks: this.#shown,
      receivedChunks: this.#chunks.length,
      decodeMilliseconds: this.#decodeMilliseconds,
      buildMilliseconds: this.#buildMilliseconds,
      hasArrived: this.#hasArrived && !this.#error,
      isComplete: this.#isComplete,
    };
  }
}

/** Yields to the event loop of the worker. */
function pause() {
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      resolve(undefined);
    };
    port2.postMessage(undefined);
  });
}

/**
 * Returns the meshes of the stream that primitives draw, with the indices of the drawn parts, or
 * `undefined` if a primitive draws the whole mesh.
 * @param {any} json the glTF document
 */
function partsOf(json) {
  /** @type {Map<number, Set<number> | undefined>} */
  const parts = new Map();
  let count = 0;
  for (const mesh of listOf(json.meshes)) {
    for (const primitive of listOf(mesh?.primitives)) {
      const { stream, part } = primitive?.extensions?.[EXTENSION] ?? {};
      if (!Number.isSafeInteger(stream)) continue;
      if (++count > MAX_PRIMITIVES) fail(`more than ${MAX_PRIMITIVES} primitives`, 'fewer');
      if (!parts.has(stream)) parts.set(stream, new Set());
      if (Number.isSafeInteger(part)) parts.get(stream)?.add(part);
      else parts.set(stream, undefined);
    }
  }
  return new Map([...parts].map(([stream, numbers]) => [stream, numbers && [...numbers]]));
}

/**
 * @param {any} list
 * @returns {any[]}
 */
const listOf = (list) => (Array.isArray(list) ? list : []);
