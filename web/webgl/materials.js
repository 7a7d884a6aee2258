/**
 * Materials of glTF as numbers for the shader.
 * @module
 */

/**
 * A texture, and where its coordinates come from.
 * @typedef {object} TextureUse
 * @property {number} texture
 * @property {number} set of texture coordinates
 * @property {number[]} matrix 3 × 3, applied to the coordinates
 */

/**
 * @typedef {object} Material
 * @property {number[]} baseColor
 * @property {number} metallic
 * @property {number} roughness
 * @property {number[]} emissive
 * @property {'OPAQUE' | 'MASK' | 'BLEND'} alphaMode
 * @property {number} cutoff
 * @property {boolean} isDoubleSided
 * @property {boolean} isUnlit
 * @property {number} normalScale
 * @property {number} occlusion its strength
 * @property {(TextureUse | undefined)[]} textures in the order of `TEXTURES`
 */

/** The textures of a material, as shaders name them. Colours are stored as sRGB. */
export const TEXTURES = ['baseTexture', 'metalTexture', 'normalTexture', 'occlusionTexture', 'emissiveTexture'];
export const COLOR_TEXTURES = [true, false, false, false, true];

/**
 * @param {any} info
 * @returns {TextureUse | undefined}
 */
function textureUse(info) {
  if (info?.index === undefined) return undefined;
  const { offset: [x, y] = [0, 0], rotation = 0, scale: [u, v] = [1, 1], texCoord = info.texCoord ?? 0 } = info.extensions?.KHR_texture_transform ?? {};
  const [s, c] = [Math.sin(rotation), Math.cos(rotation)];
  return { texture: info.index, set: texCoord, matrix: [c * u, -s * u, 0, s * v, c * v, 0, x, y, 1] };
}

/**
 * Returns a material. One that says nothing of its surface is a matt plastic, not the metal that glTF takes it for.
 * @param {any} [material]
 * @returns {Material}
 */
export function readMaterial(material = { doubleSided: true }) {
  const { pbrMetallicRoughness: pbr = { metallicFactor: 0, roughnessFactor: 0.6, baseColorFactor: [0.53, 0.53, 0.55, 1] }, normalTexture, occlusionTexture, emissiveTexture, extensions } = material;
  const strength = extensions?.KHR_materials_emissive_strength?.emissiveStrength ?? 1;
  return {
    baseColor: pbr.baseColorFactor ?? [1, 1, 1, 1],
    metallic: pbr.metallicFactor ?? 1,
    roughness: pbr.roughnessFactor ?? 1,
    emissive: (material.emissiveFactor ?? [0, 0, 0]).map((/** @type {number} */ x) => x * strength),
    alphaMode: material.alphaMode ?? 'OPAQUE',
    cutoff: material.alphaCutoff ?? 0.5,
    isDoubleSided: material.doubleSided ?? false,
    isUnlit: Boolean(extensions?.KHR_materials_unlit),
    normalScale: normalTexture?.scale ?? 1,
    occlusion: occlusionTexture?.strength ?? 1,
    textures: [pbr.baseColorTexture, pbr.metallicRoughnessTexture, normalTexture, occlusionTexture, emissiveTexture].map(textureUse),
  };
}
