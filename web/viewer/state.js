/**
 * The model and the view in the address of the page: `#model=models/bunny.glb&view=0.5,0.25,0.3,0,0.1,0&mode=strips&animation=2`.
 * @module
 */
import { MODES } from '../webgl/renderer.js';

/** @import { Mode } from '../webgl/renderer.js' */

/** The address while a file of this device is shown. */
export const FILE_HASH = '#file';

/**
 * @typedef {object} PageState
 * @property {string | undefined} model its URL
 * @property {string | undefined} view as `Camera.parse` takes it
 * @property {Mode | undefined} mode
 * @property {number | undefined} [animation] the one that is played or chosen, from 1 on
 */

/**
 * Whether a URL is a relative one of this site.
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
 * Reads the part of the address behind `#`. What is not understood is left out.
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
