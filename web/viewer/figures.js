/**
 * The metrics of a model: what has been received and what is shown.
 * @module
 */

/** @import { ChunkFigures, Progress, Update } from '../src/client/client.js' */

/**
 * A point of the error curve: the state after a chunk.
 * @typedef {object} Point
 * @property {number} bytes file offset of the end of the chunk
 * @property {number} triangles
 * @property {number} error the maximum over the meshes, as a fraction of their sizes
 */

/**
 * The shown state of a mesh.
 * @typedef {object} Shown
 * @property {number} triangles
 * @property {number} fullTriangles
 * @property {number} vertices
 * @property {number} error
 * @property {Map<number, { strips: number, sent: number }>} parts
 */

/**
 * The maximum of numbers that change one at a time, as a tournament tree. A change takes
 * logarithmic time.
 */
class Largest {
  /**
   * Node 1 is the root, nodes 2 k and 2 k + 1 are the children of node k, and the leaves are the
   * numbers.
   */
  #tree = new Float64Array(2);
  /**
   * The leaf of each key.
   * @type {Map<number, number>}
   */
  #leaves = new Map();

  /**
   * Sets a number.
   * @param {number} key
   * @param {number} number at least 0
   */
  set(key, number) {
    let leaf = this.#leaves.get(key);
    if (leaf === undefined) {
      leaf = this.#leaves.size;
      this.#leaves.set(key, leaf);
      if (2 * leaf >= this.#tree.length) this.#grow();
    }
    const tree = this.#tree;
    let at = tree.length / 2 + leaf;
    for (tree[at] = number; at > 1; at >>= 1) tree[at >> 1] = Math.max(tree[at], tree[at ^ 1]);
  }

  #grow() {
    const old = this.#tree;
    const tree = (this.#tree = new Float64Array(2 * old.length));
    tree.set(old.subarray(old.length / 2), old.length);
    for (let at = old.length - 1; at > 0; at--) tree[at] = Math.max(tree[2 * at], tree[2 * at + 1]);
  }

  /** The maximum; 0 if there are no numbers. */
  get most() {
    return this.#tree[1];
  }
}

/** The metrics of a model, summed over its meshes. */
export class Figures {
  /** @type {Progress | undefined} */
  progress;
  /**
   * One point per chunk received.
   * @type {Point[]}
   */
  points = [];
  /** The number of leading chunks with base meshes. */
  baseChunks = 1;
  /** Whether there is a stream. */
  isStreamed = false;
  /** The triangles of primitives without a stream. */
  outside = 0;
  /**
   * The bounding-box diagonal of each mesh.
   * @type {Map<number, number>}
   */
  #sizes = new Map();
  /**
   * The received triangles of each mesh. Their sum and the maximum error follow.
   * @type {Map<number, number>}
   */
  #arrived = new Map();
  #triangles = 0;
  #errors = new Largest();
  /** @type {Map<number, Shown>} */
  #shown = new Map();

  /**
   * Reads the document.
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

  /**
   * Returns the error of a mesh as a fraction of its size.
   * @param {number} stream
   * @param {number} error
   */
  #fraction(stream, error) {
    const fraction = error / (this.#sizes.get(stream) || 1);
    // The file can declare an infinite error.
    return Number.isFinite(fraction) ? Math.max(fraction, 0) : 0;
  }

  /** @param {ChunkFigures[]} chunks received */
  addChunks(chunks) {
    for (const { stream, end, triangles, error } of chunks) {
      const before = this.#arrived.get(stream);
      if (before === undefined) this.baseChunks = this.points.length + 1;
      this.#arrived.set(stream, triangles);
      this.#triangles += triangles - (before ?? 0);
      this.#errors.set(stream, this.#fraction(stream, error));
      this.points.push({ bytes: end, triangles: this.#triangles, error: this.#errors.most });
    }
  }

  /** @param {Update} update that is now shown */
  show({ meshes, progress }) {
    this.progress = progress;
    for (const { stream, triangles, fullTriangles, vertices, error, parts } of meshes) {
      const known = this.#shown.get(stream)?.parts ?? new Map();
      for (const { part, strips, verticesSent } of parts) known.set(part, { strips, sent: verticesSent });
      this.#shown.set(stream, { triangles, fullTriangles, vertices, error, parts: known });
    }
  }

  /** The sums over the shown meshes. */
  get sums() {
    const sums = { triangles: 0, fullTriangles: 0, vertices: 0, strips: 0, sent: 0, error: 0 };
    for (const [stream, { triangles, fullTriangles, vertices, error, parts }] of this.#shown) {
      sums.error = Math.max(sums.error, this.#fraction(stream, error));
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
