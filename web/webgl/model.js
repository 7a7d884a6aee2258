/**
 * A model on the GPU: converts the events of the client to geometry, textures and nodes.
 * @module
 */
import { EXTENSION } from '../src/container.js';
import { accessorEnd, Accessors, Binary, unitOf, UnsupportedError, viewBytes, viewEnd } from './accessors.js';
import { Animation, PATHS } from './animation.js';
import { Geometry, IndexData, LOCATIONS, VertexData } from './geometry.js';
import { countTriangles } from './indices.js';
import { readMaterial } from './materials.js';
import { compose } from './matrix.js';
import { MORPHED, Morphs } from './morphs.js';
import { PulledTextures } from './pulled.js';
import { Scene } from './scene.js';
import { Textures } from './textures.js';

/**
 * @import { ModelEvents, Update } from '../src/client/client.js'
 * @import { Budget } from './budget.js'
 * @import { Box } from './camera.js'
 * @import { Material } from './materials.js'
 */

/** The maximum number of instances of all nodes. */
const MAX_INSTANCES = 10000;
/**
 * The maximum number of morph-target texels of all primitives, 16 bytes each. Targets beyond it are
 * dropped.
 */
const MAX_MORPH_TEXELS = 2 ** 23;
const REQUIRED = new Set([EXTENSION, 'KHR_texture_transform', 'KHR_materials_unlit', 'KHR_mesh_quantization', 'KHR_materials_emissive_strength', 'EXT_mesh_gpu_instancing', 'EXT_texture_webp']);

/**
 * @typedef {object} Primitive
 * @property {Geometry} own the geometry of its accessors; the base mesh if there is a stream
 * @property {number | undefined} stream
 * @property {number} part
 * @property {Material} material
 */

/**
 * Notifications to the owner of a model.
 * @typedef {object} ModelListener
 * @property {() => void} change data are ready to upload
 * @property {() => void} draw the image has changed
 * @property {(bounds: Box) => void} bounds
 * @property {(error: Error) => void} error
 * @property {(update: Update) => void} shown an update is uploaded
 * @property {(uri: string) => Promise<Blob>} find finds an image in another file
 */

/** A model that is displayed. */
export class ShownModel {
  #gl;
  #listener;
  /** @type {any} */
  #json;
  #binary = new Binary();
  /** The total size of the binary chunk in bytes. */
  #binaryBytes = 0;
  #accessors = new Accessors(undefined);
  /**
   * Attributes and indices by their content; primitives share them.
   * @type {Map<number, VertexData>}
   */
  #vertices = new Map();
  /** @type {Map<string, IndexData>} */
  #indices = new Map();
  #instancesLeft = MAX_INSTANCES;
  #morphTexelsLeft = MAX_MORPH_TEXELS;
  #areBoundsOld = false;
  /**
   * Work that needs the binary chunk, and the number of bytes it needs.
   * @type {{ end: number, run: (bytes: Uint8Array) => void }[]}
   */
  #tasks = [];
  /**
   * Queued updates, and the one being uploaded, each with the promise of the client.
   * @type {{ update: Update, resolve: () => void }[]}
   */
  #updates = [];
  /** @type {{ update: Update, resolve: () => void } | undefined} */
  #current;
  /**
   * Meshes with pending uploads.
   * @type {Set<Geometry>}
   */
  #changed = new Set();
  /** @type {Map<number, Geometry>} */
  #streams = new Map();
  /** @type {Primitive[][]} */
  #meshes = [];
  /** @type {Map<number, WebGLTexture | null>} */
  #joints = new Map();
  #pulled = new PulledTextures();
  #isClosed = false;
  /** @type {Scene | undefined} */
  scene;
  /** @type {Textures | undefined} */
  textures;
  /** @type {Animation[]} */
  animations = [];

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {ModelListener} listener
   */
  constructor(gl, listener) {
    this.#gl = gl;
    this.#listener = listener;
  }

  /**
   * The events to pass to `Client.load`.
   * @returns {Required<Pick<ModelEvents, 'document' | 'binary' | 'update'>>}
   */
  get events() {
    return {
      document: (json, binaryBytes) => this.#guard(() => this.#open(json, binaryBytes)),
      binary: (bytes, start) => {
        if (this.#tasks.length > 0) this.#binary.add(bytes, start);
        this.#listener.change();
      },
      // The next update comes after this one is shown.
      update: (update) =>
        new Promise((/** @type {(value?: undefined) => void} */ resolve) => {
          this.#updates.push({ update, resolve });
          this.#listener.change();
        }),
    };
  }

  /** Whether uploads are pending. */
  get isBusy() {
    const { length } = this.#binary.bytes;
    return this.#changed.size > 0 || this.#updates.length > 0 || this.#tasks.some(({ end }) => end <= length);
  }

  /** @param {() => void} act a function that can fail on a damaged document */
  #guard(act) {
    try {
      if (!this.#isClosed) act();
    } catch (error) {
      // Replace engine exceptions (TypeError, RangeError), whose messages don't help users.
      const isOurs = error instanceof Error && !(error instanceof TypeError || error instanceof RangeError);
      this.#listener.error(isOurs ? error : new Error('The document is not valid glTF.', { cause: error }));
    }
  }

  /**
   * @param {any} json
   * @param {number} binaryBytes
   */
  #open(json, binaryBytes) {
    const missing = (json.extensionsRequired ?? []).find((/** @type {string} */ name) => !REQUIRED.has(name));
    if (missing) throw new UnsupportedError(`The model requires ${missing}.`);
    this.#json = json;
    this.#binaryBytes = binaryBytes;
    this.#accessors = new Accessors(json);
    const scene = (this.scene = new Scene(json));
    const textures = (this.textures = new Textures(this.#gl, json, () => this.#listener.draw(), (uri) => this.#listener.find(uri)));
    const materials = (json.materials ?? []).map(readMaterial);
    const plain = readMaterial();
    this.#meshes = (json.meshes ?? []).map((/** @type {any} */ mesh, /** @type {number} */ i) =>
      mesh.primitives.map((/** @type {any} */ primitive) => this.#primitive(primitive, scene.isMorphed(i), materials[primitive.material] ?? plain)),
    );
    for (const [index, image] of (json.images ?? []).entries()) {
      if (image.bufferView !== undefined) this.#later(viewEnd(json, image.bufferView), (bytes) => textures.add(index, viewBytes(json, image.bufferView, bytes)));
    }
    for (const [index, { inverseBindMatrices, joints }] of (json.skins ?? []).entries()) {
      const identity = Array.from({ length: 16 * joints.length }, (_, i) => (i % 16) % 5 === 0 ? 1 : 0);
      this.#later(accessorEnd(json, inverseBindMatrices), (bytes) => {
        scene.bindings.set(index, inverseBindMatrices === undefined ? identity : this.#accessors.read(inverseBindMatrices, bytes).array);
        this.#areBoundsOld = true;
      });
    }
    for (const node of scene.nodes.values()) {
      const attributes = json.nodes[node.index].extensions?.EXT_mesh_gpu_instancing?.attributes;
      if (attributes) this.#readInstances(node, attributes);
    }
    for (const animation of json.animations ?? []) this.#readAnimation(animation);
    this.#areBoundsOld = true;
    this.#listener.change();
  }

  /**
   * Runs a task when enough of the binary chunk has arrived. If the chunk is too short, the task
   * runs at once and fails.
   * @param {number} end the number of bytes needed
   * @param {(bytes: Uint8Array) => void} run
   */
  #later(end, run) {
    if (end <= this.#binaryBytes) this.#tasks.push({ end, run });
    else run(this.#binary.bytes);
  }

  /**
   * @param {any} primitive
   * @param {boolean} isMorphed
   * @param {Material} material
   * @returns {Primitive}
   */
  #primitive({ attributes, indices, mode = 4, extensions, targets: all = [] }, isMorphed, material) {
    const json = this.#json;
    const targets = isMorphed ? all : [];
    const { stream, part = 0 } = extensions?.[EXTENSION] ?? {};
    const own = new Geometry();
    const used = [...Object.values(attributes), indices, ...targets.flatMap(Object.values)];
    this.#later(Math.max(...used.map((accessor) => accessorEnd(json, accessor))), (bytes) => {
      let count = 0;
      /** @type {Map<string, VertexData>} */
      const vertices = new Map();
      for (const [name, accessor] of Object.entries(attributes)) {
        if (!Object.hasOwn(LOCATIONS, name)) continue;
        const index = /** @type {number} */ (accessor);
        if (name === 'POSITION') count = this.#accessors.read(index, bytes).count;
        vertices.set(name, this.#vertexData(index, bytes));
      }
      const faces = indices === undefined ? new IndexData(null, count, mode) : this.#indexData(indices, mode, bytes);
      own.fill(vertices, part, faces, this.#morphs(targets, count, bytes));
      this.#changed.add(own);
    });
    return { own, stream, part, material };
  }

  /**
   * Returns the attribute of an accessor.
   * @param {number} index
   * @param {Uint8Array} bytes
   */
  #vertexData(index, bytes) {
    let data = this.#vertices.get(index);
    if (!data) {
      const { array, components, normalized } = this.#accessors.read(index, bytes);
      data = new VertexData(array, components, normalized);
      this.#vertices.set(index, data);
    }
    return data;
  }

  /**
   * Returns the morph targets of a primitive, up to the limit, or `undefined` if there are none.
   * @param {Record<string, number>[]} targets
   * @param {number} vertexCount
   * @param {Uint8Array} bytes
   */
  #morphs(targets, vertexCount, bytes) {
    const names = MORPHED.filter((name) => targets.some((target) => target[name] !== undefined));
    const texels = names.length * vertexCount;
    const count = texels > 0 ? Math.min(targets.length, Math.floor(this.#morphTexelsLeft / texels)) : 0;
    if (count === 0) return undefined;
    this.#morphTexelsLeft -= count * texels;
    const read = (/** @type {Record<string, number>} */ target) =>
      new Map(names.filter((name) => target[name] !== undefined).map((name) => [name, this.#accessors.read(target[name], bytes)]));
    return new Morphs(targets.slice(0, count).map(read), vertexCount);
  }

  /**
   * Returns the indices of an accessor.
   * @param {number} index
   * @param {number} mode
   * @param {Uint8Array} bytes
   */
  #indexData(index, mode, bytes) {
    const key = `${index} ${mode}`;
    let data = this.#indices.get(key);
    if (!data) {
      const { array } = this.#accessors.read(index, bytes);
      data = new IndexData(/** @type {any} */ (array), array.length, mode);
      this.#indices.set(key, data);
    }
    return data;
  }

  /**
   * @param {import('./scene.js').Node} node
   * @param {Record<string, number>} attributes
   */
  #readInstances(node, { TRANSLATION, ROTATION, SCALE }) {
    const json = this.#json;
    node.instances = [];
    this.#later(Math.max(...[TRANSLATION, ROTATION, SCALE].map((accessor) => accessorEnd(json, accessor))), (bytes) => {
      const [t, r, s] = [TRANSLATION, ROTATION, SCALE].map((index) => (index === undefined ? undefined : this.#accessors.read(index, bytes)));
      const count = Math.min(t?.count ?? r?.count ?? s?.count ?? 0, this.#instancesLeft);
      this.#instancesLeft -= count;
      const item = (/** @type {import('./accessors.js').Accessor | undefined} */ from, /** @type {number} */ i, /** @type {number[]} */ usual) => (from ? Array.from(from.array.subarray(i * usual.length, (i + 1) * usual.length)) : usual);
      node.instances = Array.from({ length: count }, (_, i) => compose(item(t, i, [0, 0, 0]), item(r, i, [0, 0, 0, 1]), item(s, i, [1, 1, 1])));
      this.#areBoundsOld = true;
    });
  }

  /** @param {any} animation */
  #readAnimation({ channels, samplers, name }) {
    const json = this.#json;
    const made = new Animation(typeof name === 'string' ? name : '');
    this.animations.push(made);
    for (const { sampler, target } of channels) {
      const { input, output, interpolation = 'LINEAR' } = samplers[sampler];
      if (!PATHS.includes(target.path)) continue;
      this.#later(Math.max(accessorEnd(json, input), accessorEnd(json, output)), (bytes) => {
        const values = this.#accessors.read(output, bytes);
        const unit = unitOf(values);
        const numbers = unit === 1 ? values.array : Float32Array.from(values.array, (x) => Math.max(x / unit, -1));
        made.tracks.push({ node: target.node, path: target.path, interpolation, times: this.#accessors.read(input, bytes).array, values: numbers });
      });
    }
  }

  /**
   * Processes the received data within the budget. Returns whether the image has changed.
   * @param {Budget} budget
   */
  step(budget) {
    const hasRun = this.#runTasks(budget);
    if (this.#areBoundsOld) this.#guard(() => this.#bound());
    return this.#upload(budget) || hasRun;
  }

  /**
   * Runs the tasks whose bytes have arrived. Returns whether any task ran.
   * @param {Budget} budget
   */
  #runTasks(budget) {
    const { bytes } = this.#binary;
    const tasks = this.#tasks;
    this.#tasks = [];
    let hasRun = false;
    for (const task of tasks) {
      if (task.end > bytes.length || budget.bytes === 0) this.#tasks.push(task);
      else {
        this.#guard(() => task.run(bytes));
        hasRun = true;
      }
    }
    if (hasRun && this.#tasks.length === 0) this.#forgetBinary();
    return hasRun;
  }

  /** Drops data that only tasks need. */
  #forgetBinary() {
    this.#binary = new Binary();
    this.#accessors.clear();
    this.#vertices.clear();
    this.#indices.clear();
  }

  #bound() {
    this.#areBoundsOld = false;
    const bounds = this.scene?.bounds;
    if (bounds) this.#listener.bounds(bounds);
  }

  /**
   * Uploads what the budget allows. Returns whether the image has changed.
   * @param {Budget} budget
   */
  #upload(budget) {
    let isNew = false;
    // An update starts after the previous one is drawn, so everything uploaded is consistent.
    for (;;) {
      for (const geometry of this.#changed) {
        if (!geometry.upload(this.#gl, budget)) return isNew;
        this.#changed.delete(geometry);
        isNew = true;
      }
      if (this.#current) this.#listener.shown(this.#current.update);
      this.#current?.resolve();
      this.#current = this.#updates.shift();
      if (!this.#current) return isNew;
      for (const mesh of this.#current.update.meshes) {
        let geometry = this.#streams.get(mesh.stream);
        if (!geometry) this.#streams.set(mesh.stream, (geometry = new Geometry()));
        geometry.patch(mesh);
        this.#changed.add(geometry);
      }
    }
  }

  /**
   * The items to draw: each primitive with its current mesh.
   * @returns {{ node: import('./scene.js').Node, geometry: Geometry, part: number, material:
   *   Material }[]}
   */
  get items() {
    const items = [];
    for (const node of this.scene?.nodes.values() ?? []) {
      for (const { own, stream, part, material } of this.#meshes[node.mesh ?? -1] ?? []) {
        const streamed = stream === undefined ? undefined : this.#streams.get(stream);
        // A part without triangles is drawn as its base mesh.
        const geometry = streamed?.isShown(part) ? streamed : own;
        if (geometry.isShown(part)) items.push({ node, geometry, part, material });
      }
    }
    return items;
  }

  /**
   * Starts maintaining textures of a mesh.
   * @param {Geometry} geometry
   */
  pull(geometry) {
    if (geometry.pulled) return;
    geometry.pull(this.#pulled);
    this.#changed.add(geometry);
  }

  /** Stops maintaining textures of meshes. */
  unpull() {
    for (const geometry of this.#geometries) geometry.unpull();
    this.#pulled.release(this.#gl);
  }

  /**
   * Returns the joint texture of a skin.
   * @param {number | undefined} skin
   */
  joints(skin) {
    if (skin === undefined) return undefined;
    const known = this.#joints.get(skin);
    if (known) return known;
    const matrices = this.scene?.joints(skin);
    if (!matrices) return undefined;
    const gl = this.#gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 4, matrices.length / 16, 0, gl.RGBA, gl.FLOAT, matrices);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    this.#joints.set(skin, texture);
    return texture;
  }

  /**
   * Applies an animation to the nodes, or resets them if the animation does not exist.
   * @param {number} number the index of the animation
   * @param {number} seconds
   */
  animate(number, seconds) {
    if (!this.scene) return;
    // Another animation may have moved other nodes.
    this.scene.rest();
    this.animations[number]?.apply(this.scene, seconds);
    this.scene.update();
    this.#dropJoints();
  }

  #dropJoints() {
    for (const texture of this.#joints.values()) this.#gl.deleteTexture(texture);
    this.#joints.clear();
  }

  get #geometries() {
    return [...this.#streams.values(), ...this.#meshes.flat().map(({ own }) => own)];
  }

  /** The triangles of meshes without a stream. Takes time proportional to their indices. */
  get wholeTriangles() {
    const whole = this.#meshes.flat().filter(({ stream }) => stream === undefined);
    return whole.reduce((sum, { own }) => sum + [...own.parts.values()].reduce((ofParts, part) => ofParts + countTriangles(part), 0), 0);
  }

  /** Deletes all GPU objects. No listener is called afterwards. */
  close() {
    this.#isClosed = true;
    this.#dropJoints();
    this.textures?.release();
    this.unpull();
    // Deleting a shared buffer twice has no effect.
    for (const geometry of this.#geometries) geometry.release(this.#gl);
    this.#changed.clear();
    this.#updates = [];
    this.#tasks = [];
    this.#meshes = [];
    this.#streams.clear();
    this.#forgetBinary();
  }

  /** Creates all objects again after a context loss. */
  restore() {
    this.#joints.clear();
    this.textures?.forget();
    this.#pulled = new PulledTextures();
    for (const geometry of this.#geometries) {
      geometry.unpull();
      geometry.forget();
      this.#changed.add(geometry);
    }
  }
}
