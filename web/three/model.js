/**
 * One progressive model: handles the events of the client and refines the scene.
 *
 * ```text
 * document ─▶ binary ─▶ GLTFLoader.parse ─▶ the scene (`loaded`)
 *                └─▶ update ─▶ update ─▶ … StreamMesh: buffers, attached with the scene
 * ```
 * @module
 */
import { EventDispatcher } from 'three';
import { EXTENSION } from '../src/container.js';
import { baseGlb } from './base_glb.js';
import { Resources } from './disposal.js';
import { refinedGeometries } from './plugin.js';
import { StreamMesh } from './stream_mesh.js';
import { sizeOnScreen } from './view.js';

/**
 * @import { BufferGeometry, Camera, InstancedMesh, SkinnedMesh } from 'three'
 * @import { GLTF, GLTFLoader } from 'three/addons/loaders/GLTFLoader.js'
 * @import { Client, ConnectionState, LoadOptions, Model, ModelError, Progress, Source, Update } from '../src/client/client.js'
 */

/**
 * The result of GLTFLoader, extended by the refinement.
 * @typedef {GLTF & { progressive: ProgressiveModel }} ProgressiveGLTF
 */

/**
 * The events of a model.
 * @typedef {object} ProgressiveEventMap
 * @property {{ update: Update }} update geometries have changed; render again
 * @property {{ progress: Progress }} progress bytes have arrived
 * @property {{ state: ConnectionState, seconds: number }} connection the state of the connection
 *   has changed
 * @property {{ error: ProgressiveError }} error the refinement ended early; geometries are
 *   unchanged
 * @property {{}} complete the full model is available
 */

/**
 * The minimum factor of a priority change that is sent to the worker, because the camera can move
 * every frame.
 */
const PRIORITY_STEP = 1.125;

/** Why a model could not be loaded, or why its refinement ended early. */
export class ProgressiveError extends Error {
  name = 'ProgressiveError';

  /** @param {ModelError} error */
  constructor({ kind, message }) {
    super(message);
    /** The cause; see `ModelError`. */
    this.kind = kind;
  }
}

/**
 * The refinement of a model, available as `gltf.progressive`.
 * @extends {EventDispatcher<ProgressiveEventMap>}
 */
export class ProgressiveModel extends EventDispatcher {
  #gltfLoader;
  #path;
  /** @type {Model} */
  #model;
  #priority;
  #signal;
  #forget;
  /** @type {any} */
  #json;
  /**
   * The received bytes of the binary chunk before the stream.
   * @type {Uint8Array[]}
   */
  #pieces = [];
  #missingBytes = 0;
  /** @type {Map<number, StreamMesh>} */
  #meshes = new Map();
  /** @type {GLTF | undefined} */
  #gltf;
  /** @type {Resources | undefined} */
  #resources;
  /** @type {Progress | undefined} */
  #progress;
  /** @type {ProgressiveError | undefined} */
  #error;
  #isParsing = false;
  #isComplete = false;
  #isClosed = false;
  /** @type {(gltf: ProgressiveGLTF) => void} */
  #resolveLoaded = () => {};
  /** @type {(reason: any) => void} */
  #rejectLoaded = () => {};
  /** @type {(value?: any) => void} */
  #resolveDone = () => {};
  /** @type {(reason: any) => void} */
  #rejectDone = () => {};

  /**
   * Starts loading a model. Called by the loader.
   * @param {Client} client
   * @param {Source} source
   * @param {GLTFLoader} gltfLoader with the plugin
   * @param {string} path base path of external files
   * @param {LoadOptions} options
   * @param {(model: ProgressiveModel) => void} forget called when no more data will arrive
   */
  constructor(client, source, gltfLoader, path, { signal, ...options }, forget) {
    super();
    this.#gltfLoader = gltfLoader;
    this.#path = path;
    this.#priority = options.priority ?? 0;
    this.#signal = signal;
    this.#forget = forget;
    /**
     * Resolves with the scene when its base meshes are available.
     * @type {Promise<ProgressiveGLTF>}
     */
    this.loaded = new Promise((resolve, reject) => {
      this.#resolveLoaded = resolve;
      this.#rejectLoaded = reject;
    });
    /**
     * Resolves when the full model is available; rejects if it ends early. `retry` creates a new
     * promise.
     * @type {Promise<void>}
     */
    this.done = this.#promiseEnd();
    this.#model = client.load(
      source,
      {
        document: (json, binaryBytes) => this.#takeDocument(json, binaryBytes),
        binary: (bytes) => this.#takeBinary(bytes),
        update: (update) => this.#takeUpdate(update),
        progress: (progress) => this.#takeProgress(progress),
        connection: (state, seconds) => this.dispatchEvent({ type: 'connection', state, seconds }),
        error: (error) => this.#fail(new ProgressiveError(error)),
      },
      { ...options, output: 'lists' },
    );
    if (signal?.aborted) this.#cancel();
    else signal?.addEventListener('abort', this.#cancel, { once: true });
  }

  /** @returns {Promise<void>} */
  #promiseEnd() {
    const done = new Promise((resolve, reject) => {
      this.#resolveDone = resolve;
      this.#rejectDone = reject;
    });
    // Avoids unhandled-rejection messages on pages that do not use `done`.
    done.catch(() => {});
    return done;
  }

  /** The progress; `undefined` before any data have arrived. */
  get progress() {
    return this.#progress;
  }

  /** Why the refinement ended early, if it did. */
  get error() {
    return this.#error;
  }

  /** Whether no more data will arrive: the model is complete or cancelled. */
  get isClosed() {
    return this.#isClosed;
  }

  /** Whether the full model is available. */
  get isComplete() {
    return this.#isComplete;
  }

  /**
   * Calls a function after each update of the geometries. Use it on pages that render on demand.
   * @param {(update: Update) => void} listener
   * @returns {() => void} removes the listener
   */
  onUpdate(listener) {
    const onUpdate = (/** @type {{ update: Update }} */ { update }) => listener(update);
    this.addEventListener('update', onUpdate);
    return () => this.removeEventListener('update', onUpdate);
  }

  /** Pauses the download and the refinement. */
  pause() {
    this.#model.pause();
  }

  /** Resumes after `pause`. */
  resume() {
    this.#model.resume();
  }

  /**
   * Resumes a download after a connection error, or skips the delay before the next automatic
   * retry.
   */
  retry() {
    if (this.#isClosed) return;
    if (this.#error) {
      if (this.#error.kind !== 'connection') return;
      // The error may not have been reported yet.
      this.#rejectDone(this.#error);
      this.#error = undefined;
      this.done = this.#promiseEnd();
    }
    this.#model.retry();
  }

  /**
   * Sets the priority of the model.
   * @param {number} priority models with the highest priority are downloaded first; models with
   *   equal priority share the connection
   */
  setPriority(priority) {
    if (priority === this.#priority) return;
    this.#priority = priority;
    this.#model.priority = priority;
  }

  /**
   * Sets the priority to the height of the model on screen as a fraction of the view, or 0 if it is
   * out of view.
   *
   * This updates the matrices of the scene; call it a few times per second.
   * @param {Camera} camera
   */
  setView(camera) {
    if (!this.#gltf || this.#isClosed) return;
    const size = sizeOnScreen(this.#gltf.scenes, camera);
    const [small, large] = size < this.#priority ? [size, this.#priority] : [this.#priority, size];
    if (small === 0 || large > PRIORITY_STEP * small) this.setPriority(size);
  }

  /** Stops loading and refining. The scene is unchanged. */
  cancel() {
    this.#cancel();
  }

  /**
   * Stops loading, removes the scenes from their parents, and frees their geometries, materials and
   * textures.
   */
  dispose() {
    this.#cancel();
    this.#resources?.dispose();
    this.#resources = undefined;
    this.#gltf = undefined;
    this.#meshes.clear();
  }

  #cancel = () => {
    if (this.#isClosed) return;
    this.#end(this.#signal?.aborted ? this.#signal.reason : new DOMException('Loading was cancelled.', 'AbortError'));
  };

  /** Ends the download and frees the memory of the worker. */
  #close() {
    this.#isClosed = true;
    this.#signal?.removeEventListener('abort', this.#cancel);
    this.#model.close();
    this.#pieces = [];
    this.#forget(this);
  }

  /**
   * @param {any} json
   * @param {number} binaryBytes
   */
  #takeDocument(json, binaryBytes) {
    this.#json = json;
    this.#missingBytes = binaryBytes;
    if (binaryBytes === 0) this.#parse();
  }

  /** @param {Uint8Array} bytes */
  #takeBinary(bytes) {
    this.#pieces.push(bytes);
    this.#missingBytes -= bytes.length;
    if (this.#missingBytes === 0) this.#parse();
  }

  async #parse() {
    this.#isParsing = true;
    try {
      const bytes = baseGlb(this.#json, this.#pieces);
      this.#pieces = [];
      this.#takeScene(await this.#gltfLoader.parseAsync(bytes, this.#path));
    } catch (error) {
      this.#end(error);
    }
  }

  /** @param {GLTF} gltf */
  #takeScene(gltf) {
    const resources = new Resources(gltf);
    // The model was cancelled in the meantime.
    if (this.#isClosed) return resources.dispose();
    this.#resources = resources;
    const bounded = boundedMeshes(gltf);
    for (const refined of refinedGeometries(gltf.parser)) {
      this.#meshOf(refined.stream).add(refined, bounded.get(refined.geometry) ?? []);
    }
    this.#checkAttributes();
    this.#isParsing = false;
    this.#gltf = gltf;
    this.#resolveLoaded(Object.assign(gltf, { progressive: this }));
    if (this.#progress?.isComplete || !gltf.parser.json.extensions?.[EXTENSION]) this.#complete();
    // Wait until the page has received the scene and added its listeners.
    if (this.#error) setTimeout(() => this.#report());
  }

  /** @param {number} stream */
  #meshOf(stream) {
    let mesh = this.#meshes.get(stream);
    if (!mesh) this.#meshes.set(stream, (mesh = new StreamMesh()));
    return mesh;
  }

  /** @param {Update} update */
  #takeUpdate(update) {
    for (const mesh of update.meshes) this.#meshOf(mesh.stream).take(mesh);
    this.#checkAttributes();
    this.#progress = update.progress;
    if (this.#gltf) this.dispatchEvent({ type: 'update', update });
    this.#takeProgress(update.progress);
  }

  #checkAttributes() {
    for (const [stream, { missing }] of this.#meshes) {
      if (missing === undefined || this.#error) continue;
      this.#fail(new ProgressiveError({ kind: 'damaged', message: `Mesh ${stream} of the stream has no attribute ${missing}, which the document needs.` }));
      this.#close();
    }
  }

  /** @param {Progress} progress */
  #takeProgress(progress) {
    if (this.#isClosed) return;
    this.#progress = progress;
    this.dispatchEvent({ type: 'progress', progress });
    // Small models can arrive completely before their scene is available, and can still be
    // cancelled.
    if (progress.isComplete && this.#gltf) this.#complete();
  }

  #complete() {
    if (this.#isClosed) return;
    this.#isComplete = true;
    this.#close();
    this.#resolveDone();
    setTimeout(() => this.dispatchEvent({ type: 'complete' }));
  }

  /** @param {ProgressiveError} error */
  #fail(error) {
    this.#error = error;
    if (this.#gltf) return this.#report();
    if (!this.#isParsing) this.#end(error);
  }

  /**
   * Ends loading early.
   * @param {unknown} reason
   */
  #end(reason) {
    if (!this.#isClosed) this.#close();
    this.#rejectLoaded(reason);
    this.#rejectDone(reason);
  }

  #report() {
    const error = this.#error;
    if (!error) return;
    this.#rejectDone(error);
    this.dispatchEvent({ type: 'error', error });
  }
}

/**
 * Returns the skinned and instanced meshes of each geometry, which have their own bounds.
 * @param {GLTF} gltf
 * @returns {Map<BufferGeometry, (SkinnedMesh | InstancedMesh)[]>}
 */
function boundedMeshes({ scenes }) {
  const meshes = new Map();
  for (const scene of scenes) {
    scene.traverse((object) => {
      const mesh = /** @type {SkinnedMesh & InstancedMesh} */ (object);
      if (mesh.isSkinnedMesh || mesh.isInstancedMesh) meshes.set(mesh.geometry, [...(meshes.get(mesh.geometry) ?? []), mesh]);
    });
  }
  return meshes;
}
