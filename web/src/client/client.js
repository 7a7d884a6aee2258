/**
 * Progressive models on the main thread of a page: they are downloaded and decoded in a worker, which sends what has changed.
 *
 * ```text
 * page                                 worker
 * Client.load(url, events) ─ load ──▶  download ─▶ container ─▶ chunks ─▶ decoder ─▶ buffers
 * events.document        ◀── JSON ──────────────────┘              │                    │
 * events.binary          ◀── textures, keyframes, … ───────────────┘                    │
 * events.update          ◀── ranges of vertices and indices that have changed ──────────┘
 *                         ── taken ──▶ the next update: never more than one is on its way
 * ```
 * @module
 */

/**
 * What is downloaded: a URL, or the bytes of a file.
 * @typedef {string | URL | Blob | ArrayBuffer | Uint8Array} Source
 */

/**
 * The order in which the worker writes triangles: strips with primitive restart, or lists.
 * @typedef {'strips' | 'lists'} Output
 */

/** @typedef {import('../grid.js').Attribute} Attribute */

/**
 * A run of an index buffer that has changed.
 * @typedef {object} IndexRange
 * @property {number} start the first index of the run
 * @property {Uint16Array | Uint32Array} array the indices from there on
 */

/**
 * How the index buffer of one part of a mesh has changed. Indices that no range names are as before.
 * @typedef {object} IndexUpdate
 * @property {number} part the number of the part; 0 where a mesh has no parts
 * @property {number} length the indices to draw
 * @property {number} capacity the indices that the buffer should have room for, at least `length`: so it need not grow at each update
 * @property {2 | 4} bytesPerIndex if it changes, the ranges are all indices
 * @property {number} triangles the triangles of the part
 * @property {number} strips the strips of the part; 0 for lists
 * @property {number} verticesSent the vertices of its strips, or three per triangle
 * @property {IndexRange[]} ranges in order, apart from each other
 */

/**
 * How a mesh has changed.
 * @typedef {object} MeshUpdate
 * @property {number} stream its number: that of the primitives that draw it
 * @property {number} level the collapses undone so far
 * @property {number} fullLevel those of the full mesh
 * @property {number} triangles
 * @property {number} fullTriangles
 * @property {number} vertices
 * @property {number} fullVertices as the file says: a reader trusts it for display only
 * @property {number} error in mesh units
 * @property {number} firstVertex the first vertex that has changed: those before it are as they were
 * @property {Float32Array} positions those of the vertices from `firstVertex` on
 * @property {Attribute[]} attributes those of the vertices from `firstVertex` on
 * @property {IndexUpdate[]} parts
 */

/**
 * What has arrived since the last update.
 * @typedef {object} Update
 * @property {MeshUpdate[]} meshes those that have changed
 * @property {Progress} progress
 */

/**
 * How far a model is.
 * @typedef {object} Progress
 * @property {number} receivedBytes bytes of the file that have arrived
 * @property {number} shownBytes bytes of the file up to the last chunk that is shown
 * @property {number} totalBytes bytes of the file
 * @property {number} shownChunks
 * @property {number} receivedChunks chunks that have arrived, whether or not they are shown
 * @property {number} decodeMilliseconds the time that the worker has taken to decode what is shown
 * @property {number} buildMilliseconds the time that it has taken for strips, buffers and ranges
 * @property {boolean} hasArrived whether the whole file has arrived
 * @property {boolean} isComplete whether all of it is shown, too
 */

/**
 * A chunk that has arrived.
 * @typedef {object} ChunkFigures
 * @property {number} stream
 * @property {number} end the bytes of the file up to its end
 * @property {number} triangles those of the mesh after it
 * @property {number} error that of the mesh after it, in mesh units
 */

/**
 * How the connection is. `waiting`: others come first. `paused`: by `pause`. `retrying`: it is lost, and tried again after some time. `busy`: the server asks to come again, because it makes the file first or has too many clients. `done`: all has arrived.
 * @typedef {'connecting' | 'loading' | 'waiting' | 'paused' | 'retrying' | 'busy' | 'done'} ConnectionState
 */

/**
 * What a page is told of a model, in this order: `document` once, `binary` until all of it is there, then `chunks` and `update`.
 * @typedef {object} ModelEvents
 * @property {(json: any, binaryBytes: number) => void} [document] the glTF document, and the bytes of the binary chunk before the stream: all of it, if there is no stream
 * @property {(bytes: Uint8Array, start: number) => void} [binary] bytes of the binary chunk before the stream, and where they start in it
 * @property {(chunks: ChunkFigures[]) => void} [chunks] chunks that have arrived
 * @property {(update: Update) => unknown} [update] the arrays are the page's to keep. If it returns a promise, the next update comes after it is fulfilled
 * @property {(progress: Progress) => void} [progress] bytes that have arrived without an update
 * @property {(state: ConnectionState, seconds: number) => void} [connection] `seconds` until the next try, if it is `retrying` or `busy`
 * @property {(error: ModelError) => void} [error] nothing more comes, unless `retry` is called; what was shown stays good
 */

/**
 * Why a model ends early.
 * @typedef {object} ModelError
 * @property {'connection' | 'status' | 'changed' | 'unreadable' | 'damaged' | 'not-glb' | 'limit' | 'worker'} kind `status`: the server refuses; `changed`: the file is another one than before; `unreadable`: a file of the device cannot be read; `limit`: it is too large; `worker`: the worker has failed
 * @property {string} message for people
 */

/**
 * How a model is loaded.
 * @typedef {object} LoadOptions
 * @property {Output} [output] 'strips' unless told otherwise
 * @property {number} [priority] models of the highest priority are downloaded first; 0 unless told otherwise. Models of one priority share the connection
 * @property {boolean} [keepBytes] whether the file is kept in memory, so that `show` can go back; false unless told otherwise
 * @property {import('../decoder.js').StreamLimits} [limits]
 * @property {Record<string, string>} [headers] headers of the requests
 * @property {RequestCredentials} [credentials]
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
   * @param {Worker} [worker] one that runs worker.js, for pages that start it in a way of their own
   */
  constructor(worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module', name: 'tristrip' })) {
    this.#worker = worker;
    worker.onmessage = ({ data }) => this.#models.get(data.id)?.receive(data);
    const fail = (/** @type {string} */ message) => {
      for (const model of this.#models.values()) model.receive({ type: 'error', error: { kind: 'worker', message } });
    };
    worker.onerror = (event) => fail(event.message || 'The worker that decodes models could not be started.');
    worker.onmessageerror = () => fail('A message of the worker could not be read.');
  }

  /**
   * Begins to load a model.
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
   * Simulates a network of some bandwidth for all models.
   * @param {number} bitsPerSecond 0 for no limit
   */
  set bandwidth(bitsPerSecond) {
    this.#worker.postMessage({ type: 'bandwidth', bitsPerSecond });
  }

  /** Closes all models, and ends the worker. */
  close() {
    for (const model of [...this.#models.values()]) model.close();
    this.#worker.terminate();
  }
}

/** A model that is loaded: returned by `Client.load`. */
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
   * Takes a message of the worker. For the client only.
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
   * Sets which models come first.
   * @param {number} priority
   */
  set priority(priority) {
    this.#post({ type: 'priority', priority });
  }

  /** Stops to download and to refine. */
  pause() {
    this.#post({ type: 'pause' });
  }

  /** Goes on after `pause`. */
  resume() {
    this.#post({ type: 'resume' });
  }

  /** Tries again from where the connection was lost: after an error, or at once instead of after the pause. */
  retry() {
    this.#post({ type: 'retry' });
  }

  /**
   * Shows the model as it is after a number of chunks, earlier or later ones than before. Needs `keepBytes`.
   * @param {number} chunkCount Infinity for all that have arrived and will arrive
   */
  show(chunkCount) {
    this.#post({ type: 'show', chunkCount });
  }

  /** Stops to load, and frees what the worker has of the model. No event comes after it. */
  close() {
    if (this.#isClosed) return;
    this.#isClosed = true;
    this.#events = {};
    this.#post({ type: 'close' });
    this.#forget();
  }
}
