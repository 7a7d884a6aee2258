/**
 * The model and view in the address of the page:
 * `#model=models/bunny.glb&view=0.5,0.25,0.3,0,0.1,0&mode=strips&animation=2`.
 * @module
 */
import { MODES } from '../webgl/renderer.js';

/** @import { Mode } from '../webgl/renderer.js' */

/** The hash of the address while a local file is shown. */
export const FILE_HASH = '#file';

/**
 * @typedef {object} PageState
 * @property {string | undefined} model URL of the model
 * @property {string | undefined} view see `Camera.parse`
 * @property {Mode | undefined} mode
 * @property {number | undefined} [animation] the selected animation, counted from 1
 */

/**
 * Checks whether a URL is relative and belongs to this site.
 * @param {string} url
 */
function isLocal(url) {
  try {
    return new URL(url, location.href).origin === location.origin && !/^([a-z][a-z\d+.-]*:|[\\/]{2})/i.test(url);
  } catch {
    return false;
  }
}

/**
 * Parses the hash of an address. Invalid parts are ignored.
 * @param {string} hash
 * @returns {PageState}
 */
export function readState(hash) {
  const values = new URLSearchParams(hash.slice(1));
  const model = values.get('model') ?? '';
  return {
    model: model && isLocal(model) ? model : undefined,
    view: values.get('view') ?? undefined,
    mode: MODES.find((mode) => mode === values.get('mode')),
    animation: /^[1-9]\d{0,5}$/.test(values.get('animation') ?? '') ? Number(values.get('animation')) : undefined,
  };
}

/**
 * @param {PageState} state
 * @returns {string}
 */
export function writeState({ model, view, mode, animation }) {
  const parts = [
    model === undefined ? '' : `model=${encodeURIComponent(model).replaceAll('%2F', '/')}`,
    view === undefined ? '' : `view=${view}`,
    mode === undefined || mode === 'textured' ? '' : `mode=${mode}`,
    animation === undefined ? '' : `animation=${animation}`,
  ];
  return `#${parts.filter(Boolean).join('&')}`;
}
