import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { crc32 } from 'node:zlib';
import { readChunkHead } from '../src/chunk.js';

/**
 * A stream, and the expected state of a decoder after each chunk.
 * @typedef {{ name: string, bytes: Uint8Array, chunks: any[], parts: any[] }} Vector
 */

const FOLDER = new URL('../../testdata/stream/v1/', import.meta.url);

/**
 * @param {URL | string} bin
 * @param {string} name
 * @returns {Vector}
 */
function readVector(bin, name) {
  const { chunks, parts } = JSON.parse(readFileSync(new URL(bin.toString().replace(/\.bin$/, '.json'), FOLDER), 'utf8'));
  return { name, bytes: new Uint8Array(readFileSync(new URL(bin, FOLDER))), chunks, parts };
}

/** @returns {Vector[]} */
export function vectors() {
  const names = readdirSync(FOLDER).filter((name) => name.endsWith('.bin'));
  if (names.length === 0) throw new Error(`no streams in ${FOLDER}`);
  return names.sort().map((name) => readVector(new URL(name, FOLDER), name.replace('.bin', '')));
}

/**
 * Returns the stream of the bunny, if `TRISTRIP_BUNNY` is its path. The expected results are next
 * to it.
 * @returns {Vector | undefined}
 */
export function bunny() {
  const path = process.env.TRISTRIP_BUNNY;
  if (!path) return undefined;
  if (!existsSync(path)) throw new Error(`TRISTRIP_BUNNY: there is no ${path}`);
  return readVector(new URL(`file://${path}`), 'bunny');
}

/** A seeded pseudo-random number generator. */
export class Random {
  /** @param {number} seed */
  constructor(seed) {
    this.state = seed | 0;
  }

  /** @param {number} end */
  below(end) {
    this.state = (this.state + 0x6d2b79f5) | 0;
    let x = Math.imul(this.state ^ (this.state >>> 15), 1 | this.state);
    x = (x + Math.imul(x ^ (x >>> 7), 61 | x)) ^ x;
    return Math.floor((((x ^ (x >>> 14)) >>> 0) / 4294967296) * end);
  }
}

/** @param {number} number */
function varint(number) {
  const bytes = [];
  for (; number >= 128; number = Math.floor(number / 128)) bytes.push((number % 128) | 128);
  return [...bytes, number];
}

/**
 * Returns the bytes of a chunk with a correct checksum.
 * @param {import('../src/chunk.js').ChunkHead} head
 * @param {Uint8Array} payload
 */
export function chunkBytes(head, payload) {
  const error = new Uint8Array(new Float32Array([head.error]).buffer);
  const numbers = [head.stream, payload.length, head.visits, head.level, head.triangles].flatMap(varint);
  const start = Uint8Array.from([...numbers, ...error]);
  const checksum = new Uint8Array(new Uint32Array([crc32(payload, crc32(start))]).buffer);
  return Uint8Array.from([...start, ...checksum, ...payload]);
}

/**
 * Returns the headers and payloads of a stream.
 * @param {Vector} vector
 */
export function chunksOf({ bytes, chunks }) {
  return chunks.map(({ end }, i) => {
    const chunk = bytes.subarray(i === 0 ? 0 : chunks[i - 1].end, end);
    const head = readChunkHead(chunk);
    if (!head) throw new Error('a chunk is cut');
    return { head, payload: chunk.subarray(head.headBytes) };
  });
}
