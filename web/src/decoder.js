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
 * What a stream may ask for at most; streams of more are refused.
 * @typedef {object} StreamLimits
 * @property {number} meshes 256 unless told otherwise; each takes about 60 kilobytes beside its triangles, and 20 per attribute
 * @property {number} triangles those of all meshes: 2²⁶ unless told otherwise
 * @property {number} chunkBytes bytes of a chunk: 2²⁸ unless told otherwise
 * @property {number} corners visits of vertices by batches, and corners around those that are split, which the time depends on: 2³⁰ unless told otherwise
 */

/**
 * What a decoder does beside decoding.
 * @typedef {object} StripOptions
 * @property {typeof Strips} [strips] the class of the module strips.js, if strips are to be kept
 * @property {boolean} [isLazy] whether strips are only improved when their method `improve` is called, instead of after each chunk: then they depend on the calls, too
 */

/** @typedef {Partial<StreamLimits> & StripOptions} DecoderOptions what a stream may ask for at most, and what a decoder does beside decoding */

/** @type {StreamLimits} */
export const USUAL_LIMITS = { meshes: 256, triangles: 2 ** 26, chunkBytes: 2 ** 28, corners: 2 ** 30 };

/** Streams have about two triangles in three bytes, more where surfaces are flat. For so many there is room before they come. */
const TRIANGLES_PER_BYTE = 64;

/** @param {number} error that of a level */
function checkError(error) {
  if (!(error >= 0 && Number.isFinite(error))) fail(`an error of ${error}`, 'a finite number of at least 0');
}

/** A mesh that a stream has built so far. */
export class StreamPart {
  #head;
  #refiner;
  #error;
  /** The bytes of its chunks, without their heads. */
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
   * Decodes a refinement. For the decoder only.
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
    // Room for all that follows, unless so few bytes cannot be expected to build it.
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
   * Keeps strips of the triangles up: called after each chunk. For the decoder only.
   * @param {typeof Strips} Strips
   * @param {boolean} [isLazy]
   */
  keepStrips(Strips, isLazy) {
    const refiner = this.#refiner;
    if (refiner.strips) isLazy || refiner.strips.improve();
    else refiner.strips = new Strips(refiner.surface, refiner.fans);
  }

  /** The strips of the triangles so far, if the decoder keeps them. */
  get strips() {
    return this.#refiner.strips;
  }

  /** The visits, and the corners around the vertices that were split. For the decoder only. */
  get corners() {
    return this.#refiner.corners;
  }

  /** What the stream says of the mesh, and the mesh itself. For the package only. */
  get internals() {
    return { head: this.#head, refiner: this.#refiner };
  }

  /** The level so far: the collapses that are undone. */
  get level() {
    return this.#refiner.level;
  }

  /** The level of the full mesh, as the stream says. */
  get fullLevel() {
    return this.#head.levels;
  }

  /** The triangles so far. */
  get triangleCount() {
    return this.#refiner.surface.triangleCount;
  }

  /** The triangles of the full mesh, as the stream says. */
  get fullTriangleCount() {
    return this.#head.triangles;
  }

  /** The vertices so far. */
  get vertexCount() {
    return this.#refiner.fans.vertexCount;
  }

  /** The error of the level, in mesh units. */
  get error() {
    return this.#error;
  }

  /**
   * Returns the vertices of the triangles so far, three per triangle.
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
   * Returns the positions of the vertices so far, three coordinates per vertex: each is the middle of what it may be.
   * @param {number} [first] the vertices that there were after an earlier chunk, which are left out
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
      // Fans of later chunks have later vertices.
      if (vertex < 0) break;
      for (let j = 0; j < 3; j++) positions[3 * vertex + j] = origin[j] + (fans.cells[at + j] * scale + half) * step;
    }
    return positions;
  }

  /**
   * Returns the attributes of the vertices so far. They never change.
   * @param {number} [first] the first of the vertices that are returned
   * @returns {Attribute[]}
   */
  attributes(first = 0) {
    return this.#head.channels.map((channel) => attributeOf(channel, first, this.vertexCount));
  }
}

/** Decodes the chunks of a stream as their bytes arrive, in pieces of any size. */
export class Decoder {
  #limits;
  /** What has arrived of the next chunk. */
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
   * Takes the next bytes, and decodes the chunks that are complete. Returns how many that were.
   *
   * Throws a `StreamError` if a chunk is damaged, or asks for more than the limits. What chunks before it have built stays; all further bytes are
   * refused with the same error.
   * @param {Uint8Array | ArrayBuffer} bytes
   * @returns {number}
   */
  update(bytes) {
    if (this.#fault) throw this.#fault;
    const waiting = this.#waiting;
    const known = waiting.length;
    // Complete chunks are decoded where they lie, unless bytes have waited for the first one.
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
   * Decodes the chunk at the start of bytes; returns its length, or 0 if it is not complete.
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
   * Returns the payload of a chunk, or `undefined` if it is not complete.
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
      // What a faulty chunk has built stays.
      if (strips) this.#parts[head.stream]?.keepStrips(strips, isLazy);
    }
  }

  /**
   * The meshes whose base has arrived, in the order of their numbers.
   * @returns {StreamPart[]}
   */
  get parts() {
    return this.#parts.filter((part) => part !== undefined);
  }

  /**
   * Returns a mesh, if its base has arrived.
   * @param {number} stream its number
   * @returns {StreamPart | undefined}
   */
  part(stream) {
    return this.#parts[stream];
  }

  /** The number of chunks decoded. */
  get chunkCount() {
    return this.#chunkCount;
  }

  /** The number of bytes of the chunks decoded: where to resume. */
  get offset() {
    return this.#offset;
  }
}
