/**
 * Progressive models in three.js: `ProgressiveLoader` is used like `GLTFLoader`, and the scene that it returns refines by itself.
 *
 * ```text
 * loader.js       ProgressiveLoader: options, LoadingManager, callbacks and promises
 * model.js        ProgressiveModel, `gltf.progressive`: what the client reports of one model, from the first byte to dispose()
 * base_glb.js     the file up to its stream, as a GLB of its own for GLTFLoader
 * plugin.js       the GLTFLoader plugin: which geometries are drawn from which mesh of the stream
 * stream_mesh.js  the buffers of one mesh of the stream: updates are written into them in place
 * names.js        the names that GLTFLoader gives to attributes
 * bounds.js       bounding boxes and spheres, grown by what changes
 * view.js         the size on screen, as the priority of a model
 * disposal.js     what a scene holds on the GPU
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
