/**
 * The page: shows the gallery or a model, depending on the address.
 * @module
 */
import { besideFile, besideUrl } from './beside.js';
import { connectControls, setMode, showAnimations } from './controls.js';
import { bytesText, countText, element, setText, timeText } from './elements.js';
import { fillGallery, nameOf, takeFiles } from './gallery.js';
import { announce, hideMessage, showError, showMessage } from './messages.js';
import { connectLevel, follow, setConnection, updatePanel } from './panel.js';
import { FILE_HASH, readState, writeState } from './state.js';
import { Viewer } from './viewer.js';

/**
 * The minimum interval between changes of the address, in milliseconds. Browsers limit their rate.
 */
const ADDRESS_INTERVAL = 400;

const gallery = element('gallery', HTMLElement);
const stage = element('stage', HTMLElement);
const name = element('name', HTMLElement);
const canvas = element('canvas', HTMLCanvasElement);
const busy = element('busy', HTMLElement);

/**
 * The URL of the model shown, and the last local file.
 * @type {string | undefined}
 */
let url;
/** @type {File | undefined} */
let file;
/**
 * The files selected together with it.
 * @type {File[]}
 */
let beside = [];

let isStarted = false;

/**
 * Returns the animation to play for the index in an address. It is paused if the user prefers
 * reduced motion.
 * @param {number | undefined} animation counted from 1
 */
const playingOf = (animation = 0) => ({ animation: Math.max(animation - 1, 0), isPlaying: animation > 0 && !matchMedia('(prefers-reduced-motion: reduce)').matches });

/**
 * Switches between the stage and the gallery.
 * @param {boolean} isStage
 */
function turn(isStage) {
  stage.hidden = !isStage;
  gallery.hidden = isStage;
  document.body.classList.toggle('is-stage', isStage);
}

/** @param {string} title of the model */
function setTitle(title) {
  setText(name, title);
  document.title = `${title} – tristrip viewer`;
  canvas.setAttribute('aria-label', `3D view of ${title}`);
}

/** Starts the viewer. */
function start() {
  /** Whether the WebGL context is lost. */
  let isLost = false;

  /** Shows or hides the message about the state of the model. */
  const showState = () => {
    const { error, state, hasPicture } = viewer;
    busy.hidden = state !== 'loading' || hasPicture;
    if (isLost && state !== 'empty') showMessage('The graphics context was lost.', 'The image returns when the browser restores it.');
    else if (error) showError(error, hasPicture, () => viewer.retry(), replay);
    else if (state === 'complete' && !hasPicture) showMessage('Nothing to show.', 'The scene of this file has no triangles, lines or points.');
    else hideMessage();
  };

  /** @type {Viewer} */
  const viewer = new Viewer(canvas, {
    change: () => schedulePanel(),
    animations: () => showAnimations(viewer),
    firstPicture: () => {
      busy.hidden = true;
      announce('First image.');
    },
    complete: () => {
      showState();
      const { sums, outside, progress } = viewer.figures;
      const [entry] = performance.getEntriesByName('tristrip:complete', 'measure');
      announce(`Complete: ${countText(sums.triangles + outside)} triangles, ${bytesText(progress?.totalBytes ?? 0)}, after ${timeText(entry.duration)}.`);
    },
    connection: (state) => {
      const words = state === 'retrying' ? 'connection lost, retrying' : state === 'busy' ? 'waiting for the server' : state === 'connecting' || state === 'waiting' ? state : '';
      setConnection(words);
      if (state === 'retrying') announce('Connection lost. Retrying.');
      if (state === 'busy') announce('Waiting for the server.');
      schedulePanel();
    },
    error: showState,
    context: (isGone) => {
      isLost = isGone;
      showState();
    },
  });

  let isScheduled = false;
  const schedulePanel = () => {
    if (isScheduled) return;
    isScheduled = true;
    setTimeout(viewer.timed(() => {
      isScheduled = false;
      if (viewer.state !== 'empty') updatePanel(viewer);
    }), 50);
  };

  const begin = () => {
    setConnection('');
    follow();
  };
  const replay = () => {
    begin();
    viewer.replay();
    showState();
    announce('Reloading.');
  };

  /**
   * @param {string | File} source
   * @param {string} title
   * @param {string} [view]
   * @param {number} [animation]
   */
  const open = (source, title, view, animation) => {
    begin();
    turn(true);
    setTitle(title);
    const { camera } = viewer.renderer;
    camera.isAutomatic = true;
    if (view) camera.parse(view);
    viewer.open(source, typeof source === 'string' ? besideUrl(source) : besideFile(beside), playingOf(animation));
    showAnimations(viewer);
    showState();
    announce(`Loading ${title}.`);
    // When the page opens with a model, don't move the focus.
    if (isStarted) canvas.focus({ preventScroll: true });
  };

  const leave = () => {
    viewer.close();
    hideMessage();
    turn(false);
    const link = url && document.querySelector(`#cards a[href="${CSS.escape(writeState({ model: url, view: undefined, mode: undefined }))}"]`);
    (link instanceof HTMLElement ? link : element('gallery-title', HTMLElement)).focus();
    url = undefined;
    document.title = 'tristrip viewer';
    announce('All models.');
  };

  /** Shows what the address refers to. */
  const route = () => {
    const state = readState(location.hash);
    setMode(viewer, state.mode ?? 'textured');
    if (state.model !== undefined && state.model === url) {
      const { camera } = viewer.renderer;
      if (!state.view || !camera.parse(state.view)) camera.reset();
      const { animation, isPlaying } = playingOf(state.animation);
      const { playing } = viewer;
      if (animation !== playing.animation || isPlaying !== playing.isPlaying) viewer.playing = { animation, isPlaying };
      showAnimations(viewer);
      viewer.renderer.draw();
    } else if (state.model !== undefined) {
      url = state.model;
      open(url, nameOf(url), state.view, state.animation);
    } else if (location.hash === FILE_HASH && file) {
      url = undefined;
      open(file, nameOf(file.name));
    } else if (viewer.state !== 'empty') leave();
    else if (location.hash === FILE_HASH) {
      // The page was reloaded.
      history.replaceState(null, '', '#');
      setText(element('drop-text', HTMLElement), 'The local file shown before was not saved. Choose it again to view it.');
    }
  };

  let timer = 0;
  connectControls(viewer, {
    view: () => {
      timer ||= setTimeout(() => {
        timer = 0;
        if (url === undefined) return;
        const { camera, mode } = viewer.renderer;
        const { animation, isPlaying } = viewer.playing;
        const isNoted = isPlaying || animation > 0;
        history.replaceState(null, '', writeState({ model: url, view: camera.isAutomatic ? undefined : camera.toString(), mode, animation: isNoted ? animation + 1 : undefined }));
      }, ADDRESS_INTERVAL);
    },
    leave: () => {
      location.hash = '';
    },
    replay,
  });
  connectLevel(viewer);
  takeFiles((chosen, others) => {
    file = chosen;
    beside = others;
    if (location.hash === FILE_HASH) route();
    else location.hash = FILE_HASH;
  });
  window.addEventListener('hashchange', viewer.timed(route));
  // For tests.
  Object.assign(window, { tristrip: Object.freeze({ viewer }) });
  route();
  isStarted = true;
}

try {
  start();
} catch (error) {
  turn(true);
  document.body.classList.add('is-broken');
  setText(name, 'No 3D view');
  showMessage(error instanceof Error ? error.message : String(error), 'Current versions of Firefox, Chrome, Edge and Safari support WebGL 2. It may be disabled in the settings, or the graphics driver may be too old.');
}
// When the page opens with a model, its name is known only after the list has loaded.
fillGallery().then(() => url !== undefined && setTitle(nameOf(url)));
