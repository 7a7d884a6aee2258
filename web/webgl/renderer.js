/**
 * Draws a model into a canvas with WebGL 2, and uploads received data between frames.
 * @module
 */
import { Budget } from './budget.js';
import { Camera } from './camera.js';
import { COLOR_TEXTURES, TEXTURES } from './materials.js';
import { cofactors, determinant, identity, multiply } from './matrix.js';
import { ShownModel } from './model.js';
import { Programs, UNITS } from './programs.js';

/**
 * @import { Update } from '../src/client/client.js'
 * @import { Material } from './materials.js'
 * @import { Program } from './programs.js'
 */

/**
 * The display modes, in the order of their numbers in the shader.
 * @type {['shaded', 'textured', 'wireframe', 'strips', 'normals']}
 */
export const MODES = ['shaded', 'textured', 'wireframe', 'strips', 'normals'];
/** @typedef {typeof MODES[number]} Mode */

const MAX_PIXEL_RATIO = 2;
/** The key light: to the right of the camera, above and behind it. */
const KEY_LIGHT = [0.45, 0.65, 0.61];
const LINE_COLOR = [0.06, 0.1, 0.18];

/**
 * Notifications to the page.
 * @typedef {object} RendererListener
 * @property {(update: Update) => void} [shown] an update is part of the next image
 * @property {(primitives: number) => void} [painted] an image was drawn, with this many primitives
 * @property {(error: Error) => void} [error] the model cannot be drawn
 * @property {(isLost: boolean) => void} [context] the context was lost or restored
 */

/** Draws a model into a canvas. */
export class Renderer {
  camera = new Camera();
  /** The number of frames drawn. */
  frames = 0;
  /** The duration of the longest call, in milliseconds. */
  longestTask = 0;
  #canvas;
  #gl;
  #listener;
  #programs;
  /** @type {Mode} */
  #mode = 'textured';
  /** @type {ShownModel | undefined} */
  #model;
  #white;
  #isDirty = true;
  /**
   * The programs whose view uniforms are set in this frame.
   * @type {Set<Program>}
   */
  #viewed = new Set();
  #animation = 0;
  #isPlaying = false;
  /** The start time of the animation, or the paused position in seconds. */
  #start = 0;
  #seconds = 0;
  #frame = 0;
  #observer;
  #end = new AbortController();

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {RendererListener} [listener]
   * @throws {Error} if the browser does not support WebGL 2
   */
  constructor(canvas, listener = {}) {
    const gl = canvas.getContext('webgl2', { antialias: true, alpha: true, powerPreference: 'high-performance' });
    if (!gl) throw new Error('This browser does not support WebGL\u00a02.');
    this.#canvas = canvas;
    this.#gl = gl;
    this.#listener = listener;
    this.#programs = new Programs(gl);
    this.#white = this.#makeWhite();
    const { signal } = this.#end;
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      listener.context?.(true);
    }, { signal });
    canvas.addEventListener('webglcontextrestored', () => this.#restore(), { signal });
    this.#warmUp();
    // A hidden page gets no frames, but loading continues.
    document.addEventListener('visibilitychange', () => this.#request(true), { signal });
    this.#observer = new ResizeObserver(() => this.draw());
    this.#observer.observe(canvas);
  }

  #makeWhite() {
    const gl = this.#gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4).fill(255));
    return texture;
  }

  /** Links the programs in advance; using an unlinked program would block. */
  #warmUp() {
    if (!this.#end.signal.aborted && !this.#programs.prepare()) setTimeout(() => this.#warmUp(), 20);
  }

  #restore() {
    this.#programs = new Programs(this.#gl);
    this.#warmUp();
    this.#white = this.#makeWhite();
    this.#model?.restore();
    this.#listener.context?.(false);
    this.draw();
  }

  /**
   * Closes the model and returns an empty one, whose `events` are passed to `Client.load`.
   * @param {(uri: string) => Promise<Blob>} [find] finds an image in another file; by default no
   *   such images are loaded
   * @returns {ShownModel}
   */
  open(find = async () => Promise.reject(new Error('Images in other files are not loaded.'))) {
    this.close();
    return (this.#model = new ShownModel(this.#gl, {
      change: () => this.#request(),
      draw: () => this.draw(),
      bounds: (bounds) => {
        this.camera.bounds = bounds;
        this.draw();
      },
      error: (error) => this.#listener.error?.(error),
      shown: (update) => this.#listener.shown?.(update),
      find,
    }));
  }

  /** Closes the model and frees its memory. */
  close() {
    this.#model?.close();
    this.#model = undefined;
    this.#animation = this.#seconds = 0;
    this.#isPlaying = false;
    this.draw();
  }

  /** Frees everything. The renderer cannot be used afterwards. */
  release() {
    this.close();
    cancelAnimationFrame(this.#frame);
    this.#end.abort();
    this.#observer.disconnect();
    this.#gl.getExtension('WEBGL_lose_context')?.loseContext();
  }

  /** Whether the image is up to date: nothing is left to upload, decode or draw. */
  get isIdle() {
    return this.#frame === 0 && !this.#isDirty && !this.#isMoving && !this.#model?.isBusy && !this.#model?.textures?.isBusy;
  }

  get mode() {
    return this.#mode;
  }

  set mode(mode) {
    this.#mode = mode;
    if (mode !== 'wireframe' && mode !== 'strips') this.#model?.unpull();
    this.draw();
  }

  /** The index of the animation. Setting it starts at the first keyframe. */
  get animation() {
    return this.#animation;
  }

  set animation(number) {
    this.#animation = number;
    this.#seconds = 0;
    this.#start = performance.now();
    this.#model?.animate(this.#isPlaying ? number : -1, 0);
    this.draw();
  }

  /** Whether the animation plays. It resumes where it was paused. */
  get isPlaying() {
    return this.#isPlaying;
  }

  set isPlaying(isPlaying) {
    if (isPlaying === this.#isPlaying) return;
    if (isPlaying) this.#start = performance.now() - 1000 * this.#seconds;
    else this.#seconds = (performance.now() - this.#start) / 1000;
    this.#isPlaying = isPlaying;
    this.draw();
  }

  /** Whether every frame differs. Animations of hidden pages cost nothing. */
  get #isMoving() {
    return this.#isPlaying && !document.hidden;
  }

  /** Draws in the next frame. */
  draw() {
    this.#isDirty = true;
    this.#request();
  }

  #request(isNew = false) {
    if (this.#frame !== 0 && !isNew) return;
    cancelAnimationFrame(this.#frame);
    if (document.hidden) {
      this.#frame = -1;
      setTimeout(() => this.#run(), 50);
    } else this.#frame = requestAnimationFrame(() => this.#run());
  }

  #run() {
    const start = performance.now();
    this.#frame = 0;
    if (this.#end.signal.aborted || this.#gl.isContextLost()) return;
    try {
      if (this.#model?.step(new Budget())) this.#isDirty = true;
      const isDrawn = this.#isDirty;
      this.#isDirty = false;
      if (isDrawn || this.#isMoving) this.#paint();
    } catch (error) {
      this.#listener.error?.(error instanceof Error ? error : new Error(String(error)));
      return;
    }
    this.longestTask = Math.max(this.longestTask, performance.now() - start);
    if (this.#isDirty || this.#isMoving || this.#model?.isBusy) this.#request();
  }

  #resize() {
    const canvas = this.#canvas;
    const ratio = Math.min(window.devicePixelRatio, MAX_PIXEL_RATIO);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    this.camera.resize(width / height);
    this.#gl.viewport(0, 0, width, height);
  }

  #paint() {
    const gl = this.#gl;
    const model = this.#model;
    this.#resize();
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.vertexAttrib4f(4, 1, 1, 1, 1);
    this.frames++;
    if (!model) return;
    if (this.#isPlaying) model.animate(this.#animation, (performance.now() - this.#start) / 1000);
    const { axes, eye, viewProjection } = this.camera;
    const keyLight = [0, 1, 2].map((i) => KEY_LIGHT.reduce((sum, x, j) => sum + x * axes[j][i], 0));
    const items = model.items.map((item) => {
      const { world } = item.node;
      const isBlended = item.material.alphaMode === 'BLEND' && this.#mode === 'textured';
      return { ...item, isBlended, depth: isBlended ? Math.hypot(...eye.map((x, i) => x - world[12 + i])) : 0 };
    });
    // Opaque items first, then blended items from back to front.
    items.sort((a, b) => b.depth - a.depth).sort((a, b) => Number(a.isBlended) - Number(b.isBlended));
    this.#viewed.clear();
    let painted = 0;
    for (const item of items) if (this.#paintItem(model, item, { eye, keyLight, viewProjection })) painted++;
    gl.depthMask(true);
    gl.activeTexture(gl.TEXTURE0);
    // The image is incomplete while a program is being compiled.
    if (!this.#isDirty) this.#listener.painted?.(painted);
  }

  /**
   * @param {ShownModel} model
   * @param {ShownModel['items'][number] & { isBlended: boolean }} item
   * @param {{ eye: number[], keyLight: number[], viewProjection: number[] }} view
   */
  #paintItem(model, { node, geometry, part, material, isBlended }, { eye, keyLight, viewProjection }) {
    const gl = this.#gl;
    const { mode } = this;
    const joints = model.joints(node.skin);
    const isTriangles = (geometry.parts.get(part)?.mode ?? 0) >= 4;
    const isPulled = isTriangles && (mode === 'wireframe' || mode === 'strips');
    if (isPulled) model.pull(geometry);
    const pulled = isPulled && geometry.pulled?.isReady ? geometry.pulled : undefined;
    const isSkinned = joints !== undefined && geometry.attributes.has('JOINTS_0') && geometry.attributes.has('WEIGHTS_0');
    const morphs = node.weights.some((weight) => weight !== 0) ? geometry.morphs : undefined;
    const names = [pulled ? 'PULL' : geometry.attributes.has('NORMAL') ? 'NORMALS' : '', isSkinned ? 'SKIN' : '', morphs ? 'MORPH' : ''];
    const program = this.#programs.get(names.filter(Boolean).join(' '));
    if (!program) {
      this.#isDirty = true;
      return false;
    }
    const { at } = program;
    const isUsed = this.#viewed.has(program);
    gl.useProgram(program.program);
    if (!isUsed) {
      this.#viewed.add(program);
      gl.uniformMatrix4fv(at('viewProjection'), false, viewProjection);
      gl.uniform3fv(at('eye'), eye);
      gl.uniform3fv(at('keyLight'), keyLight);
      gl.uniform3fv(at('lineColor'), LINE_COLOR);
      gl.uniform1i(at('mode'), MODES.indexOf(mode));
    }
    if (joints) this.#bind('joints', joints);
    /** @type {(name: string, texture: WebGLTexture | null) => void} */
    const bind = (name, texture) => this.#bind(name, texture);
    morphs?.bind(gl, program, node.weights, bind);
    if (pulled) pulled.bind(part, bind);
    else this.#setMaterial(model, material, program);
    gl[isBlended ? 'enable' : 'disable'](gl.BLEND);
    gl.depthMask(!isBlended);
    const isCulled = !material.isDoubleSided && mode !== 'wireframe';
    gl[isCulled ? 'enable' : 'disable'](gl.CULL_FACE);
    for (const instance of isSkinned ? [undefined] : node.instances) {
      // Joints position a skinned mesh; its node does not.
      const world = instance ? multiply(node.world, instance) : identity();
      const isMirrored = determinant(world) < 0;
      gl.frontFace(isMirrored ? gl.CW : gl.CCW);
      gl.uniformMatrix4fv(at('world'), false, world);
      gl.uniformMatrix3fv(at('normalMatrix'), false, cofactors(world).map((x) => (isMirrored ? -x : x)));
      if (pulled) pulled.draw(gl, part, at('topology'));
      else geometry.draw(gl, part);
    }
    return true;
  }

  /**
   * Binds a texture to the unit of a sampler.
   * @param {string} name
   * @param {WebGLTexture | null} texture
   */
  #bind(name, texture) {
    const gl = this.#gl;
    gl.activeTexture(gl.TEXTURE0 + (UNITS.get(name) ?? 0));
    gl.bindTexture(gl.TEXTURE_2D, texture);
  }

  /**
   * @param {ShownModel} model
   * @param {Material} material
   * @param {Program} program
   */
  #setMaterial(model, material, { at }) {
    const gl = this.#gl;
    const isTextured = this.#mode === 'textured';
    let hasNormalMap = false;
    for (const [i, name] of TEXTURES.entries()) {
      const number = isTextured ? material.textures[i] : undefined;
      const texture = number === undefined ? null : model.textures?.get(number, COLOR_TEXTURES[i]);
      this.#bind(name, texture ?? this.#white);
      if (name === 'normalTexture') hasNormalMap = Boolean(texture);
    }
    gl.uniformMatrix3fv(at('uvMatrix'), false, material.uvMatrices);
    gl.uniform1iv(at('uvSet'), material.uvSets);
    gl.uniform4fv(at('baseColor'), material.baseColor);
    gl.uniform3fv(at('emissive'), material.emissive);
    gl.uniform4fv(at('factors'), material.factors);
    gl.uniform1f(at('cutoff'), material.cutoff);
    gl.uniform1i(at('unlit'), Number(material.isUnlit));
    gl.uniform1i(at('hasNormalMap'), Number(hasNormalMap));
    gl.uniform1i(at('alphaMode'), isTextured ? ['OPAQUE', 'MASK', 'BLEND'].indexOf(material.alphaMode) : 0);
  }
}
