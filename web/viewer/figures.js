/**
 * What has arrived of a model and what is shown of it, in numbers.
 * @module
 */

/** @import { ChunkFigures, Progress, Update } from '../src/client/client.js' */

/**
 * Error by bytes: after a chunk.
 * @typedef {object} Point
 * @property {number} bytes of the file up to its end
 * @property {number} triangles
 * @property {number} error the largest one of the meshes, as a fraction of their sizes
 */

/**
 * What is shown of a mesh.
 * @typedef {object} Shown
 * @property {number} triangles
 * @property {number} fullTriangles
 * @property {number} vertices
 * @property {number} error
 * @property {Map<number, { strips: number, sent: number }>} parts
 */

/** The sums over the meshes of a model. */
export class Figures {
  /** @type {Progress | undefined} */
  progress;
  /** After each chunk that has arrived. @type {Point[]} */
  points = [];
  /** How many chunks have base meshes, at the start. */
  baseChunks = 1;
  /** Whether there is a stream. */
  isStreamed = false;
  /** The triangles of what has no stream. */
  outside = 0;
  /** The sizes of the meshes. @type {Map<number, number>} */
  #sizes = new Map();
  /** The last chunk of each mesh that has arrived. @type {Map<number, ChunkFigures>} */
  #arrived = new Map();
  /** @type {Map<number, Shown>} */
  #shown = new Map();

  /**
   * Takes the document.
   * @param {any} json
   */
  open(json) {
    this.isStreamed = Boolean(json.extensions?.TRISTRIP_progressive);
    for (const { primitives } of json.meshes ?? []) {
      for (const { attributes, indices, mode = 4, extensions } of primitives) {
        const { min, max, count = 0 } = json.accessors?.[attributes.POSITION] ?? {};
        const stream = extensions?.TRISTRIP_progressive?.stream;
        if (stream === undefined) {
          const corners = json.accessors?.[indices]?.count ?? count;
          if (mode >= 4) this.outside += mode === 4 ? Math.floor(corners / 3) : Math.max(corners - 2, 0);
        } else if (Array.isArray(min) && Array.isArray(max)) {
          const size = Math.hypot(...[0, 1, 2].map((i) => max[i] - min[i]));
          if (Number.isFinite(size)) this.#sizes.set(stream, Math.max(size, this.#sizes.get(stream) ?? 0));
        }
      }
    }
  }

  /** @param {Iterable<[number, { error: number }]>} meshes */
  #largestError(meshes) {
    let largest = 0;
    for (const [stream, { error }] of meshes) {
      const fraction = error / (this.#sizes.get(stream) || 1);
      // What a file claims may be infinite.
      if (Number.isFinite(fraction)) largest = Math.max(largest, fraction);
    }
    return largest;
  }

  /** @param {ChunkFigures[]} chunks that have arrived */
  addChunks(chunks) {
    for (const chunk of chunks) {
      if (!this.#arrived.has(chunk.stream)) this.baseChunks = this.points.length + 1;
      this.#arrived.set(chunk.stream, chunk);
      let triangles = 0;
      for (const mesh of this.#arrived.values()) triangles += mesh.triangles;
      this.points.push({ bytes: chunk.end, triangles, error: this.#largestError(this.#arrived) });
    }
  }

  /** @param {Update} update that is shown now */
  show({ meshes, progress }) {
    this.progress = progress;
    for (const { stream, triangles, fullTriangles, vertices, error, parts } of meshes) {
      const known = this.#shown.get(stream)?.parts ?? new Map();
      for (const { part, strips, verticesSent } of parts) known.set(part, { strips, sent: verticesSent });
      this.#shown.set(stream, { triangles, fullTriangles, vertices, error, parts: known });
    }
  }

  /** The sums of what is shown. */
  get sums() {
    const sums = { triangles: 0, fullTriangles: 0, vertices: 0, strips: 0, sent: 0, error: this.#largestError(this.#shown) };
    for (const { triangles, fullTriangles, vertices, parts } of this.#shown.values()) {
      sums.triangles += triangles;
      sums.fullTriangles += fullTriangles;
      sums.vertices += vertices;
      for (const { strips, sent } of parts.values()) {
        sums.strips += strips;
        sums.sent += sent;
      }
    }
    return sums;
  }
}
