/**
 * glTF materials as values for the shader.
 * @module
 */

/**
 * @typedef {object} Material
 * @property {number[]} baseColor
 * @property {number[]} emissive
 * @property {'OPAQUE' | 'MASK' | 'BLEND'} alphaMode
 * @property {number} cutoff
 * @property {boolean} isDoubleSided
 * @property {boolean} isUnlit
 * @property {number[]} factors metallic, roughness, normal scale, occlusion strength
 * @property {(number | undefined)[]} textures in the order of `TEXTURES`
 * @property {number[]} uvSets the texture coordinate set of each texture
 * @property {number[]} uvMatrices the 3 × 3 texture coordinate transform of each texture
 */

/** The textures of a material by sampler name. Colours are stored as sRGB. */
export const TEXTURES = ['baseTexture', 'metalTexture', 'normalTexture', 'occlusionTexture', 'emissiveTexture'];
export const COLOR_TEXTURES = [true, false, false, false, true];

/**
 * Returns the texture coordinate set and transform of a texture.
 * @param {any} info
 * @returns {{ set: number, matrix: number[] }}
 */
function readCoordinates(info) {
  const { offset: [x, y] = [0, 0], rotation = 0, scale: [u, v] = [1, 1], texCoord = info?.texCoord ?? 0 } = info?.extensions?.KHR_texture_transform ?? {};
  const [s, c] = [Math.sin(rotation), Math.cos(rotation)];
  return { set: texCoord, matrix: [c * u, -s * u, 0, s * v, c * v, 0, x, y, 1] };
}

/**
 * Returns a material. A missing material becomes matt plastic, instead of the metal that is glTF's
 * default.
 * @param {any} [material]
 * @returns {Material}
 */
export function readMaterial(material = { doubleSided: true }) {
  const { pbrMetallicRoughness: pbr = { metallicFactor: 0, roughnessFactor: 0.6, baseColorFactor: [0.53, 0.53, 0.55, 1] }, normalTexture, occlusionTexture, emissiveTexture, extensions } = material;
  const strength = extensions?.KHR_materials_emissive_strength?.emissiveStrength ?? 1;
  const infos = [pbr.baseColorTexture, pbr.metallicRoughnessTexture, normalTexture, occlusionTexture, emissiveTexture];
  const coordinates = infos.map(readCoordinates);
  return {
    baseColor: pbr.baseColorFactor ?? [1, 1, 1, 1],
    emissive: (material.emissiveFactor ?? [0, 0, 0]).map((/** @type {number} */ x) => x * strength),
    alphaMode: material.alphaMode ?? 'OPAQUE',
    cutoff: material.alphaCutoff ?? 0.5,
    isDoubleSided: material.doubleSided ?? false,
    isUnlit: Boolean(extensions?.KHR_materials_unlit),
    factors: [pbr.metallicFactor ?? 1, pbr.roughnessFactor ?? 1, normalTexture?.scale ?? 1, occlusionTexture?.strength ?? 1],
    textures: infos.map((info) => info?.index),
    uvSets: coordinates.map(({ set }) => set),
    uvMatrices: coordinates.flatMap(({ matrix }) => matrix),
  };
}
