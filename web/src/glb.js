/**
 * GLB files whose meshes are refined by a stream: the extension `TRISTRIP_progressive`.
 *
 * ```text
 * header │ JSON │ BIN: base meshes, textures, … │ chunks of the stream, in the last buffer view
 * ```
 * @module
 */
import { BIN_CHUNK, CHUNK_HEADER_BYTES, EXTENSION, HEADER_BYTES, JSON_CHUNK, JSON_START, MAGIC } from './container.js';
import { Decoder } from './decoder.js';
import { StreamError } from './error.js';
import { arrayOf, Waiting } from './growth.js';
import { min } from './math.js';

/** @import { DecoderOptions } from './decoder.js' */

const VERSION = 1;
/** The most bytes of the JSON, unless a limit says less. */
const MAX_JSON_BYTES = 2 ** 28;

/**
 * @param {number} at the byte
 * @param {string} found
 * @param {string} expected
 * @returns {never}
 */
function failAt(at, found, expected) {
  throw new StreamError(`byte ${at}`, found, expected);
}

/** Takes a GLB file apart as its bytes arrive, in pieces of any size. */
export class GlbReader {
  #mostJsonBytes;
  /** What has arrived of the headers and of the JSON. */
  #waiting = new Waiting();
  /** The bytes before the stream that are still to come, and those of the stream. */
  #beforeLeft = 0;
  #streamLeft = 0;
  /** @type {any} the glTF document, as soon as it has arrived */
  json;
  /** The byte of the file at which the stream starts; 0 if that is not known yet. */
  streamStart = 0;
  /** The length of the file, as its header says, and that of the binary chunk before the stream. */
  fileBytes = 0;
  beforeBytes = 0;
  /** @type {Uint8Array} of the bytes that were given last, those of the binary chunk before the stream */
  before = new Uint8Array(0);

  /**
   * @param {number} [mostJsonBytes]
   * @param {boolean} [isPlainToo] whether a file without a stream is taken as well
   */
  constructor(mostJsonBytes = MAX_JSON_BYTES, isPlainToo = false) {
    this.#mostJsonBytes = mostJsonBytes;
    this.isPlainToo = isPlainToo;
  }

  /**
   * Takes the next bytes of the file; returns those of the stream among them.
   *
   * Throws a `StreamError` if they are not those of a GLB with a stream.
   * @param {Uint8Array | ArrayBuffer} bytes
   * @returns {Uint8Array}
   */
  update(bytes) {
    let rest = arrayOf(bytes);
    if (!this.json) {
      rest = this.#waiting.add(rest);
      rest = rest.subarray(this.#readStart(rest) || rest.length);
    }
    const count = min(this.#beforeLeft, rest.length);
    this.before = rest.subarray(0, count);
    this.#beforeLeft -= count;
    const ofStream = rest.subarray(count, count + this.#streamLeft);
    this.#streamLeft -= ofStream.length;
    return ofStream;
  }

  /**
   * Reads the headers of the file and the JSON. Returns where the data of the binary chunk start, or 0 if that has not arrived.
   * @param {Uint8Array} bytes
   */
  #readStart(bytes) {
    if (bytes.length < JSON_START) return 0;
    const view = new DataView(bytes.buffer, bytes.byteOffset);
    const number = (/** @type {number} */ at) => view.getUint32(at, true);
    const jsonBytes = number(HEADER_BYTES);
    if (number(0) !== MAGIC || number(4) !== 2) failAt(0, 'no GLB of version 2', 'a GLB');
    if (number(HEADER_BYTES + 4) !== JSON_CHUNK) failAt(HEADER_BYTES, 'another chunk', 'a JSON chunk');
    if (jsonBytes > this.#mostJsonBytes) failAt(HEADER_BYTES, `${jsonBytes} bytes of JSON`, `at most ${this.#mostJsonBytes}`);
    const end = JSON_START + jsonBytes;
    const start = end + CHUNK_HEADER_BYTES;
    if (bytes.length < start) return 0;
    let json;
    try {
      json = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(bytes.subarray(JSON_START, end)));
    } catch {
      failAt(JSON_START, 'no JSON', 'a glTF document');
    }
    const isBinary = number(end + 4) === BIN_CHUNK;
    const binaryBytes = isBinary ? number(end) : 0;
    const extension = json?.extensions?.[EXTENSION];
    let before = binaryBytes;
    if (extension || !this.isPlainToo) {
      if (!extension) failAt(JSON_START, `no extension ${EXTENSION}`, 'a GLB with a stream');
      if (extension.version !== VERSION) failAt(JSON_START, `version ${extension.version} of the stream`, `version ${VERSION}`);
      const { buffer, byteOffset = 0, byteLength } = json.bufferViews?.[extension.bufferView] ?? {};
      const isCount = (/** @type {unknown} */ x) => Number.isSafeInteger(x) && Number(x) >= 0;
      if (buffer !== 0 || json.buffers?.[0]?.uri !== undefined || !isCount(byteOffset) || !isCount(byteLength)) {
        failAt(JSON_START, 'a stream without a buffer view in the file', 'one');
      }
      if (byteOffset + byteLength > binaryBytes) {
        failAt(end, isBinary ? `${binaryBytes} bytes` : 'another chunk', `a binary chunk of at least ${byteOffset + byteLength} bytes`);
      }
      before = byteOffset;
      this.#streamLeft = byteLength;
      this.streamStart = start + byteOffset;
    }
    this.beforeBytes = this.#beforeLeft = before;
    this.fileBytes = number(8);
    this.json = json;
    this.#waiting = new Waiting();
    return start;
  }
}

/** Decodes the stream in a GLB file as the bytes of the file arrive, in pieces of any size. */
export class GlbDecoder {
  #reader;
  #decoder;

  /** @param {DecoderOptions} [options] */
  constructor(options = {}) {
    this.#reader = new GlbReader(options.chunkBytes);
    this.#decoder = new Decoder(options);
  }

  /**
   * Takes the next bytes of the file, and decodes the chunks that are complete. Returns how many that were.
   *
   * Throws a `StreamError` if the bytes are not those of a GLB with a stream, or as `Decoder.update` does.
   * @param {Uint8Array | ArrayBuffer} bytes
   * @returns {number}
   */
  update(bytes) {
    return this.#decoder.update(this.#reader.update(bytes));
  }

  /**
   * The glTF document, as soon as it has arrived. Primitives that the stream refines have `extensions.TRISTRIP_progressive.stream`: the number of
   * their mesh.
   */
  get json() {
    return this.#reader.json;
  }

  /** The meshes whose base has arrived, in the order of their numbers. */
  get parts() {
    return this.#decoder.parts;
  }

  /**
   * Returns a mesh, if its base has arrived.
   * @param {number} stream its number
   */
  part(stream) {
    return this.#decoder.part(stream);
  }

  /** The number of chunks decoded. */
  get chunkCount() {
    return this.#decoder.chunkCount;
  }

  /** The number of bytes of the file up to the end of the last chunk decoded; 0 before the stream begins. */
  get offset() {
    return this.#reader.streamStart && this.#reader.streamStart + this.#decoder.offset;
  }
}
