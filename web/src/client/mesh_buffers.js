/**
 * The buffers of a mesh during refinement: vertices, and an index buffer per part. It reports the
 * changes after any number of chunks.
 *
 * Vertices change only when all positions receive another bit; new vertices are appended. Triangles
 * are never removed and keep their indices. A split moves some triangles to the new vertex and
 * marks them with its batch, so only these need to be compared with the sent state.
 * @module
 */
import { FAN_CELLS, VERTEX } from '../fans.js';
import { grown, integers } from '../growth.js';
import { Lists } from './lists.js';
import { StripSegments } from './strip_segments.js';

/**
 * @import { StreamPart } from '../decoder.js'
 * @import { MeshUpdate, Output } from './client.js'
 */

/** The attribute with the part index of each vertex. */
const PART = 'part';

/** The triangles as last sent. */
export class SentTriangles {
  /** Three vertices per triangle. */
  vertices = integers(0);
  count = 0;
  /** New triangles and triangles with changed vertices, sorted. Their number is `changedCount`. */
  changed = integers(0);
  changedCount = 0;
  #batch = 0;

  /**
   * Finds the changed triangles, and stores their vertices.
   * @param {StreamPart} part
   */
  update({ internals }) {
    const { surface, fans, batch } = internals.refiner;
    const { triangleCount, cells } = surface;
    const vertices = (this.vertices = grown(this.vertices, 3 * triangleCount));
    this.changed = grown(this.changed, triangleCount);
    this.changedCount = 0;
    for (let t = 0; t < triangleCount; t++) {
      const corner = 8 * t;
      const isNew = t >= this.count;
      if (!isNew && surface.mark(corner) < this.#batch) continue;
      const a = fans.cells[FAN_CELLS * cells[corner] + VERTEX];
      const b = fans.cells[FAN_CELLS * cells[corner + 1] + VERTEX];
      const c = fans.cells[FAN_CELLS * cells[corner + 2] + VERTEX];
      const at = 3 * t;
      if (!isNew && vertices[at] === a && vertices[at + 1] === b && vertices[at + 2] === c) continue;
      vertices[at] = a;
      vertices[at + 1] = b;
      vertices[at + 2] = c;
      this.changed[this.changedCount++] = t;
    }
    this.count = triangleCount;
    this.#batch = batch;
  }
}

/** The buffers of a mesh. */
export class MeshBuffers {
  #stream;
  #hasParts;
  #triangles = new SentTriangles();
  #indices;
  /**
   * The number of vertices sent, and the number of unknown bits in their positions at that time.
   */
  #vertexCount = 0;
  #unknownBits = 0;
  /** The part index of each vertex, if the mesh has several parts. */
  #partOf = new Float64Array(0);

  /**
   * @param {number} stream the index of the mesh
   * @param {number[] | undefined} parts the indices of its parts that are drawn; `undefined` if it
   *   has no parts
   * @param {Output} output
   */
  constructor(stream, parts, output) {
    this.#stream = stream;
    this.#hasParts = parts !== undefined;
    this.#indices = output === 'strips' ? new StripSegments(parts ?? [0]) : new Lists(parts ?? [0]);
  }

  /**
   * Returns the changes since the last call.
   * @param {StreamPart} part the mesh
   * @param {boolean} isLast whether this is the last update
   * @returns {MeshUpdate}
   */
  update(part, isLast) {
    const { head, refiner } = part.internals;
    const firstVertex = refiner.unknownBits === this.#unknownBits ? this.#vertexCount : 0;
    const positions = part.positions(firstVertex);
    const attributes = part.attributes(firstVertex);
    this.#noteParts(firstVertex, part.vertexCount, attributes);
    this.#vertexCount = part.vertexCount;
    this.#unknownBits = refiner.unknownBits;
    this.#triangles.update(part);
    return {
      stream: this.#stream,
      level: part.level,
      fullLevel: part.fullLevel,
      triangles: part.triangleCount,
      fullTriangles: part.fullTriangleCount,
      vertices: part.vertexCount,
      fullVertices: head.vertices,
      error: part.error,
      firstVertex,
      positions,
      attributes: attributes.filter(({ name }) => name !== PART),
      parts: this.#indices.update(part, this.#triangles, this.#partOf, isLast),
    };
  }

  /**
   * @param {number} first
   * @param {number} end
   * @param {import('../grid.js').Attribute[]} attributes
   */
  #noteParts(first, end, attributes) {
    const numbers = attributes.find(({ name, components }) => name === PART && components === 1);
    if (!numbers || !this.#hasParts) return;
    this.#partOf = grown(this.#partOf, end);
    this.#partOf.set(numbers.array, first);
  }
}
