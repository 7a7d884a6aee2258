/**
 * An example page that shows a model without three.js.
 * @module
 */
import { Client } from '../src/client/client.js';
import { moveByKey, orbitByPointer, Renderer } from './index.js';

const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector('canvas'));
const status = /** @type {HTMLElement} */ (document.querySelector('#status'));

const renderer = new Renderer(canvas, {
  shown({ progress: { shownBytes, totalBytes } }) {
    status.textContent = `${shownBytes} of ${totalBytes} bytes shown`;
  },
  error: (error) => (status.textContent = error.message),
});
orbitByPointer(canvas, renderer.camera, () => renderer.draw());
canvas.addEventListener('keydown', (event) => {
  if (!moveByKey(renderer.camera, event)) return;
  event.preventDefault();
  renderer.draw();
});

const url = location.search.slice(1);
if (url) {
  const events = renderer.open().events;
  new Client().load(url, { ...events, error: (error) => (status.textContent = error.message) });
}
