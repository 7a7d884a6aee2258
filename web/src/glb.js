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
/** The default maximum size of the JSON, in bytes. */
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

/** Splits a GLB file into its sections incrementally, from bytes in pieces of any size. */
export class GlbReader {
  #mostJsonBytes;
  /** The received bytes of the headers and the JSON. */
  #waiting = new Waiting();
  /** The remaining bytes before the stream, and of the stream. */
  #beforeLeft = 0;
  #streamLeft = 0;
  /**
   * The glTF document, once it has arrived.
   * @type {any}
   */
  json;
  /** The file offset of the stream; 0 if unknown. */
  streamStart = 0;
  /** The declared length of the file, and the length of the binary chunk before the stream. */
  fileBytes = 0;
  beforeBytes = 0;
  /**
   * The bytes of the binary chunk before the stream, among the bytes of the last call.
   * @type {Uint8Array}
   */
  before = new Uint8Array(0);

  /**
   * @param {number} [mostJsonBytes]
   * @param {boolean} [isPlainToo] whether to accept files without a stream
   */
  constructor(mostJsonBytes = MAX_JSON_BYTES, isPlainToo = false) {
    this.#mostJsonBytes = mostJsonBytes;
    this.isPlainToo = isPlainToo;
  }

  /**
   * Consumes bytes of the file, and returns those that belong to the stream.
   *
   * Throws a `StreamError` if the bytes are not a GLB with a stream.
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
   * Reads the headers of the file and the JSON. Returns the offset of the data of the binary chunk,
   * or 0 if it has not arrived.
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

/** Decodes the stream in a GLB file incrementally, from bytes in pieces of any size. */
export class GlbDecoder {
  #reader;
  #decoder;

  /** @param {DecoderOptions} [options] */
  constructor(options = {}) {
    this.#reader = new GlbReader(options.chunkBytes);
    this.#decoder = new Decoder(options);
  }

  /**
   * Consumes bytes of the file, and decodes all complete chunks. Returns their number.
   *
   * Throws a `StreamError` if the bytes are not a GLB with a stream, or for the reasons of
   * `Decoder.update`.
   * @param {Uint8Array | ArrayBuffer} bytes
   * @returns {number}
   */
  update(bytes) {
    return this.#decoder.update(this.#reader.update(bytes));
  }

  /**
   * The glTF document, once it has arrived. Primitives that the stream refines have the index of
   * their mesh in `extensions.TRISTRIP_progressive.stream`.
   */
  get json() {
    return this.#reader.json;
  }

  /** The meshes whose base mesh has arrived, ordered by index. */
  get parts() {
    return this.#decoder.parts;
  }

  /**
   * Returns a mesh if its base mesh has arrived.
   * @param {number} stream the index of the mesh
   */
  part(stream) {
    return this.#decoder.part(stream);
  }

  /** The number of chunks decoded. */
  get chunkCount() {
    return this.#decoder.chunkCount;
  }

  /** The file offset of the end of the last decoded chunk; 0 before the stream starts. */
  get offset() {
    return this.#reader.streamStart && this.#reader.streamStart + this.#decoder.offset;
  }
}
