/**
 * `ProgressiveLoader` loads progressive GLB files in the way GLTFLoader loads glTF.
 * @module
 */
import { Loader, LoaderUtils } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { Client } from '../src/client/client.js';
import { ProgressiveModel } from './model.js';
import { createPlugin } from './plugin.js';

/**
 * @import { Camera, LoadingManager } from 'three'
 * @import { LoadOptions, Source } from '../src/client/client.js'
 * @import { ProgressiveGLTF } from './model.js'
 */

/**
 * Options of a loader.
 * @typedef {object} ProgressiveLoaderOptions
 * @property {Client} [client] the client, whose worker decodes; by default shared by all loaders
 * @property {GLTFLoader} [gltfLoader] the loader for the document, base meshes and everything else;
 *   pass one with DRACOLoader, KTX2Loader or plugins if needed
 */

/**
 * Options of a model.
 * @typedef {object} ProgressiveLoadOptions
 * @property {AbortSignal} [signal] stops loading, before or after the scene is available
 * @property {(event: ProgressEvent) => void} [onProgress] called when bytes arrive, also during
 *   refinement
 * @property {number} [priority] the priority until `setPriority`, `setView` or `updatePriorities`
 *   is called; by default 1, as for a model that fills the view
 * @property {LoadOptions['limits']} [limits] decoder limits
 */

/** The priority of a model before it is placed in a scene, as if it filled the view. */
const FIRST_PRIORITY = 1;

/** @type {Client | undefined} */
let sharedClient;

/**
 * The loaders that already have the plugin.
 * @type {WeakSet<GLTFLoader>}
 */
const extended = new WeakSet();

/**
 * Loads progressive GLB files, and other files as GLTFLoader does. `onLoad` is called when base
 * meshes and textures are available; the scene then refines in the background.
 *
 * ```js
 * const gltf = await new ProgressiveLoader().loadAsync('model.glb');
 * scene.add(gltf.scene);
 * await gltf.progressive.done;
 * ```
 * @extends {Loader<ProgressiveGLTF>}
 */
export class ProgressiveLoader extends Loader {
  #client;
  #gltfLoader;
  /**
   * The models that may still refine.
   * @type {Set<ProgressiveModel>}
   */
  #models = new Set();

  /**
   * @param {LoadingManager} [manager]
   * @param {ProgressiveLoaderOptions} [options]
   */
  constructor(manager, { client, gltfLoader = new GLTFLoader(manager) } = {}) {
    super(manager);
    this.#client = client;
    this.#gltfLoader = gltfLoader;
    if (!extended.has(gltfLoader)) gltfLoader.register(createPlugin);
    extended.add(gltfLoader);
  }

  /** The client with the worker, which starts with the first model. */
  get client() {
    return (this.#client ??= sharedClient ??= new Client());
  }

  /**
   * Loads a model.
   * @override
   * @param {string} url
   * @param {(gltf: ProgressiveGLTF) => void} onLoad
   * @param {(event: ProgressEvent) => void} [onProgress] called when bytes arrive, also during
   *   refinement
   * @param {(error: unknown) => void} [onError] called for errors before `onLoad`; later errors are
   *   `error` events of `gltf.progressive`
   * @param {ProgressiveLoadOptions} [options]
   */
  load(url, onLoad, onProgress, onError, options = {}) {
    this.manager.itemStart(url);
    const end = () => this.manager.itemEnd(url);
    const fail = (/** @type {unknown} */ error) => {
      if (onError) onError(error);
      else console.error(error);
      this.manager.itemError(url);
    };
    const address = this.manager.resolveURL(this.path + url);
    const path = this.resourcePath || LoaderUtils.extractUrlBase(this.path + url);
    this.#begin(address, path, { onProgress, ...options }).loaded.then(onLoad, fail).finally(end);
  }

  /**
   * Loads a model.
   * @override
   * @param {string} url
   * @param {ProgressiveLoadOptions | ((event: ProgressEvent) => void)} [options] options, or only
   *   `onProgress`
   * @returns {Promise<ProgressiveGLTF>}
   */
  loadAsync(url, options = {}) {
    const all = typeof options === 'function' ? { onProgress: options } : options;
    return new Promise((resolve, reject) => this.load(url, resolve, undefined, reject, all));
  }

  /**
   * Loads a model from the bytes of a file.
   * @param {Blob | ArrayBuffer | Uint8Array} data
   * @param {string} path base path of external textures
   * @param {(gltf: ProgressiveGLTF) => void} onLoad
   * @param {(error: unknown) => void} [onError]
   * @param {ProgressiveLoadOptions} [options]
   */
  parse(data, path, onLoad, onError = console.error, options = {}) {
    this.parseAsync(data, path, options).then(onLoad, onError);
  }

  /**
   * Loads a model from the bytes of a file.
   * @param {Blob | ArrayBuffer | Uint8Array} data
   * @param {string} [path] base path of external textures
   * @param {ProgressiveLoadOptions} [options]
   * @returns {Promise<ProgressiveGLTF>}
   */
  parseAsync(data, path = this.resourcePath, options = {}) {
    return this.#begin(data, path, options).loaded;
  }

  /**
   * Sets the priority of each model to its height on screen as a fraction of the view, so that
   * models in view load first.
   *
   * This updates the matrices of incomplete models; call it a few times per second.
   * @param {Camera} camera
   */
  updatePriorities(camera) {
    for (const model of this.#models) model.setView(camera);
  }

  /**
   * Stops loading all models. Scenes that are already available are unchanged.
   * @override
   */
  abort() {
    for (const model of this.#models) model.cancel();
    return this;
  }

  /**
   * @param {Source} source
   * @param {string} path
   * @param {ProgressiveLoadOptions} options
   */
  #begin(source, path, { onProgress, signal, priority = FIRST_PRIORITY, limits }) {
    /** @type {LoadOptions} */
    const options = {
      priority,
      headers: this.requestHeader,
      credentials: this.withCredentials ? 'include' : 'same-origin',
      ...(signal && { signal }),
      ...(limits && { limits }),
    };
    const model = new ProgressiveModel(this.client, source, this.#gltfLoader, path, options, (closed) => this.#models.delete(closed));
    if (!model.isClosed) this.#models.add(model);
    if (onProgress) {
      model.addEventListener('progress', ({ progress: { receivedBytes: loaded, totalBytes: total } }) => {
        onProgress(new ProgressEvent('progress', { lengthComputable: total > 0, loaded, total }));
      });
    }
    return model;
  }
}
