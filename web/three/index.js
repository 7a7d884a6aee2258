/**
 * Progressive models in three.js. `ProgressiveLoader` is used like `GLTFLoader`; the scene it
 * returns refines as data arrive.
 *
 * ```text
 * loader.js       ProgressiveLoader: options, LoadingManager, callbacks and promises
 * model.js        ProgressiveModel (`gltf.progressive`): one model, from first byte to dispose()
 * base_glb.js     the file up to its stream, as a separate GLB for GLTFLoader
 * plugin.js       the GLTFLoader plugin: maps geometries to meshes of the stream
 * stream_mesh.js  the buffers of one mesh of the stream, updated in place
 * names.js        the names that GLTFLoader gives to attributes
 * bounds.js       bounding boxes and spheres, extended by changes
 * view.js         the size on screen, used as the priority of a model
 * disposal.js     GPU resources of a scene
 * ```
 * @module
 */
export { ProgressiveLoader } from './loader.js';
export { ProgressiveError, ProgressiveModel } from './model.js';

/**
 * @typedef {import('./loader.js').ProgressiveLoaderOptions} ProgressiveLoaderOptions
 * @typedef {import('./loader.js').ProgressiveLoadOptions} ProgressiveLoadOptions
 * @typedef {import('./model.js').ProgressiveGLTF} ProgressiveGLTF
 * @typedef {import('./model.js').ProgressiveEventMap} ProgressiveEventMap
 */
