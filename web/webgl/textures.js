/**
 * Textures of a model. Images are decoded asynchronously, and large ones are uploaded in bands over
 * several frames. A texture is used when it is complete.
 * @module
 */

const MAX_SIZE = 4096;
const BAND_PIXELS = 2 ** 19;
const TYPES = [/^image\/png$/, /^image\/jpeg$/, /^image\/webp$/];

const DATA = /^data:([\w/+.-]+);base64,/;

/**
 * Returns the bytes of a data URI, or `undefined` for other URIs.
 * @param {string} uri
 */
function dataOf(uri) {
  const [start, type] = DATA.exec(uri) ?? [];
  return type === undefined ? undefined : new Blob([Uint8Array.from(atob(uri.slice(start?.length)), (char) => char.charCodeAt(0))], { type });
}

const nextFrame = () => new Promise((done) => requestAnimationFrame(done));

/** The textures of a model. */
export class Textures {
  #gl;
  #onchange;
  #find;
  /**
   * The requested images in other files.
   * @type {Set<number>}
   */
  #asked = new Set();
  /** @type {Map<string, WebGLTexture | null>} */
  #textures = new Map();
  /** @type {Map<number, Blob>} */
  #images = new Map();
  #json;
  #isReleased = false;
  /** The number of images being loaded or decoded. */
  #pending = 0;
  /** The number of context losses. Textures from before a loss are invalid. */
  #losses = 0;

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {any} json
   * @param {() => void} onchange called when a texture is complete
   * @param {(uri: string) => Promise<Blob>} find finds an image in another file
   */
  constructor(gl, json, onchange, find) {
    this.#gl = gl;
    this.#json = json;
    this.#onchange = onchange;
    this.#find = find;
  }

  /** Whether images are being loaded or decoded. */
  get isBusy() {
    return this.#pending > 0;
  }

  /**
   * Adds an image that has arrived.
   * @param {number} image its index
   * @param {Blob | Uint8Array} bytes
   */
  add(image, bytes) {
    const type = this.#json.images[image].mimeType ?? ('type' in bytes ? bytes.type : '');
    if (TYPES.some((known) => known.test(type))) this.#images.set(image, new Blob([bytes instanceof Blob ? bytes : bytes.slice()], { type }));
  }

  /**
   * Requests an image in another file or a data URI, once.
   * @param {number} image its index
   */
  async #ask(image) {
    const uri = this.#json.images?.[image]?.uri;
    if (typeof uri !== 'string' || this.#asked.has(image)) return;
    this.#asked.add(image);
    this.#pending++;
    try {
      const blob = dataOf(uri) ?? (await this.#find(uri));
      if (this.#isReleased) return;
      this.add(image, blob);
      this.#onchange();
    } catch {
      // The model is drawn without the image. `find` reports missing files.
    } finally {
      this.#pending--;
    }
  }

  /**
   * Returns a texture if it is complete. Otherwise starts creating it, if its image is available.
   * @param {number} texture its index
   * @param {boolean} isColor
   */
  get(texture, isColor) {
    const key = `${texture} ${isColor}`;
    const known = this.#textures.get(key);
    if (known !== undefined) return known;
    const { source, sampler, extensions } = this.#json.textures?.[texture] ?? {};
    const image = extensions?.EXT_texture_webp?.source ?? source;
    const blob = this.#images.get(image);
    if (!blob) {
      this.#ask(image);
      return null;
    }
    this.#textures.set(key, null);
    this.#pending++;
    const losses = this.#losses;
    // The model is drawn without an image that cannot be decoded.
    this.#make(blob, isColor, this.#json.samplers?.[sampler] ?? {}).then(
      (made) => {
        if (!made || losses !== this.#losses) return;
        if (this.#isReleased) return this.#gl.deleteTexture(made);
        this.#textures.set(key, made);
        this.#onchange();
      },
      () => {},
    ).finally(() => this.#pending--);
    return null;
  }

  /**
   * Creates a texture; `null` if the context is lost in the meantime.
   * @param {Blob} blob
   * @param {boolean} isColor
   * @param {any} sampler
   */
  async #make(blob, isColor, { magFilter = 9729, minFilter = 9987, wrapS = 10497, wrapT = 10497 }) {
    const gl = this.#gl;
    const plain = /** @type {ImageBitmapOptions} */ ({ premultiplyAlpha: 'none', colorSpaceConversion: 'none' });
    let bitmap = await createImageBitmap(blob, plain);
    const scale = Math.min(1, MAX_SIZE / Math.max(bitmap.width, bitmap.height));
    if (scale < 1) {
      const large = bitmap;
      bitmap = await createImageBitmap(large, { ...plain, resizeWidth: Math.ceil(large.width * scale), resizeHeight: Math.ceil(large.height * scale) });
      large.close();
    }
    const { width, height } = bitmap;
    const losses = this.#losses;
    const texture = gl.createTexture();
    const bind = () => gl.bindTexture(gl.TEXTURE_2D, texture);
    bind();
    gl.texStorage2D(gl.TEXTURE_2D, Math.floor(Math.log2(Math.max(width, height))) + 1, isColor ? gl.SRGB8_ALPHA8 : gl.RGBA8, width, height);
    const rows = Math.max(1, Math.floor(BAND_PIXELS / width));
    for (let y = 0; y < height && !this.#isReleased; y += rows) {
      const band = rows < height ? await createImageBitmap(bitmap, 0, y, width, Math.min(rows, height - y), plain) : bitmap;
      await nextFrame();
      if (losses !== this.#losses) {
        band.close();
        bitmap.close();
        return null;
      }
      bind();
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, y, gl.RGBA, gl.UNSIGNED_BYTE, band);
      band.close();
    }
    bitmap.close();
    bind();
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, magFilter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, minFilter === 9729 || minFilter === 9728 ? minFilter : 9987);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, wrapS);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, wrapT);
    const anisotropic = gl.getExtension('EXT_texture_filter_anisotropic');
    if (anisotropic) gl.texParameterf(gl.TEXTURE_2D, anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, 4);
    return texture;
  }

  /** Deletes all textures. */
  release() {
    this.#isReleased = true;
    for (const texture of this.#textures.values()) this.#gl.deleteTexture(texture);
    this.#textures.clear();
    this.#images.clear();
  }

  /** Drops the textures of a lost context; they are created again. */
  forget() {
    this.#losses++;
    this.#textures.clear();
  }
}
