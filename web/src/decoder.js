import { decodeFans, decodeTriangles } from './base.js';
import { Checksum, Reader, readChunkHead } from './chunk.js';
import { fail, StreamError } from './error.js';
import { FAN_CELLS, VERTEX } from './fans.js';
import { attributeOf } from './grid.js';
import { arrayOf, Waiting } from './growth.js';
import { decodeWeights, readHead } from './head.js';
import { PlaceModel } from './places.js';
import { RangeDecoder } from './range_coder.js';
import { Refiner } from './refiner.js';
import { NONE } from './surface.js';
import { max, min } from './math.js';

/**
 * @import { ChunkHead } from './chunk.js'
 * @import { Attribute } from './grid.js'
 * @import { Strips } from './strips.js'
 */

/**
 * Decoder limits. Streams that exceed them are rejected.
 * @typedef {object} StreamLimits
 * @property {number} meshes by default 256. A mesh takes about 60 kB in addition to its triangles,
 *   and 20 kB per attribute
 * @property {number} triangles triangles of all meshes, by default 2²⁶
 * @property {number} chunkBytes bytes per chunk, by default 2²⁸
 * @property {number} corners work limit: vertices visited plus corners around split vertices, by
 *   default 2³⁰. Decoding time is proportional to it
 */

/**
 * Options for triangle strips.
 * @typedef {object} StripOptions
 * @property {typeof Strips} [strips] the class `Strips` of strips.js, to maintain triangle strips
 * @property {boolean} [isLazy] whether to improve strips only when their method `improve` is
 *   called, instead of after each chunk; the strips then depend on these calls
 */

/**
 * Decoder limits and options for strips.
 * @typedef {Partial<StreamLimits> & StripOptions} DecoderOptions
 */

/** @type {StreamLimits} */
export const USUAL_LIMITS = { meshes: 256, triangles: 2 ** 26, chunkBytes: 2 ** 28, corners: 2 ** 30 };

/**
 * The preallocation limit in triangles per payload byte. Streams have about two triangles per three
 * bytes, more on flat surfaces.
 */
const TRIANGLES_PER_BYTE = 64;

/** @param {number} error of a level */
function checkError(error) {
  if (!(error >= 0 && Number.isFinite(error))) fail(`an error of ${error}`, 'a finite number of at least 0');
}

/** A mesh of a stream as decoded so far. */
export class StreamPart {
  #head;
  #refiner;
  #error;
  /** The total payload bytes of its chunks. */
  #payloadBytes;

  /**
   * Decodes the base mesh.
   * @param {ChunkHead} chunk
   * @param {Uint8Array} payload
   */
  constructor(chunk, payload) {
    const reader = new Reader(payload, 'the head of a base mesh');
    const head = readHead(reader);
    checkError(chunk.error);
    if (head.baseTriangles !== chunk.triangles || chunk.visits !== 0 || chunk.level !== 0) {
      fail(`a base mesh of ${head.baseTriangles} triangles at level ${chunk.level}`, `${chunk.triangles} at level 0`);
    }
    const coder = new RangeDecoder(payload.subarray(reader.at));
    const placeModel = new PlaceModel(decodeWeights(coder));
    const surface = decodeTriangles(coder, head.baseTriangles);
    if (!surface.hasDistinctFans()) fail('a triangle with two corners in one fan', 'triangles of three points');
    const channels = head.channels.map((channel) => channel.model);
    const fans = decodeFans(coder, surface, placeModel, channels, head.positionBits - head.unknownBits);
    if (coder.isPastEnd) fail('the end of the chunk', 'all vertices of the base mesh');
    this.#head = head;
    this.#refiner = new Refiner(surface, fans, channels, placeModel, head.positionBits, head.unknownBits);
    this.#error = chunk.error;
    this.#payloadBytes = payload.length;
  }

  /**
   * Decodes a refinement. Called by the decoder.
   * @param {ChunkHead} chunk
   * @param {Uint8Array} payload
   * @param {number} mostTriangles
   * @param {number} mostCorners
   */
  refine(chunk, payload, mostTriangles, mostCorners) {
    checkError(chunk.error);
    const coder = new RangeDecoder(payload);
    const refiner = this.#refiner;
    const { surface } = refiner;
    refiner.mostTriangles = chunk.triangles;
    // Reserves memory for the full mesh, limited by what the bytes received so far can build.
    this.#payloadBytes += payload.length;
    refiner.reserve(min(this.#head.triangles, TRIANGLES_PER_BYTE * this.#payloadBytes, mostTriangles));
    for (let i = 0; i < chunk.visits; i++) {
      if (refiner.next === NONE) refiner.beginBatch(coder);
      if (refiner.next === NONE) fail('a refinement of nothing', 'a base mesh with triangles');
      refiner.visit(coder);
      if (refiner.corners > mostCorners) {
        fail(`${refiner.corners} corners around vertices that are visited`, `at most ${mostCorners}`);
      }
      if (coder.isPastEnd || surface.triangleCount > chunk.triangles) break;
    }
    if (coder.isPastEnd || refiner.level !== chunk.level || surface.triangleCount !== chunk.triangles) {
      const words = (/** @type {number} */ level, /** @type {number} */ triangles) => `level ${level} of ${triangles} triangles`;
      fail(words(refiner.level, surface.triangleCount), words(chunk.level, chunk.triangles));
    }
    this.#error = chunk.error;
  }

  /**
   * Updates the strips of the triangles after a chunk. Called by the decoder.
   * @param {typeof Strips} Strips
   * @param {boolean} [isLazy]
   */
  keepStrips(Strips, isLazy) {
    const refiner = this.#refiner;
    if (refiner.strips) isLazy || refiner.strips.improve();
    else refiner.strips = new Strips(refiner.surface, refiner.fans);
  }

  /** The strips of the current triangles, if the decoder maintains them. */
  get strips() {
    return this.#refiner.strips;
  }

  /** The work done: vertices visited plus corners around split vertices. Internal. */
  get corners() {
    return this.#refiner.corners;
  }

  /** The base header and the data structures of the mesh. Internal. */
  get internals() {
    return { head: this.#head, refiner: this.#refiner };
  }

  /** The current level: the number of collapses undone. */
  get level() {
    return this.#refiner.level;
  }

  /** The level of the full mesh, as declared by the stream. */
  get fullLevel() {
    return this.#head.levels;
  }

  /** The current number of triangles. */
  get triangleCount() {
    return this.#refiner.surface.triangleCount;
  }

  /** The number of triangles of the full mesh, as declared by the stream. */
  get fullTriangleCount() {
    return this.#head.triangles;
  }

  /** The current number of vertices. */
  get vertexCount() {
    return this.#refiner.fans.vertexCount;
  }

  /** The error of the current level, in mesh units. */
  get error() {
    return this.#error;
  }

  /**
   * Returns the current triangles, three vertex indices each.
   * @returns {Uint32Array}
   */
  triangles() {
    const { surface, fans } = this.#refiner;
    const triangles = new Uint32Array(3 * surface.triangleCount);
    for (let i = 0, corner = 0; i < triangles.length; corner += 8) {
      for (let j = 0; j < 3; j++) triangles[i++] = fans.cells[FAN_CELLS * surface.cells[corner + j] + VERTEX];
    }
    return triangles;
  }

  /**
   * Returns the current positions, three coordinates per vertex. Each is the centre of its
   * uncertainty interval.
   * @param {number} [first] the first vertex to return
   * @returns {Float32Array}
   */
  positions(first = 0) {
    const { fans, unknownBits } = this.#refiner;
    const { origin, step } = this.#head;
    const scale = 2 ** unknownBits;
    const half = (scale - 1) / 2;
    const positions = new Float32Array(3 * (fans.vertexCount - first));
    for (let at = FAN_CELLS * (fans.count - 1); at >= 0; at -= FAN_CELLS) {
      const vertex = fans.cells[at + VERTEX] - first;
      // Fans of later chunks have higher vertex indices.
      if (vertex < 0) break;
      for (let j = 0; j < 3; j++) positions[3 * vertex + j] = origin[j] + (fans.cells[at + j] * scale + half) * step;
    }
    return positions;
  }

  /**
   * Returns the attributes of the current vertices. The attributes of a vertex never change.
   * @param {number} [first] the first vertex to return
   * @returns {Attribute[]}
   */
  attributes(first = 0) {
    return this.#head.channels.map((channel) => attributeOf(channel, first, this.vertexCount));
  }
}

/** Decodes the chunks of a stream incrementally, from bytes in pieces of any size. */
export class Decoder {
  #limits;
  /** The bytes of the next, incomplete chunk. */
  #waiting = new Waiting();
  #offset = 0;
  #chunkCount = 0;
  /** @type {(StreamPart | undefined)[]} */
  #parts = [];
  /** @type {StreamError | undefined} */
  #fault;

  /** @param {DecoderOptions} [options] */
  constructor(options = {}) {
    this.#limits = { ...USUAL_LIMITS, ...options };
  }

  /**
   * Consumes bytes and decodes all complete chunks. Returns their number.
   *
   * Throws a `StreamError` if a chunk is damaged or exceeds the limits. The part decoded before the
   * error remains. Later calls throw the same error.
   * @param {Uint8Array | ArrayBuffer} bytes
   * @returns {number}
   */
  update(bytes) {
    if (this.#fault) throw this.#fault;
    const waiting = this.#waiting;
    const known = waiting.length;
    // Complete chunks are decoded in place, unless the first one started in earlier bytes.
    let rest = arrayOf(bytes);
    if (known > 0) rest = waiting.add(rest);
    let decoded = 0;
    for (let taken; (taken = this.#nextChunk(rest)) > 0; decoded++) rest = rest.subarray(taken);
    if (known === 0 || decoded > 0) {
      waiting.length = 0;
      waiting.add(rest);
    }
    return decoded;
  }

  /**
   * Decodes the chunk at the start of bytes. Returns its length, or 0 if it is incomplete.
   * @param {Uint8Array} bytes
   */
  #nextChunk(bytes) {
    try {
      const head = readChunkHead(bytes);
      if (!head) return 0;
      const payload = this.#payload(bytes, head);
      if (!payload) return 0;
      this.#decode(head, payload);
      this.#chunkCount++;
      this.#offset += head.headBytes + payload.length;
      return head.headBytes + payload.length;
    } catch (error) {
      const at = `chunk ${this.#chunkCount} at byte ${this.#offset}`;
      if (error instanceof StreamError) this.#fault = new StreamError(at, error.found, error.expected);
      else if (error instanceof RangeError) this.#fault = new StreamError(at, 'a mesh that does not fit into memory', 'a smaller one');
      else throw error;
      throw this.#fault;
    }
  }

  /**
   * Returns the payload of a chunk, or `undefined` if it is incomplete.
   * @param {Uint8Array} bytes
   * @param {ChunkHead} head
   */
  #payload(bytes, { headBytes, payloadBytes, stream, checksum }) {
    const { chunkBytes, meshes } = this.#limits;
    if (payloadBytes > chunkBytes) fail(`${payloadBytes} bytes`, `at most ${chunkBytes}`);
    if (stream >= meshes) fail(`mesh ${stream}`, `a number below ${meshes}`);
    if (bytes.length < headBytes + payloadBytes) return undefined;
    const payload = bytes.subarray(headBytes, headBytes + payloadBytes);
    const found = new Checksum();
    found.addBytes(bytes.subarray(0, headBytes - 4));
    found.addBytes(payload);
    const hexadecimal = (/** @type {number} */ number) => number.toString(16).padStart(8, '0');
    if (found.value !== checksum) {
      fail(`checksum ${hexadecimal(found.value)}`, `${hexadecimal(checksum)}: the chunk is damaged`);
    }
    return payload;
  }

  /**
   * @param {ChunkHead} head
   * @param {Uint8Array} payload
   */
  #decode(head, payload) {
    const { corners, strips, isLazy, triangles } = this.#limits;
    const part = this.#parts[head.stream];
    let most = triangles;
    let mostCorners = corners;
    for (const other of this.parts) {
      if (other === part) continue;
      most -= other.triangleCount;
      mostCorners -= other.corners;
    }
    if (head.triangles > most) fail(`${head.triangles} triangles`, `at most ${max(most, 0)}`);
    try {
      if (part) part.refine(head, payload, most, max(mostCorners, 0));
      else this.#parts[head.stream] = new StreamPart(head, payload);
    } finally {
      // Strips must also match the part of an invalid chunk that was decoded.
      if (strips) this.#parts[head.stream]?.keepStrips(strips, isLazy);
    }
  }

  /**
   * The meshes whose base mesh has arrived, ordered by index.
   * @returns {StreamPart[]}
   */
  get parts() {
    return this.#parts.filter((part) => part !== undefined);
  }

  /**
   * Returns a mesh if its base mesh has arrived.
   * @param {number} stream the index of the mesh
   * @returns {StreamPart | undefined}
   */
  part(stream) {
    return this.#parts[stream];
  }

  /** The number of chunks decoded. */
  get chunkCount() {
    return this.#chunkCount;
  }

  /** The number of bytes of the decoded chunks: the offset at which to resume. */
  get offset() {
    return this.#offset;
  }
}
