/**
 * One progressive model: follows what the client reports of it, and refines its scene.
 *
 * ```text
 * document ─▶ binary ─▶ GLTFLoader.parse ─▶ the scene (`loaded`)
 *                └─▶ update ─▶ update ─▶ … StreamMesh: buffers, from the first update on; geometries get them with the scene
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

/** @typedef {GLTF & { progressive: ProgressiveModel }} ProgressiveGLTF what GLTFLoader returns, and how the refinement is followed */

/**
 * The events of a model.
 * @typedef {object} ProgressiveEventMap
 * @property {{ update: Update }} update geometries have changed: render again
 * @property {{ progress: Progress }} progress bytes have arrived
 * @property {{ state: ConnectionState, seconds: number }} connection
 * @property {{ error: ProgressiveError }} error the refinement has ended early; the geometries stay as they are
 * @property {{}} complete the full model is there
 */

/**
 * A priority changes by at least this factor before the worker is told: the camera moves in each frame.
 */
const PRIORITY_STEP = 1.125;

/** Why a model could not be loaded, or why its refinement has ended early. */
export class ProgressiveError extends Error {
  name = 'ProgressiveError';

  /** @param {ModelError} error */
  constructor({ kind, message }) {
    super(message);
    /** Who can act on it: see `ModelError`. */
    this.kind = kind;
  }
}

/**
 * The refinement of a model: `gltf.progressive`.
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
  /** What has arrived of the binary chunk before the stream. @type {Uint8Array[]} */
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
   * Begins to load a model. For the loader only.
   * @param {Client} client
   * @param {Source} source
   * @param {GLTFLoader} gltfLoader with the plugin
   * @param {string} path where the document's external files are
   * @param {LoadOptions} options
   * @param {(model: ProgressiveModel) => void} forget called when nothing more will come
   */
  constructor(client, source, gltfLoader, path, { signal, ...options }, forget) {
    super();
    this.#gltfLoader = gltfLoader;
    this.#path = path;
    this.#priority = options.priority ?? 0;
    this.#signal = signal;
    this.#forget = forget;
    /** Resolves with the scene when its base meshes are there. @type {Promise<ProgressiveGLTF>} */
    this.loaded = new Promise((resolve, reject) => {
      this.#resolveLoaded = resolve;
      this.#rejectLoaded = reject;
    });
    /** Resolves when the full model is there; rejects if it ends before. `retry` begins another one. @type {Promise<void>} */
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
    // A page that does not ask for the end is not told of it by the console.
    done.catch(() => {});
    return done;
  }

  /** How far the model is; `undefined` before anything has arrived. */
  get progress() {
    return this.#progress;
  }

  /** Why the refinement has ended early, if it has. */
  get error() {
    return this.#error;
  }

  /** Whether nothing more will come: the model is complete or cancelled. */
  get isClosed() {
    return this.#isClosed;
  }

  /** Whether the full model is there. */
  get isComplete() {
    return this.#isComplete;
  }

  /**
   * Calls a function after each update of the geometries: to render again, on pages that do not do so all the time.
   * @param {(update: Update) => void} listener
   * @returns {() => void} ends this
   */
  onUpdate(listener) {
    const onUpdate = (/** @type {{ update: Update }} */ { update }) => listener(update);
    this.addEventListener('update', onUpdate);
    return () => this.removeEventListener('update', onUpdate);
  }

  /** Stops to download and to refine. */
  pause() {
    this.#model.pause();
  }

  /** Goes on after `pause`. */
  resume() {
    this.#model.resume();
  }

  /** Tries again after an error of the connection, from where it was lost; or at once, while it is tried again by itself. */
  retry() {
    if (this.#isClosed) return;
    if (this.#error) {
      if (this.#error.kind !== 'connection') return;
      // It may not be told yet.
      this.#rejectDone(this.#error);
      this.#error = undefined;
      this.done = this.#promiseEnd();
    }
    this.#model.retry();
  }

  /**
   * Sets which models come first.
   * @param {number} priority models of the highest one are downloaded before others; those of one priority share the connection
   */
  setPriority(priority) {
    if (priority === this.#priority) return;
    this.#priority = priority;
    this.#model.priority = priority;
  }

  /**
   * Sets the priority to the height of the model on screen as a fraction of the view; 0 if it is out of view.
   *
   * Takes the time to update the matrices of the scene: a few calls per second are enough.
   * @param {Camera} camera
   */
  setView(camera) {
    if (!this.#gltf || this.#isClosed) return;
    const size = sizeOnScreen(this.#gltf.scenes, camera);
    const [small, large] = size < this.#priority ? [size, this.#priority] : [this.#priority, size];
    if (small === 0 || large > PRIORITY_STEP * small) this.setPriority(size);
  }

  /** Stops to load and to refine. The scene stays as it is. */
  cancel() {
    this.#cancel();
  }

  /** Stops to load, takes the scenes out of those that they are in, and frees the geometries, materials and textures that came with them. */
  dispose() {
    this.#cancel();
    this.#resources?.dispose();
    this.#resources = undefined;
    this.#gltf = undefined;
    this.#meshes.clear();
  }

  #cancel = () => {
    if (this.#isClosed) return;
    this.#end(this.#signal?.aborted ? this.#signal.reason : new DOMException('The model is not loaded any more.', 'AbortError'));
  };

  /** Ends the download and frees what the worker has. */
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
    // It was cancelled meanwhile.
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
    // The page adds its listeners when it is told of the scene.
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
    // Small models have arrived before their scene is there, and may still be cancelled.
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
   * Ends early.
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
 * Returns the meshes of each geometry that have bounds of their own: skinned and instanced ones.
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
