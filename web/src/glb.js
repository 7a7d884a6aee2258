/**
 * GLB files whose meshes are refined by a stream: the extension `TRISTRIP_progressive`.
 *
 * ```text
 * header │ JSON │ BIN: base meshes, textures, … │ chunks of the stream, in the last buffer view
 * ```
 * @module
 */
import { Decoder } from './decoder.js';
import { StreamError } from './error.js';
import { grown } from './growth.js';

/** @import { DecoderOptions } from './decoder.js' */

const EXTENSION = 'TRISTRIP_progressive';
const VERSION = 1;

const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const BIN_CHUNK = 0x004e4942;
const HEADER_BYTES = 12;
const CHUNK_HEADER_BYTES = 8;
/** The most bytes of the JSON, unless a limit says less. */
const MOST_JSON_BYTES = 2 ** 28;

/** Decodes the stream in a GLB file as the bytes of the file arrive, in pieces of any size. */
export class GlbDecoder {
  #decoder;
  #mostJsonBytes;
  /** What has arrived of the next header or of the JSON. */
  #waiting = new Uint8Array(HEADER_BYTES);
  #waitingLength = 0;
  /** What to do with the next bytes when so many are there. */
  #wanted = HEADER_BYTES + CHUNK_HEADER_BYTES;
  #then = this.#readHeader;
  /** The bytes before the stream that are still to be skipped, and those of the stream that are still to come. */
  #skipped = 0;
  #streamLeft = 0;
  #streamStart = 0;
  /** The length of the file up to the binary chunk. */
  #binStart = 0;
  /** @type {StreamError | undefined} */
  #fault;
  /** @type {any} */
  #json;

  /** @param {DecoderOptions} [options] */
  constructor(options = {}) {
    this.#decoder = new Decoder(options);
    this.#mostJsonBytes = options.chunkBytes ?? MOST_JSON_BYTES;
  }

  /**
   * Takes the next bytes of the file, and decodes the chunks that are complete. Returns how many that were.
   *
   * Throws a `StreamError` if the bytes are not those of a GLB with a stream, or as `Decoder.update` does.
   * @param {Uint8Array | ArrayBuffer} bytes
   * @returns {number}
   */
  update(bytes) {
    if (this.#fault) throw this.#fault;
    let rest = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    while (this.#wanted > 0) {
      const taken = rest.subarray(0, this.#wanted - this.#waitingLength);
      this.#waiting = grown(this.#waiting, this.#waitingLength + taken.length);
      this.#waiting.set(taken, this.#waitingLength);
      this.#waitingLength += taken.length;
      rest = rest.subarray(taken.length);
      if (this.#waitingLength < this.#wanted) return 0;
      const complete = this.#waiting.subarray(0, this.#wanted);
      this.#waitingLength = 0;
      this.#then(complete);
    }
    const skipped = Math.min(this.#skipped, rest.length);
    this.#skipped -= skipped;
    const ofStream = rest.subarray(skipped, skipped + this.#streamLeft);
    this.#streamLeft -= ofStream.length;
    return this.#decoder.update(ofStream);
  }

  /**
   * @param {string} at
   * @param {string} found
   * @param {string} expected
   * @returns {never}
   */
  #fail(at, found, expected) {
    this.#fault = new StreamError(at, found, expected);
    throw this.#fault;
  }

  /**
   * Reads the header of the file and that of its first chunk.
   * @param {Uint8Array} bytes
   */
  #readHeader(bytes) {
    const view = new DataView(bytes.buffer, bytes.byteOffset);
    const length = view.getUint32(HEADER_BYTES, true);
    if (view.getUint32(0, true) !== MAGIC || view.getUint32(4, true) !== 2) this.#fail('byte 0', 'no GLB of version 2', 'a GLB with a stream');
    if (view.getUint32(HEADER_BYTES + 4, true) !== JSON_CHUNK) this.#fail(`byte ${HEADER_BYTES}`, 'another chunk', 'a JSON chunk');
    if (length > this.#mostJsonBytes) this.#fail(`byte ${HEADER_BYTES}`, `${length} bytes of JSON`, `at most ${this.#mostJsonBytes}`);
    this.#binStart = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + length;
    this.#wanted = length + CHUNK_HEADER_BYTES;
    this.#then = this.#readJson;
  }

  /**
   * Reads the JSON and the header of the binary chunk.
   * @param {Uint8Array} bytes
   */
  #readJson(bytes) {
    const jsonBytes = bytes.length - CHUNK_HEADER_BYTES;
    const at = `byte ${HEADER_BYTES + CHUNK_HEADER_BYTES}`;
    try {
      this.#json = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(bytes.subarray(0, jsonBytes)));
    } catch {
      this.#fail(at, 'no JSON', 'a glTF document');
    }
    const json = this.#json;
    const extension = json?.extensions?.[EXTENSION];
    if (!extension) this.#fail(at, `no extension ${EXTENSION}`, 'a GLB with a stream');
    if (extension.version !== VERSION) this.#fail(at, `version ${extension.version} of the stream`, `version ${VERSION}`);
    const view = json.bufferViews?.[extension.bufferView];
    const { buffer, byteOffset = 0, byteLength } = view ?? {};
    const isCount = (/** @type {unknown} */ x) => Number.isSafeInteger(x) && Number(x) >= 0;
    if (buffer !== 0 || json.buffers?.[0]?.uri !== undefined || !isCount(byteOffset) || !isCount(byteLength)) {
      this.#fail(at, 'a stream without a buffer view in the file', 'one');
    }
    const header = new DataView(bytes.buffer, bytes.byteOffset + jsonBytes);
    const length = header.getUint32(0, true);
    const isBinary = header.getUint32(4, true) === BIN_CHUNK;
    if (!isBinary || byteOffset + byteLength > length) {
      this.#fail(`byte ${this.#binStart - CHUNK_HEADER_BYTES}`, isBinary ? `${length} bytes` : 'another chunk', `a binary chunk of at least ${byteOffset + byteLength} bytes`);
    }
    this.#skipped = byteOffset;
    this.#streamLeft = byteLength;
    this.#streamStart = this.#binStart + byteOffset;
    this.#wanted = 0;
    this.#waiting = new Uint8Array(0);
  }

  /**
   * The glTF document, as soon as it has arrived. Primitives that the stream refines have `extensions.TRISTRIP_progressive.stream`: the number of
   * their mesh.
   */
  get json() {
    return this.#json;
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
    return this.#streamStart && this.#streamStart + this.#decoder.offset;
  }
}
