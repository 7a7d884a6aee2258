/**
 * Files next to a model: images that its document refers to. Loads nothing else, and nothing from
 * other directories or sites.
 * @module
 */

/**
 * Finds a file by its URI in a document.
 * @typedef {(uri: string) => Promise<Blob>} FindFile
 */

const MAX_BYTES = 2 ** 26;

/**
 * Returns a function that finds files in the directory of a model of this site, or below it.
 * @param {string} model URL of the model
 * @returns {FindFile}
 */
export function besideUrl(model) {
  const folder = new URL('.', new URL(model, location.href));
  return async (uri) => {
    const address = new URL(uri, folder);
    if (address.origin !== location.origin || !address.href.startsWith(folder.href)) throw new Error('It is not in the directory of the model.');
    const response = await fetch(address, { redirect: 'error' });
    if (!response.ok || Number(response.headers.get('Content-Length')) > MAX_BYTES) {
      await response.body?.cancel();
      throw new Error(`The server responded with ${response.status}, or the file is too large.`);
    }
    return response.blob();
  };
}

/**
 * Returns a function that finds files among those selected together with a model.
 * @param {File[]} files
 * @returns {FindFile}
 */
export function besideFile(files) {
  const known = new Map(files.map((file) => [file.name, file]));
  return async (uri) => {
    const found = known.get(nameOfUri(uri).split('/').pop() ?? '');
    if (!found) throw new Error('It was not selected.');
    return found;
  };
}

/**
 * Returns a URI in readable form.
 * @param {string} uri
 */
export function nameOfUri(uri) {
  try {
    return decodeURIComponent(uri);
  } catch {
    return uri;
  }
}

/**
 * Whether a name is that of a .gltf document instead of a GLB.
 * @param {string} name
 */
export const isDocument = (name) => /\.gltf$/i.test(name);
