/**
 * Messages over the 3D view, and announcements for screen readers.
 * @module
 */
import { element, make, setText } from './elements.js';

/** @import { ViewerError } from './viewer.js' */

const box = element('message', HTMLElement);
const announcer = element('announcer', HTMLElement);
const canvas = element('canvas', HTMLCanvasElement);

/** @type {Record<ViewerError['kind'], string>} */
const CAUSES = {
  connection: 'The connection was lost.',
  status: 'The server refused this file.',
  changed: 'The file on the server changed during loading.',
  unreadable: 'This file cannot be read.',
  damaged: 'The file is damaged.',
  'not-glb': 'This is not a GLB file.',
  unsupported: 'This viewer cannot show the model.',
  limit: 'The model is too large for this device.',
  worker: 'This browser cannot decode models.',
};

/**
 * Shows a message over the 3D view.
 * @param {string} text
 * @param {string} [detail]
 * @param {Record<string, () => void>} [actions] buttons
 */
export function showMessage(text, detail = '', actions = {}) {
  const buttons = Object.entries(actions).map(([name, act]) => {
    const button = make('button', { type: 'button' }, name);
    button.addEventListener('click', () => {
      act();
      // The button with the focus is removed; move the focus to the canvas.
      canvas.focus({ preventScroll: true });
    });
    return button;
  });
  box.replaceChildren(make('p', {}, text), ...(detail ? [make('p', { class: 'muted' }, detail)] : []), ...buttons);
}

/** Removes the message. */
export function hideMessage() {
  box.replaceChildren();
}

/**
 * Shows why loading ended early.
 * @param {ViewerError} error
 * @param {boolean} hasPicture whether a part of the model is shown
 * @param {() => void} retry resumes the download
 * @param {() => void} replay loads the model again
 */
export function showError({ kind, message }, hasPicture, retry, replay) {
  const rest = hasPicture ? ' The part received so far is shown.' : '';
  const actions = { connection: { Retry: retry }, changed: { Reload: replay }, status: { Reload: replay } };
  const { [kind]: action = {} } = /** @type {Record<string, Record<string, () => void>>} */ (actions);
  showMessage(CAUSES[kind] + rest, message.replace(/^(The connection was lost)?[:\s]+/, ''), action);
}

/**
 * Announces a text to screen readers.
 * @param {string} text
 */
export function announce(text) {
  setText(announcer, text);
}
