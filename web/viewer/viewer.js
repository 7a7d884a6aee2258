/**
 * Loads one model after another, and shows it.
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
 * What a viewer tells the page.
 * @typedef {object} ViewerListener
 * @property {() => void} change the state or the figures have changed
 * @property {() => void} error there is one, or it goes on
 * @property {(state: ConnectionState) => void} connection
 * @property {() => void} animations those of the model are known
 * @property {() => void} firstPicture
 * @property {() => void} complete
 * @property {(isLost: boolean) => void} context
 */

/** @typedef {{ animation: number, isPlaying: boolean }} Playing */

/** @type {Playing} */
const STILL = { animation: 0, isPlaying: false };

/** What a list of animations has room for. */
const MAX_NAMES = 500;
const MAX_LETTERS = 80;

const MARKS = ['tristrip:click', 'tristrip:first-picture', 'tristrip:complete'];

/** The viewer: a client, a renderer, and the model that is open. */
export class Viewer {
  renderer;
  figures = new Figures();
  /** @type {ViewerState} */
  state = 'empty';
  /** Why the model ended early. @type {ViewerError | undefined} */
  error;
  isPaused = false;
  /** How the connection is. @type {ConnectionState} */
  connection = 'connecting';
  /** The files that the model refers to and that are not there. @type {Set<string>} */
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
  /** What is played when the model has come. */
  #wanted = STILL;
  #isDone = false;
  #hasPicture = false;
  #longest = 0;

  /**
   * Throws an `Error` if the browser has no WebGL 2.
   * @param {HTMLCanvasElement} canvas
   * @param {ViewerListener} listener
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

  /** The milliseconds of the longest call of ours on the main thread since the model was opened. */
  get longestTask() {
    return Math.max(this.#longest, this.renderer.longestTask);
  }

  get animationCount() {
    return this.#shown?.animations.length ?? 0;
  }

  /** The names of the animations of the model, of the first ones if there are very many. */
  get animations() {
    return (this.#shown?.animations ?? []).slice(0, MAX_NAMES).map(({ name }, i) => name.slice(0, MAX_LETTERS) || `Animation ${i + 1}`);
  }

  /** Whether an animation is played, and which one, from 0 on. @returns {Playing} */
  get playing() {
    const { animation, isPlaying } = this.renderer;
    return this.animationCount > 0 ? { animation, isPlaying } : this.#wanted;
  }

  /** Plays an animation, as soon as the model has come. One that the model does not have is not played. */
  set playing(playing) {
    this.#wanted = playing;
    if (this.animationCount === 0) return;
    const isKnown = playing.animation < this.animationCount;
    this.renderer.animation = isKnown ? playing.animation : 0;
    this.renderer.isPlaying = isKnown && playing.isPlaying;
  }

  /** Whether there is something to look at. */
  get hasPicture() {
    return this.#hasPicture;
  }

  /**
   * Calls a handler, and keeps its time if it is the longest.
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
   * Loads a model instead of the one before.
   * @param {Source} source
   * @param {FindFile} find finds images in other files
   * @param {Playing} [playing] what is played
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

  /** Loads the model from the start. */
  replay() {
    if (this.#source && this.#find) this.open(this.#source, this.#find, this.playing);
  }

  /** Closes the model, and frees its memory. */
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
    this.error = isOther ? { kind: 'not-glb', message: `A .gltf document refers to other files. “tristrip pack ${nameOfUri(name).split('/').pop()} -o model.glb” makes one GLB file of all.` } : isEmpty ? { kind: 'not-glb', message: 'The file is empty.' } : error;
    this.#listener.error();
    this.#listener.change();
  }

  /** Finds out whether all is shown. */
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

  /** Tries again after the connection was lost. */
  retry() {
    this.state = 'loading';
    this.error = undefined;
    this.#model?.retry();
    this.#listener.error();
    this.#listener.change();
  }

  /** Pauses, or goes on. */
  togglePause() {
    if (this.state !== 'loading') return;
    this.isPaused = !this.isPaused;
    if (this.isPaused) this.#model?.pause();
    else this.#model?.resume();
    this.#listener.change();
  }

  /**
   * Shows what a number of chunks gives.
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
