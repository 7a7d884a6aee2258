/**
 * Access to the elements of the page, and formatting of numbers.
 * @module
 */

/**
 * Returns an element of the page.
 * @template {Element} T
 * @param {string} id
 * @param {new () => T} Type
 * @returns {T}
 */
export function element(id, Type) {
  const found = document.getElementById(id);
  if (!(found instanceof Type)) throw new Error(`The page has no ${id}.`);
  return found;
}

/**
 * Returns a new element.
 * @param {string} tag
 * @param {Record<string, string>} attributes
 * @param {...(Node | string)} children
 */
export function make(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/**
 * Sets a text if it differs. Setting the same text again would make screen readers repeat it.
 * @param {Element} target
 * @param {string} text
 */
export function setText(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

const NUMBER = new Intl.NumberFormat('en');

/** @param {number} n */
export const countText = (n) => NUMBER.format(n);

/** @param {number} n */
export function bytesText(n) {
  if (n < 1000) return `${n}\u00a0B`;
  const [value, unit] = n < 999500 ? [n / 1e3, 'kB'] : [n / 1e6, 'MB'];
  return `${value < 10 || (value < 100 && unit === 'MB') ? value.toFixed(1) : Math.round(value)}\u00a0${unit}`;
}

/**
 * Formats an error.
 * @param {number} fraction of the mesh size
 */
export const errorText = (fraction) => `${Number((100 * fraction).toPrecision(2))}\u00a0% of size`;

/** @param {number} milliseconds */
export const timeText = (milliseconds) => (milliseconds < 1000 ? `${Math.round(milliseconds)} ms` : `${(milliseconds / 1000).toFixed(1)} s`);
