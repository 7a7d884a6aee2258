import { decodeFans, decodeTriangles } from './base.js';
import { Checksum, Reader, readChunkHead } from './chunk.js';
import { MOST_HEAD_BYTES } from './constants.js';
import { Fault, StreamError } from './error.js';
import { FAN_CELLS, VERTEX } from './fans.js';
import { attributeOf } from './grid.js';
import { grown } from './growth.js';
import { decodeWeights, readHead } from './head.js';
import { PlaceModel } from './places.js';
import { RangeDecoder } from './range_coder.js';
import { Refiner } from './refiner.js';
import { NONE } from './surface.js';

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
 * What a decoder does beside decoding, and what a stream may ask for at most.
 * @typedef {Partial<StreamLimits> & { strips?: typeof Strips }} DecoderOptions `strips`: the class of the module strips.js, if strips are to be kept
 */

/** @type {StreamLimits} */
const USUAL_LIMITS = { meshes: 256, triangles: 2 ** 26, chunkBytes: 2 ** 28, corners: 2 ** 30 };

/** @param {number} error that of a level */
function checkError(error) {
  if (!(error >= 0 && Number.isFinite(error))) throw new Fault(`an error of ${error}`, 'a finite number of at least 0');
}

/** A mesh that a stream has built so far. */
export class StreamPart {
  #head;
  #refiner;
  #error;

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
      throw new Fault(`a base mesh of ${head.baseTriangles} triangles at level ${chunk.level}`, `${chunk.triangles} at level 0`);
    }
    const coder = new RangeDecoder(payload.subarray(reader.at));
    const placeModel = new PlaceModel(decodeWeights(coder));
    const surface = decodeTriangles(coder, head.baseTriangles);
    if (!surface.hasDistinctFans()) throw new Fault('a triangle with two corners in one fan', 'triangles of three points');
    const channels = head.channels.map((channel) => channel.model);
    const fans = decodeFans(coder, surface, placeModel, channels, head.positionBits - head.unknownBits);
    if (coder.isPastEnd) throw new Fault('the end of the chunk', 'all vertices of the base mesh');
    this.#head = head;
    this.#refiner = new Refiner(surface, fans, channels, placeModel, head.positionBits, head.unknownBits);
    this.#error = chunk.error;
  }

  /**
   * Decodes a refinement. For the decoder only.
   * @param {ChunkHead} chunk
   * @param {Uint8Array} payload
   * @param {number} mostCorners
   */
  refine(chunk, payload, mostCorners) {
    checkError(chunk.error);
    const coder = new RangeDecoder(payload);
    const refiner = this.#refiner;
    const { surface } = refiner;
    refiner.mostTriangles = chunk.triangles;
    for (let i = 0; i < chunk.visits; i++) {
      if (refiner.next === NONE) refiner.beginBatch(coder);
      if (refiner.next === NONE) throw new Fault('a refinement of nothing', 'a base mesh with triangles');
      refiner.visit(coder);
      if (refiner.cornerCount > mostCorners) {
        throw new Fault(`${refiner.cornerCount} corners around vertices that are visited`, `at most ${mostCorners}`);
      }
      if (coder.isPastEnd || surface.triangleCount > chunk.triangles) break;
    }
    if (coder.isPastEnd || refiner.groupCount !== chunk.level || surface.triangleCount !== chunk.triangles) {
      const words = (/** @type {number} */ level, /** @type {number} */ triangles) => `level ${level} of ${triangles} triangles`;
      throw new Fault(words(refiner.groupCount, surface.triangleCount), words(chunk.level, chunk.triangles));
    }
    this.#error = chunk.error;
  }

  /**
   * Keeps strips of the triangles up: called after each chunk. For the decoder only.
   * @param {typeof Strips} Strips
   */
  keepStrips(Strips) {
    const refiner = this.#refiner;
    if (refiner.strips) refiner.strips.followChunk();
    else refiner.strips = new Strips(refiner.surface, refiner.fans);
  }

  /** The strips of the triangles so far, if the decoder keeps them. */
  get strips() {
    return this.#refiner.strips;
  }

  /** The visits, and the corners around the vertices that were split. For the decoder only. */
  get cornerCount() {
    return this.#refiner.cornerCount;
  }

  /** The level so far: the collapses that are undone. */
  get level() {
    return this.#refiner.groupCount;
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
   * @returns {Float32Array}
   */
  positions() {
    const { fans, unknownBits } = this.#refiner;
    const { origin, step } = this.#head;
    const scale = 2 ** unknownBits;
    const half = (scale - 1) / 2;
    const positions = new Float32Array(3 * fans.vertexCount);
    for (let at = 0; at < FAN_CELLS * fans.count; at += FAN_CELLS) {
      const vertex = fans.cells[at + VERTEX];
      for (let j = 0; j < 3; j++) positions[3 * vertex + j] = origin[j] + (fans.cells[at + j] * scale + half) * step;
    }
    return positions;
  }

  /**
   * Returns the attributes of the vertices so far.
   * @returns {Attribute[]}
   */
  attributes() {
    return this.#head.channels.map((channel) => attributeOf(channel, this.vertexCount));
  }

  /**
   * Returns a checksum of the mesh so far: the CRC-32 of the vertices of the triangles, then the grid positions of the vertices, then the integers of
   * each attribute, all as 32-bit numbers with the lowest byte first. Decoders that agree return the same after each chunk.
   * @returns {number}
   */
  fingerprint() {
    const { fans } = this.#refiner;
    const checksum = new Checksum();
    const places = new Int32Array(3 * fans.vertexCount);
    for (let at = 0; at < FAN_CELLS * fans.count; at += FAN_CELLS) {
      for (let j = 0; j < 3; j++) places[3 * fans.cells[at + VERTEX] + j] = fans.cells[at + j];
    }
    for (const vertex of this.triangles()) checksum.addNumber(vertex);
    for (const step of places) checksum.addNumber(step);
    for (const { model } of this.#head.channels) {
      for (const value of model.values.subarray(0, model.width * fans.vertexCount)) checksum.addNumber(value);
    }
    return checksum.value;
  }
}

/** Decodes the chunks of a stream as their bytes arrive, in pieces of any size. */
export class Decoder {
  #limits;
  /** What has arrived of the next chunk. */
  #waiting = new Uint8Array(0);
  #waitingLength = 0;
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
    let rest = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    for (let decoded = 0; ; decoded++) {
      // Complete chunks are decoded where they lie, unless their first bytes have waited.
      const known = this.#waitingLength;
      if (known > 0) this.#waitForChunk(rest);
      const taken = this.#nextChunk(known > 0 ? this.#waiting.subarray(0, this.#waitingLength) : rest);
      if (taken === 0) {
        if (known === 0) this.#wait(rest);
        return decoded;
      }
      rest = rest.subarray(taken - known);
      this.#waitingLength = 0;
    }
  }

  /**
   * Adds what belongs to the next chunk.
   * @param {Uint8Array} bytes
   */
  #waitForChunk(bytes) {
    const known = this.#waitingLength;
    const headBytes = Math.max(MOST_HEAD_BYTES - known, 0);
    this.#wait(bytes.subarray(0, headBytes));
    let length = this.#waitingLength;
    try {
      const head = readChunkHead(this.#waiting.subarray(0, length));
      if (head) length = head.headBytes + Math.min(head.payloadBytes, this.#limits.chunkBytes);
    } catch {
      // The fault is found again where its place is known.
    }
    if (length > this.#waitingLength) this.#wait(bytes.subarray(headBytes, length - known));
  }

  /** @param {Uint8Array} bytes */
  #wait(bytes) {
    this.#waiting = grown(this.#waiting, this.#waitingLength + bytes.length);
    this.#waiting.set(bytes, this.#waitingLength);
    this.#waitingLength += bytes.length;
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
      if (error instanceof Fault) this.#fault = new StreamError(at, error.found, error.expected);
      else if (error instanceof RangeError) this.#fault = new StreamError(at, 'a mesh that does not fit into memory', 'a smaller one');
      else throw error;
      this.#waitingLength = 0;
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
    if (payloadBytes > chunkBytes) throw new Fault(`${payloadBytes} bytes`, `at most ${chunkBytes}`);
    if (stream >= meshes) throw new Fault(`mesh ${stream}`, `at most ${meshes} meshes`);
    if (bytes.length < headBytes + payloadBytes) return undefined;
    const payload = bytes.subarray(headBytes, headBytes + payloadBytes);
    const found = new Checksum();
    found.addBytes(bytes.subarray(0, headBytes - 4));
    found.addBytes(payload);
    const hexadecimal = (/** @type {number} */ number) => number.toString(16).padStart(8, '0');
    if (found.value !== checksum) {
      throw new Fault(`checksum ${hexadecimal(found.value)}`, `${hexadecimal(checksum)}: the chunk is damaged`);
    }
    return payload;
  }

  /**
   * @param {ChunkHead} head
   * @param {Uint8Array} payload
   */
  #decode(head, payload) {
    const part = this.#parts[head.stream];
    const others = this.parts.reduce((sum, other) => sum + (other === part ? 0 : other.triangleCount), 0);
    const most = Math.max(this.#limits.triangles - others, 0);
    if (head.triangles > most) throw new Fault(`${head.triangles} triangles`, `at most ${most}`);
    const otherCorners = this.parts.reduce((sum, other) => sum + (other === part ? 0 : other.cornerCount), 0);
    const { corners, strips } = this.#limits;
    try {
      if (part) part.refine(head, payload, Math.max(corners - otherCorners, 0));
      else this.#parts[head.stream] = new StreamPart(head, payload);
    } finally {
      // What a faulty chunk has built stays.
      if (strips) this.#parts[head.stream]?.keepStrips(strips);
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
