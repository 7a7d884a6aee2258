/**
 * Camera control by mouse, touch, wheel and keyboard.
 * @module
 */

/** @import { Camera } from './camera.js' */

const KEY_ANGLE = Math.PI / 24;
const KEY_PAN = 0.05;
const KEY_ZOOM = 1.15;

/**
 * The actions of keys. With Shift, arrows pan.
 * @type {Record<string, (camera: Camera) => void>}
 */
const KEYS = {
  ArrowLeft: (camera) => camera.orbit(-KEY_ANGLE, 0),
  ArrowRight: (camera) => camera.orbit(KEY_ANGLE, 0),
  ArrowUp: (camera) => camera.orbit(0, KEY_ANGLE),
  ArrowDown: (camera) => camera.orbit(0, -KEY_ANGLE),
  a: (camera) => camera.pan(-KEY_PAN, 0),
  d: (camera) => camera.pan(KEY_PAN, 0),
  w: (camera) => camera.pan(0, KEY_PAN),
  s: (camera) => camera.pan(0, -KEY_PAN),
  '+': (camera) => camera.zoom(1 / KEY_ZOOM),
  '=': (camera) => camera.zoom(1 / KEY_ZOOM),
  '-': (camera) => camera.zoom(KEY_ZOOM),
  '0': (camera) => camera.reset(),
  Home: (camera) => camera.reset(),
};
/** @type {Record<string, string>} */
const SHIFTED = { ArrowLeft: 'a', ArrowRight: 'd', ArrowUp: 'w', ArrowDown: 's' };

/**
 * Moves the camera by a key. Returns whether the key has an action.
 * @param {Camera} camera
 * @param {KeyboardEvent} event
 */
export function moveByKey(camera, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return false;
  const key = (event.shiftKey && SHIFTED[event.key]) || event.key;
  if (!Object.hasOwn(KEYS, key)) return false;
  KEYS[key](camera);
  return true;
}

/**
 * Connects a camera to the pointers on a canvas. One pointer orbits; two zoom and pan; the right or
 * middle button, or Shift, pans.
 * @param {HTMLCanvasElement} canvas
 * @param {Camera} camera
 * @param {() => void} onchange called after each change
 * @param {AbortSignal} [signal] disconnects the camera
 */
export function orbitByPointer(canvas, camera, onchange, signal) {
  /** @type {Map<number, { x: number, y: number }>} */
  const pointers = new Map();
  /** The centre of the pointers and their distance. */
  const grip = () => {
    const all = [...pointers.values()];
    const [a, b = a] = all;
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, spread: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  /** @type {(type: 'pointerdown' | 'pointermove' | 'pointerup' | 'pointercancel', handle: (event: PointerEvent) => void) => void} */
  const on = (type, handle) => canvas.addEventListener(type, handle, { signal });
  on('pointerdown', (event) => {
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    canvas.setPointerCapture(event.pointerId);
  });
  on('pointermove', (event) => {
    if (!pointers.has(event.pointerId)) return;
    const before = grip();
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const after = grip();
    const right = (after.x - before.x) / canvas.clientHeight;
    const down = (after.y - before.y) / canvas.clientHeight;
    if (pointers.size > 1) {
      camera.pan(-right, down);
      if (before.spread > 0 && after.spread > 0) camera.zoom(before.spread / after.spread);
    } else if (event.shiftKey || event.buttons > 1) camera.pan(-right, down);
    else camera.orbit(-Math.PI * right, Math.PI * down);
    onchange();
  });
  const end = (/** @type {PointerEvent} */ event) => pointers.delete(event.pointerId);
  on('pointerup', end);
  on('pointercancel', end);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault(), { signal });
  canvas.addEventListener(
    'wheel',
    (event) => {
      event.preventDefault();
      // Wheel deltas in lines or pages are scaled. A touchpad pinch is a wheel event with Ctrl and
      // small deltas.
      const pixels = event.deltaY * (event.deltaMode === 0 ? 1 : 30) * (event.ctrlKey ? 5 : 1);
      camera.zoom(Math.exp(Math.max(-200, Math.min(200, pixels)) / 500));
      onchange();
    },
    { passive: false, signal },
  );
}
