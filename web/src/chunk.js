/**
 * The framing of a stream: chunks with a header and a checksum.
 *
 * ```text
 * chunk  ─▶ stream · bytes of the payload · visits · level · triangles · error · checksum · payload
 * ```
 * Numbers are encoded in groups of seven bits, lowest first; the eighth bit is set in all bytes but
 * the last.
 * @module
 */
import { MAX_HEAD_BYTES } from './constants.js';
import { fail } from './error.js';

/**
 * The header of a chunk.
 * @typedef {object} ChunkHead
 * @property {number} stream the index of the mesh that the chunk refines
 * @property {number} payloadBytes
 * @property {number} visits the number of fans that it visits; 0 for a base mesh
 * @property {number} level the level after the chunk
 * @property {number} triangles the triangles of that level
 * @property {number} error the error of that level
 * @property {number} checksum
 * @property {number} headBytes the length of the header, including the checksum
 */

/** Reads values from bytes. */
export class Reader {
  /**
   * @param {Uint8Array} bytes
   * @param {string} expected the expectation to report if the bytes end
   */
  constructor(bytes, expected) {
    this.bytes = bytes;
    this.expected = expected;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  /**
   * Consumes bytes, and returns their offset.
   * @param {number} count
   * @returns {number}
   */
  take(count) {
    if (count > this.bytes.length - this.at) fail('the end of the chunk', this.expected);
    this.at += count;
    return this.at - count;
  }

  byte() {
    return this.bytes[this.take(1)];
  }

  /**
   * Reads a number of at most 32 bits.
   * @param {string} expected the expectation to report on an error
   */
  number(expected) {
    let number = 0;
    for (let scale = 1; scale <= 2 ** 28; scale *= 128) {
      const byte = this.byte();
      number += (byte & 0x7f) * scale;
      if (byte < 0x80 && number <= 0xffffffff) return number;
    }
    fail('a number of more than 32 bits', expected);
  }

  float() {
    return this.view.getFloat32(this.take(4), true);
  }

  double() {
    return this.view.getFloat64(this.take(8), true);
  }
}

/**
 * Reads the header of a chunk. Returns `undefined` if the bytes end.
 * @param {Uint8Array} bytes
 * @returns {ChunkHead | undefined}
 */
export function readChunkHead(bytes) {
  // Zero padding lets the reader run past the end; the result is discarded then.
  const padded = new Uint8Array(MAX_HEAD_BYTES);
  padded.set(bytes.subarray(0, MAX_HEAD_BYTES));
  const reader = new Reader(padded, '');
  const number = () => reader.number('the head of a chunk');
  const [stream, payloadBytes, visits, level, triangles] = [number(), number(), number(), number(), number()];
  const error = reader.float();
  const checksum = reader.view.getUint32(reader.take(4), true);
  const headBytes = reader.at;
  return headBytes > bytes.length ? undefined : { stream, payloadBytes, visits, level, triangles, error, checksum, headBytes };
}

/** The CRC table. */
const REMAINDERS = Int32Array.from({ length: 256 }, (_, byte) => {
  for (let i = 0; i < 8; i++) byte = byte & 1 ? (byte >>> 1) ^ 0xedb88320 : byte >>> 1;
  return byte;
});

/** A CRC-32. */
export class Checksum {
  #state = -1;

  /** @param {Uint8Array} bytes */
  addBytes(bytes) {
    let state = this.#state;
    for (let i = 0; i < bytes.length; i++) state = REMAINDERS[(state ^ bytes[i]) & 255] ^ (state >>> 8);
    this.#state = state;
  }

  /**
   * Adds a 32-bit number, lowest byte first.
   * @param {number} number
   */
  addNumber(number) {
    let state = this.#state ^ number;
    for (let i = 0; i < 4; i++) state = REMAINDERS[state & 255] ^ (state >>> 8);
    this.#state = state;
  }

  get value() {
    return ~this.#state >>> 0;
  }
}
