/**
 * The models of the site as cards, and files that are dropped or selected.
 * @module
 */
import { isDocument } from './beside.js';
import { bytesText, countText, element, make } from './elements.js';
import { writeState } from './state.js';

/**
 * A model of `models.json`.
 * @typedef {object} ListedModel
 * @property {string} name
 * @property {string} url
 * @property {'progressive' | 'packed' | 'static'} kind
 * @property {number} bytes
 * @property {number | null} triangles
 * @property {number | null} vertices
 * @property {string} [thumbnail]
 */

const cards = element('cards', HTMLUListElement);
const notes = element('notes', HTMLElement);
const text = element('gallery-text', HTMLElement);

/**
 * The maximum number of retries for a thumbnail, and the delay before the first one in
 * milliseconds. The delay doubles.
 */
const MAX_IMAGE_TRIES = 5;
const IMAGE_PAUSE = 2000;

/**
 * The names of models by URL.
 * @type {Map<string, string>}
 */
const names = new Map();

/** Fills the gallery from `models.json`, if the site has one. */
export async function fillGallery() {
  try {
    const response = await fetch('models.json');
    if (!response.ok) throw new Error(String(response.status));
    const { models, notes: lines = [] } = /** @type {{ models: ListedModel[], notes?: string[] }} */ (await response.json());
    for (const { url, name } of models) names.set(url, name);
    cards.replaceChildren(...models.map(card));
    notes.replaceChildren(...lines.map((line) => make('p', {}, line)));
    if (models.length === 0) text.textContent = 'No models yet.';
  } catch {
    text.textContent = 'This site lists no models. You can open files from this device.';
  }
}

/**
 * Returns the name of a model.
 * @param {string} url
 */
export function nameOf(url) {
  const known = names.get(url);
  if (known !== undefined) return known;
  const last = url.split('/').pop() ?? url;
  return last.replace(/\.glb$/i, '');
}

/** @param {ListedModel} model */
function card({ name, url, kind, bytes, triangles, thumbnail }) {
  const figures = [bytesText(bytes), triangles === null ? '' : `${countText(triangles)} triangles`, kind === 'static' ? 'not progressive' : ''];
  const frame = make('span', { class: 'thumbnail' });
  if (thumbnail) {
    const image = make('img', { src: thumbnail, alt: '', loading: 'lazy', decoding: 'async', width: '320', height: '240' });
    retryImage(/** @type {HTMLImageElement} */ (image), thumbnail);
    frame.append(image);
  }
  const link = make('a', { href: writeState({ model: url, view: undefined, mode: undefined }) }, frame, make('strong', {}, name), make('span', { class: 'muted' }, figures.filter(Boolean).join(' · ')));
  return make('li', {}, link);
}

/**
 * Reloads an image after a delay when it fails, because the server renders thumbnails one at a
 * time. After the last retry, the image is removed.
 * @param {HTMLImageElement} image
 * @param {string} url
 */
function retryImage(image, url) {
  let tries = 0;
  image.addEventListener('error', () => {
    if (tries === MAX_IMAGE_TRIES) return image.remove();
    setTimeout(() => (image.src = url), IMAGE_PAUSE * 2 ** tries++);
  });
}

/**
 * Handles files that are dropped on the page or selected: a model and images it refers to.
 * @param {(file: File, beside: File[]) => void} open
 */
export function takeFiles(open) {
  const input = element('file', HTMLInputElement);
  const take = (/** @type {FileList | undefined | null} */ list) => {
    const files = [...(list ?? [])];
    const model = files.find(({ name }) => /\.glb$/i.test(name)) ?? files.find(({ name }) => isDocument(name)) ?? files[0];
    if (model) open(model, files);
  };
  for (const id of ['open', 'drop']) element(id, HTMLButtonElement).addEventListener('click', () => input.click());
  input.addEventListener('change', () => {
    take(input.files);
    // Allows the same file to be selected again.
    input.value = '';
  });
  const hasFile = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes('Files');
  const mark = (/** @type {boolean} */ isOver) => document.body.classList.toggle('is-over', isOver);
  window.addEventListener('dragover', (event) => {
    if (!hasFile(event)) return;
    event.preventDefault();
    mark(true);
  });
  window.addEventListener('dragleave', (event) => {
    if (event.relatedTarget === null) mark(false);
  });
  window.addEventListener('drop', (event) => {
    if (!hasFile(event)) return;
    event.preventDefault();
    mark(false);
    take(event.dataTransfer?.files);
  });
}
