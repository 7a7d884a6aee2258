/**
 * Resources of a loaded scene that need explicit disposal: GPU buffers, textures and decoded
 * images.
 * @module
 */

/**
 * @import { BufferGeometry, Material, Mesh, Object3D, Skeleton, SkinnedMesh, Texture } from 'three'
 * @import { GLTF } from 'three/addons/loaders/GLTFLoader.js'
 */

/**
 * The resources of a scene, collected when it is loaded. Resources that a page adds later remain
 * the page's responsibility.
 */
export class Resources {
  /** @type {Set<BufferGeometry>} */
  geometries = new Set();
  /** @type {Set<Material>} */
  materials = new Set();
  /** @type {Set<Skeleton>} */
  skeletons = new Set();
  #gltf;

  /** @param {GLTF} gltf */
  constructor(gltf) {
    this.#gltf = gltf;
    for (const scene of gltf.scenes) scene.traverse((object) => this.#collect(object));
  }

  /** @param {Object3D} object */
  #collect(object) {
    const { geometry, material, skeleton } = /** @type {Partial<Mesh & SkinnedMesh>} */ (object);
    if (geometry) this.geometries.add(geometry);
    if (skeleton) this.skeletons.add(skeleton);
    for (const one of [material].flat()) if (one) this.materials.add(one);
  }

  /** Frees all resources, and removes the scenes from their parents. */
  dispose() {
    const { scenes, parser } = this.#gltf;
    for (const scene of scenes) scene.removeFromParent();
    /** @type {Set<Texture>} */
    const textures = new Set();
    // Materials of variants are loaded later; the parser knows them.
    for (const object of parser.associations.keys()) {
      if (/** @type {Partial<Material>} */ (object).isMaterial) this.materials.add(/** @type {Material} */ (object));
      if (/** @type {Partial<Texture>} */ (object).isTexture) textures.add(/** @type {Texture} */ (object));
    }
    for (const material of this.materials) {
      for (const value of Object.values(material)) if (value?.isTexture) textures.add(value);
      material.dispose();
    }
    for (const texture of textures) {
      texture.dispose();
      const image = /** @type {unknown} */ (texture.source.data);
      if (typeof ImageBitmap !== 'undefined' && image instanceof ImageBitmap) image.close();
    }
    for (const geometry of this.geometries) geometry.dispose();
    for (const skeleton of this.skeletons) skeleton.dispose();
    // InstancedMesh and similar objects have their own buffers.
    for (const scene of scenes) scene.traverse((object) => /** @type {{ dispose?: () => void }} */ (object).dispose?.());
  }
}
