/**
 * Names of vertex attributes in three.js.
 * @module
 */

/** @type {Record<string, string>} */
const NAMES = {
  POSITION: 'position',
  NORMAL: 'normal',
  TANGENT: 'tangent',
  TEXCOORD_0: 'uv',
  TEXCOORD_1: 'uv1',
  TEXCOORD_2: 'uv2',
  TEXCOORD_3: 'uv3',
  COLOR_0: 'color',
  WEIGHTS_0: 'skinWeight',
  JOINTS_0: 'skinIndex',
};

/**
 * Returns the name that GLTFLoader gives to a glTF attribute.
 * @param {string} name the name in the document, such as `TEXCOORD_0` or `_CUSTOM`
 */
export function threeName(name) {
  return NAMES[name] ?? name.toLowerCase();
}
