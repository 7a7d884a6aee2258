/**
 * The main-thread API for progressive models. A worker downloads and decodes them, and sends
 * changes to the page.
 *
 * ```text
 * page                                 worker
 * Client.load(url, events) ─ load ──▶  download ─▶ container ─▶ chunks ─▶ decoder ─▶ buffers
 * events.document        ◀── JSON ──────────────────┘              │                    │
 * events.binary          ◀── textures, keyframes, … ───────────────┘                    │
 * events.update          ◀── changed ranges of vertices and indices ────────────────────┘
 *                         ── taken ──▶ the next update; at most one is in flight
 * ```
 * @module
 */

/**
 * What to download: a URL, or the bytes of a file.
 * @typedef {string | URL | Blob | ArrayBuffer | Uint8Array} Source
 */

/**
 * The primitive type of the index buffers: strips with primitive restart, or triangle lists.
 * @typedef {'strips' | 'lists'} Output
 */

/** @typedef {import('../grid.js').Attribute} Attribute */

/**
 * A changed range of an index buffer.
 * @typedef {object} IndexRange
 * @property {number} start the first index of the range
 * @property {Uint16Array | Uint32Array} array the new indices of the range
 */

/**
 * The changes of the index buffer of one part of a mesh. Indices outside of the ranges are
 * unchanged.
 * @typedef {object} IndexUpdate
 * @property {number} part the index of the part; 0 for a mesh without parts
 * @property {number} length the number of indices to draw
 * @property {number} capacity the recommended size of the buffer in indices, at least `length`;
 *   includes spare room for later updates
 * @property {2 | 4} bytesPerIndex when this changes, the ranges contain all indices
 * @property {number} triangles the triangles of the part
 * @property {number} strips the strips of the part; 0 for lists
 * @property {number} verticesSent the vertices of its strips, or three per triangle
 * @property {IndexRange[]} ranges sorted and disjoint
 */

/**
 * The changes of a mesh.
 * @typedef {object} MeshUpdate
 * @property {number} stream the index of the mesh in the stream, as in the primitives that draw it
 * @property {number} level the number of collapses undone so far
 * @property {number} fullLevel the level of the full mesh
 * @property {number} triangles
 * @property {number} fullTriangles
 * @property {number} vertices
 * @property {number} fullVertices as declared by the file; use it for display only
 * @property {number} error in mesh units
 * @property {number} firstVertex the first changed vertex; vertices before it are unchanged
 * @property {Float32Array} positions positions of the vertices from `firstVertex` on
 * @property {Attribute[]} attributes attributes of the vertices from `firstVertex` on
 * @property {IndexUpdate[]} parts
 */

/**
 * The changes since the last update.
 * @typedef {object} Update
 * @property {MeshUpdate[]} meshes the changed meshes
 * @property {Progress} progress
 */

/**
 * The progress of a model.
 * @typedef {object} Progress
 * @property {number} receivedBytes bytes of the file received
 * @property {number} shownBytes bytes of the file up to the last chunk that is shown
 * @property {number} totalBytes bytes of the file
 * @property {number} shownChunks
 * @property {number} receivedChunks chunks received, including those that are not shown
 * @property {number} decodeMilliseconds time the worker has spent decoding what is shown
 * @property {number} buildMilliseconds time the worker has spent on strips, buffers and ranges
 * @property {boolean} hasArrived whether the whole file has arrived
 * @property {boolean} isComplete whether the whole file is also shown
 */

/**
 * A chunk that has arrived.
 * @typedef {object} ChunkFigures
 * @property {number} stream
 * @property {number} end file offset of the end of the chunk
 * @property {number} triangles triangles of the mesh after the chunk
 * @property {number} error error of the mesh after the chunk, in mesh units
 */

/**
 * The state of the connection.
 *
 * - `waiting`: models of higher priority are downloaded first.
 * - `paused`: `pause` was called.
 * - `retrying`: the connection was lost and is retried after a delay.
 * - `busy`: the server answered 503 with `Retry-After`, because it is packing the file or has too
 *   many clients.
 * - `done`: everything has arrived.
 * @typedef {'connecting' | 'loading' | 'waiting' | 'paused' | 'retrying' | 'busy' | 'done'}
 *   ConnectionState
 */

/**
 * The events of a model. `document` comes once; then `binary` until it is complete; then `chunks`
 * and `update`.
 * @typedef {object} ModelEvents
 * @property {(json: any, binaryBytes: number) => void} [document] the glTF document, and the number
 *   of bytes of the binary chunk before the stream (of the whole binary chunk if there is no
 *   stream)
 * @property {(bytes: Uint8Array, start: number) => void} [binary] bytes of the binary chunk before
 *   the stream, and their offset in it
 * @property {(chunks: ChunkFigures[]) => void} [chunks] chunks have arrived
 * @property {(update: Update) => unknown} [update] meshes have changed. The page owns the arrays.
 *   If it returns a promise, the next update comes after the promise is fulfilled
 * @property {(progress: Progress) => void} [progress] bytes have arrived without an update
 * @property {(state: ConnectionState, seconds: number) => void} [connection] the state of the
 *   connection has changed; `seconds` until the next try, if it is `retrying` or `busy`
 * @property {(error: ModelError) => void} [error] loading has stopped until `retry` is called; the
 *   model shown so far remains valid
 */

/**
 * Why loading ended early.
 *
 * - `connection`: the connection was lost.
 * - `status`: the server returned an error.
 * - `changed`: the file changed during the download.
 * - `unreadable`: a local file cannot be read.
 * - `damaged`, `not-glb`: the bytes are invalid.
 * - `limit`: the model exceeds the limits.
 * - `worker`: the worker failed.
 * @typedef {object} ModelError
 * @property {'connection' | 'status' | 'changed' | 'unreadable' | 'damaged' | 'not-glb' | 'limit' |
 *   'worker'} kind
 * @property {string} message a message for users
 */

/**
 * Options of a model.
 * @typedef {object} LoadOptions
 * @property {Output} [output] by default 'strips'
 * @property {number} [priority] models with the highest priority are downloaded first; models with
 *   equal priority share the connection. By default 0
 * @property {boolean} [keepBytes] whether to keep the file in memory, so that `show` can go back.
 *   By default false
 * @property {import('../decoder.js').StreamLimits} [limits] decoder limits
 * @property {Record<string, string>} [headers] request headers
 * @property {RequestCredentials} [credentials] request credentials
 * @property {AbortSignal} [signal] closes the model
 */

/** Loads models in one worker. */
export class Client {
  #worker;
  /** @type {Map<number, Model>} */
  #models = new Map();
  #count = 0;

  /**
   * Starts the worker.
   * @param {Worker} [worker] a worker that runs worker.js, for pages that create it themselves
   */
  constructor(worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module', name: 'tristrip' })) {
    this.#worker = worker;
    worker.onmessage = ({ data }) => this.#models.get(data.id)?.receive(data);
    const fail = (/** @type {string} */ message) => {
      for (const model of this.#models.values()) model.receive({ type: 'error', error: { kind: 'worker', message } });
    };
    worker.onerror = (event) => fail(event.message || 'The decoding worker could not be started.');
    worker.onmessageerror = () => fail('A message from the worker could not be read.');
  }

  /**
   * Starts loading a model.
   * @param {Source} source
   * @param {ModelEvents} events
   * @param {LoadOptions} [options]
   * @returns {Model}
   */
  load(source, events, options = {}) {
    const { signal, ...rest } = options;
    const isAddress = typeof source === 'string' || source instanceof URL;
    const from = isAddress ? new URL(source, document.baseURI).href : source;
    const id = this.#count++;
    const post = (/** @type {any} */ message) => this.#worker.postMessage({ ...message, id });
    const close = () => model.close();
    const model = new Model(events, post, () => {
      this.#models.delete(id);
      signal?.removeEventListener('abort', close);
    });
    this.#models.set(id, model);
    post({ type: 'load', source: from, options: rest });
    if (signal?.aborted) close();
    else signal?.addEventListener('abort', close);
    return model;
  }

  /**
   * Simulates a network bandwidth for all models.
   * @param {number} bitsPerSecond 0 for unlimited
   */
  set bandwidth(bitsPerSecond) {
    this.#worker.postMessage({ type: 'bandwidth', bitsPerSecond });
  }

  /** Closes all models and terminates the worker. */
  close() {
    for (const model of [...this.#models.values()]) model.close();
    this.#worker.terminate();
  }
}

/** A model that is loading or loaded, returned by `Client.load`. */
export class Model {
  #events;
  #post;
  #forget;
  #isClosed = false;

  /**
   * @param {ModelEvents} events
   * @param {(message: any) => void} post
   * @param {() => void} forget
   */
  constructor(events, post, forget) {
    this.#events = events;
    this.#post = post;
    this.#forget = forget;
  }

  /**
   * Handles a message of the worker. Called by the client.
   * @param {any} message
   */
  receive(message) {
    const events = this.#events;
    switch (message.type) {
      case 'document':
        return events.document?.(message.json, message.binaryBytes);
      case 'binary':
        return events.binary?.(message.bytes, message.start);
      case 'chunks':
        return events.chunks?.(message.chunks);
      case 'progress':
        return events.progress?.(message.progress);
      case 'connection':
        return events.connection?.(message.state, message.seconds);
      case 'error':
        return events.error?.(message.error);
      case 'update':
        this.#take(message.update);
    }
  }

  /** @param {Update} update */
  async #take(update) {
    try {
      await this.#events.update?.(update);
    } finally {
      if (!this.#isClosed) this.#post({ type: 'taken' });
    }
  }

  /**
   * Sets the download priority; higher comes first.
   * @param {number} priority
   */
  set priority(priority) {
    this.#post({ type: 'priority', priority });
  }

  /** Pauses the download and the refinement. */
  pause() {
    this.#post({ type: 'pause' });
  }

  /** Resumes after `pause`. */
  resume() {
    this.#post({ type: 'resume' });
  }

  /**
   * Resumes the download after a connection error, or skips the delay before the next automatic
   * retry.
   */
  retry() {
    this.#post({ type: 'retry' });
  }

  /**
   * Shows the model after a number of chunks, forward or backward. Requires `keepBytes`.
   * @param {number} chunkCount Infinity for all chunks, including future ones
   */
  show(chunkCount) {
    this.#post({ type: 'show', chunkCount });
  }

  /** Stops loading, and frees the worker's memory of the model. No more events follow. */
  close() {
    if (this.#isClosed) return;
    this.#isClosed = true;
    this.#events = {};
    this.#post({ type: 'close' });
    this.#forget();
  }
}
