/**
 * Pointers, keys and buttons of the stage.
 * @module
 */
import { MODES } from '../webgl/renderer.js';
import { moveByKey, orbitByPointer } from '../webgl/orbit.js';
import { element, make } from './elements.js';
import { announce } from './messages.js';

/**
 * @import { Viewer } from './viewer.js'
 * @import { Mode } from '../webgl/renderer.js'
 */

/**
 * Notifications to the page.
 * @typedef {object} ControlsListener
 * @property {() => void} view the camera, mode or animation has changed
 * @property {() => void} leave
 * @property {() => void} replay
 */

const canvas = element('canvas', HTMLCanvasElement);
const modes = element('modes', HTMLFieldSetElement);
const animation = element('animation', HTMLElement);
const animate = /** @type {HTMLInputElement} */ (animation.firstElementChild);
const animations = element('animations', HTMLSelectElement);
const help = element('help-dialog', HTMLDialogElement);

/**
 * Sets the mode, and updates the panel.
 * @param {Viewer} viewer
 * @param {Mode} mode
 */
export function setMode({ renderer }, mode) {
  renderer.mode = mode;
  const input = modes.querySelector(`input[value=${mode}]`);
  if (input instanceof HTMLInputElement) input.checked = true;
}

/**
 * Shows the animations of the model, and which one plays.
 * @param {Viewer} viewer
 */
export function showAnimations({ animations: names, playing }) {
  animation.hidden = names.length === 0;
  animations.hidden = names.length < 2;
  animations.replaceChildren(...names.map((name, i) => make('option', { value: String(i) }, name)));
  animations.value = String(playing.animation);
  animate.checked = playing.isPlaying;
}

/**
 * Connects all controls.
 * @param {Viewer} viewer
 * @param {ControlsListener} listener
 */
export function connectControls(viewer, listener) {
  const { renderer } = viewer;
  const { camera } = renderer;
  const moved = () => {
    renderer.draw();
    listener.view();
  };
  const choose = (/** @type {Mode} */ mode) => {
    setMode(viewer, mode);
    listener.view();
  };
  orbitByPointer(canvas, camera, moved);

  canvas.addEventListener('keydown', viewer.timed((event) => {
    const mode = event.ctrlKey || event.altKey || event.metaKey ? undefined : MODES[Number(event.key) - 1];
    if (moveByKey(camera, event)) moved();
    else if (mode) choose(mode);
    else if (event.key === ' ') viewer.togglePause();
    else if (event.key === '?') help.showModal();
    else return;
    event.preventDefault();
  }));
  document.addEventListener('keydown', (event) => {
    const isInList = event.target instanceof HTMLSelectElement;
    if (event.key === 'Escape' && !isInList && !help.open && viewer.state !== 'empty') listener.leave();
  });

  const onClick = (/** @type {string} */ id, /** @type {() => void} */ act) => element(id, HTMLButtonElement).addEventListener('click', viewer.timed(act));
  onClick('play', () => viewer.togglePause());
  onClick('replay', listener.replay);
  onClick('help', () => help.showModal());
  onClick('reset', () => {
    camera.reset();
    moved();
  });
  onClick('link', async () => {
    try {
      await navigator.clipboard.writeText(location.href);
      announce('Link copied.');
      const button = element('link', HTMLButtonElement);
      button.textContent = 'Copied';
      setTimeout(() => (button.textContent = 'Copy link'), 2000);
    } catch {
      announce('Copy the link from the address bar.');
    }
  });
  modes.addEventListener('change', (event) => {
    if (event.target instanceof HTMLInputElement) choose(/** @type {Mode} */ (event.target.value));
  });
  const bandwidth = element('bandwidth', HTMLSelectElement);
  bandwidth.addEventListener('change', () => (viewer.bandwidth = Number(bandwidth.value)));
  animate.addEventListener('change', () => {
    renderer.isPlaying = animate.checked;
    listener.view();
  });
  animations.addEventListener('change', () => {
    // Choosing an animation also plays it.
    viewer.playing = { animation: Number(animations.value), isPlaying: true };
    animate.checked = true;
    listener.view();
  });
}
