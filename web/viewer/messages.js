/**
 * What people are told: messages over the picture, and short ones that only screen readers read.
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
  status: 'The server does not give this file.',
  changed: 'The file on the server has changed while it was loaded.',
  unreadable: 'This file cannot be read.',
  damaged: 'The file is damaged.',
  'not-glb': 'This is not a GLB file.',
  unsupported: 'This viewer cannot show the model.',
  limit: 'The model is too large for this device.',
  worker: 'This browser cannot decode models.',
};

/**
 * Shows a message over the picture.
 * @param {string} text
 * @param {string} [detail]
 * @param {Record<string, () => void>} [actions] buttons
 */
export function showMessage(text, detail = '', actions = {}) {
  const buttons = Object.entries(actions).map(([name, act]) => {
    const button = make('button', { type: 'button' }, name);
    button.addEventListener('click', () => {
      act();
      // The button is gone, and would leave the focus to nothing.
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
 * Shows why a model ended early.
 * @param {ViewerError} error
 * @param {boolean} hasPicture whether something of it is shown
 * @param {() => void} retry goes on
 * @param {() => void} replay starts again
 */
export function showError({ kind, message }, hasPicture, retry, replay) {
  const rest = hasPicture ? ' What has arrived before is shown.' : '';
  const actions = { connection: { Retry: retry }, changed: { 'Load again': replay }, status: { 'Load again': replay } };
  const { [kind]: action = {} } = /** @type {Record<string, Record<string, () => void>>} */ (actions);
  showMessage(CAUSES[kind] + rest, message.replace(/^(The connection was lost)?[:\s]+/, ''), action);
}

/**
 * Tells users of screen readers.
 * @param {string} text
 */
export function announce(text) {
  setText(announcer, text);
}
