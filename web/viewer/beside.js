/**
 * The files beside a model: images that its document refers to by name. Nothing else is asked for, and nothing from elsewhere.
 * @module
 */

/**
 * Finds a file by the URI that a document has for it.
 * @typedef {(uri: string) => Promise<Blob>} FindFile
 */

const MAX_BYTES = 2 ** 26;

/**
 * Returns what finds files in the folder of a model of this site, and in folders inside it.
 * @param {string} model its URL
 * @returns {FindFile}
 */
export function besideUrl(model) {
  const folder = new URL('.', new URL(model, location.href));
  return async (uri) => {
    const address = new URL(uri, folder);
    if (address.origin !== location.origin || !address.href.startsWith(folder.href)) throw new Error('It is not beside the model.');
    const response = await fetch(address, { redirect: 'error' });
    if (!response.ok || Number(response.headers.get('Content-Length')) > MAX_BYTES) {
      await response.body?.cancel();
      throw new Error(`The server answers ${response.status}, or the file is too large.`);
    }
    return response.blob();
  };
}

/**
 * Returns what finds files among those that were chosen together with a model.
 * @param {File[]} files
 * @returns {FindFile}
 */
export function besideFile(files) {
  const known = new Map(files.map((file) => [file.name, file]));
  return async (uri) => {
    const found = known.get(nameOfUri(uri).split('/').pop() ?? '');
    if (!found) throw new Error('It was not chosen.');
    return found;
  };
}

/**
 * Returns how people write a URI.
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
 * Whether a name is that of a glTF document, which is no GLB.
 * @param {string} name
 */
export const isDocument = (name) => /\.gltf$/i.test(name);
