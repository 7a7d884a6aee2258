/**
 * Loads and shows one model at a time.
 * @module
 */
import { Client } from '../src/client/client.js';
import { UnsupportedError } from '../webgl/accessors.js';
import { Renderer } from '../webgl/renderer.js';
import { isDocument, nameOfUri } from './beside.js';
import { Figures } from './figures.js';

/**
 * @import { ConnectionState, Model, ModelError, ModelEvents, Source } from '../src/client/client.js'
 * @import { ShownModel } from '../webgl/model.js'
 * @import { FindFile } from './beside.js'
 */

/** @typedef {{ kind: ModelError['kind'] | 'unsupported', message: string }} ViewerError */
/** @typedef {'empty' | 'loading' | 'complete' | 'failed'} ViewerState */

/**
 * Notifications to the page.
 * @typedef {object} ViewerListener
 * @property {() => void} change the state or metrics have changed
 * @property {() => void} error an error occurred, or loading resumed after one
 * @property {(state: ConnectionState) => void} connection
 * @property {() => void} animations the animations of the model are known
 * @property {() => void} firstPicture
 * @property {() => void} complete
 * @property {(isLost: boolean) => void} context
 */

/** @typedef {{ animation: number, isPlaying: boolean }} Playing */

/** @type {Playing} */
const STILL = { animation: 0, isPlaying: false };

/** The maximum number of listed animations. */
const MAX_NAMES = 500;
const MAX_LETTERS = 80;

const MARKS = ['tristrip:click', 'tristrip:first-picture', 'tristrip:complete'];

/** The viewer: a client, a renderer and the open model. */
export class Viewer {
  renderer;
  figures = new Figures();
  /** @type {ViewerState} */
  state = 'empty';
  /**
   * Why loading ended early.
   * @type {ViewerError | undefined}
   */
  error;
  isPaused = false;
  /**
   * The state of the connection.
   * @type {ConnectionState}
   */
  connection = 'connecting';
  /**
   * Files that the model refers to and that are missing.
   * @type {Set<string>}
   */
  missing = new Set();
  #client = new Client();
  #listener;
  /** @type {Source | undefined} */
  #source;
  /** @type {FindFile | undefined} */
  #find;
  /** @type {Model | undefined} */
  #model;
  /** @type {ShownModel | undefined} */
  #shown;
  /** The animation to play when the model has arrived. */
  #wanted = STILL;
  #isDone = false;
  #hasPicture = false;
  #longest = 0;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {ViewerListener} listener
   * @throws {Error} if the browser does not support WebGL 2
   */
  constructor(canvas, listener) {
    this.#listener = listener;
    this.renderer = new Renderer(canvas, {
      shown: (update) => {
        this.figures.show(update);
        listener.change();
      },
      painted: (primitives) => {
        if (primitives > 0 && !this.#hasPicture) {
          this.#hasPicture = true;
          this.#mark('tristrip:first-picture');
          listener.firstPicture();
        }
        this.#checkEnd();
      },
      error: (error) => {
        this.#model?.close();
        this.#fail({ kind: error instanceof UnsupportedError ? 'unsupported' : 'damaged', message: error.message });
      },
      context: (isLost) => listener.context(isLost),
    });
  }

  /** The duration of the longest main-thread call since the model was opened, in milliseconds. */
  get longestTask() {
    return Math.max(this.#longest, this.renderer.longestTask);
  }

  get animationCount() {
    return this.#shown?.animations.length ?? 0;
  }

  /** The names of the animations of the model, up to a maximum. */
  get animations() {
    return (this.#shown?.animations ?? []).slice(0, MAX_NAMES).map(({ name }, i) => name.slice(0, MAX_LETTERS) || `Animation ${i + 1}`);
  }

  /**
   * The selected animation, counted from 0, and whether it plays.
   * @returns {Playing}
   */
  get playing() {
    const { animation, isPlaying } = this.renderer;
    return this.animationCount > 0 ? { animation, isPlaying } : this.#wanted;
  }

  /**
   * Selects an animation, applied when the model has arrived. Ignored if the model does not have
   * it.
   */
  set playing(playing) {
    this.#wanted = playing;
    if (this.animationCount === 0) return;
    const isKnown = playing.animation < this.animationCount;
    this.renderer.animation = isKnown ? playing.animation : 0;
    this.renderer.isPlaying = isKnown && playing.isPlaying;
  }

  /** Whether anything can be drawn. */
  get hasPicture() {
    return this.#hasPicture;
  }

  /**
   * Wraps a handler to measure its duration for `longestTask`.
   * @template {any[]} A
   * @template R
   * @param {(...values: A) => R} handle
   * @returns {(...values: A) => R}
   */
  timed(handle) {
    return (...values) => {
      const start = performance.now();
      const result = handle(...values);
      this.#longest = Math.max(this.#longest, performance.now() - start);
      return result;
    };
  }

  /** @param {string} name */
  #mark(name) {
    performance.mark(name);
    if (name !== MARKS[0]) performance.measure(name, MARKS[0], name);
  }

  /**
   * Loads a model, and closes the previous one.
   * @param {Source} source
   * @param {FindFile} find finds images in other files
   * @param {Playing} [playing] the animation to play
   */
  open(source, find, playing = STILL) {
    this.close();
    this.#find = find;
    this.#wanted = playing;
    for (const name of MARKS) {
      performance.clearMarks(name);
      performance.clearMeasures(name);
    }
    this.#mark(MARKS[0]);
    this.#longest = this.renderer.longestTask = 0;
    this.#source = source;
    this.state = 'loading';
    const figures = this.figures;
    const missing = (this.missing = new Set());
    const shown = (this.#shown = this.renderer.open((uri) =>
      find(uri).catch((error) => {
        missing.add(nameOfUri(uri));
        this.#listener.change();
        throw error;
      }),
    ));
    const { document, binary, update } = shown.events;
    /** @type {ModelEvents} */
    const events = {
      document: (json, bytes) => {
        document(json, bytes);
        if (this.state === 'loading') figures.open(json);
        if (this.animationCount > 0) this.playing = this.#wanted;
        else this.#wanted = STILL;
        this.#listener.animations();
        this.#listener.change();
      },
      binary,
      update,
      chunks: (chunks) => {
        figures.addChunks(chunks);
        this.#listener.change();
      },
      progress: (progress) => {
        figures.progress = progress;
        this.#listener.change();
      },
      connection: (state) => {
        this.connection = state;
        this.#isDone = state === 'done';
        if (this.#isDone) this.renderer.draw();
        this.#listener.connection(state);
      },
      error: (error) => this.#fail(error),
    };
    const handlers = Object.entries(events).map(([name, handle]) => [name, this.timed(/** @type {any} */ (handle))]);
    this.#model = this.#client.load(source, Object.fromEntries(handlers), { keepBytes: true });
    this.#listener.change();
  }

  /** Loads the model again from the start. */
  replay() {
    if (this.#source && this.#find) this.open(this.#source, this.#find, this.playing);
  }

  /** Closes the model and frees its memory. */
  close() {
    this.#model?.close();
    this.#model = this.#shown = undefined;
    this.renderer.close();
    this.figures = new Figures();
    this.state = 'empty';
    this.error = undefined;
    this.connection = 'connecting';
    this.isPaused = this.#isDone = this.#hasPicture = false;
  }

  /** @param {ViewerError} error */
  #fail(error) {
    this.state = 'failed';
    const name = this.#source instanceof File ? this.#source.name : String(this.#source);
    const isEmpty = error.kind === 'not-glb' && this.figures.progress?.receivedBytes === 0;
    const isOther = error.kind === 'not-glb' && isDocument(name);
    this.error = isOther ? { kind: 'not-glb', message: `A .gltf document refers to other files. “tristrip pack ${nameOfUri(name).split('/').pop()} -o model.glb” combines them into one GLB file.` } : isEmpty ? { kind: 'not-glb', message: 'The file is empty.' } : error;
    this.#listener.error();
    this.#listener.change();
  }

  /** Checks whether everything is shown. */
  #checkEnd() {
    const { isStreamed, progress } = this.figures;
    if (this.state !== 'loading' || !this.#isDone || this.#shown?.isBusy) return;
    if (isStreamed && !progress?.isComplete) return;
    this.state = 'complete';
    this.figures.outside = this.#shown?.wholeTriangles ?? 0;
    this.#mark('tristrip:complete');
    this.#listener.complete();
    this.#listener.change();
  }

  /** Resumes the download after the connection was lost. */
  retry() {
    this.state = 'loading';
    this.error = undefined;
    this.#model?.retry();
    this.#listener.error();
    this.#listener.change();
  }

  /** Pauses or resumes. */
  togglePause() {
    if (this.state !== 'loading') return;
    this.isPaused = !this.isPaused;
    if (this.isPaused) this.#model?.pause();
    else this.#model?.resume();
    this.#listener.change();
  }

  /**
   * Shows the model after a number of chunks.
   * @param {number} chunkCount Infinity for all
   */
  show(chunkCount) {
    this.#model?.show(chunkCount);
  }

  /** @param {number} bitsPerSecond 0 for no limit */
  set bandwidth(bitsPerSecond) {
    this.#client.bandwidth = bitsPerSecond;
  }
}
