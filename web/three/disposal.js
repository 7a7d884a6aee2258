/**
 * What a loaded scene holds beside JavaScript objects: GPU buffers and textures, and decoded images.
 * @module
 */

/**
 * @import { BufferGeometry, Material, Mesh, Object3D, Skeleton, SkinnedMesh, Texture } from 'three'
 * @import { GLTF } from 'three/addons/loaders/GLTFLoader.js'
 */

/** What a scene uses. It is collected when the scene is loaded, so that what a page adds to it stays the page's. */
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

  /** Frees all, and takes the scenes out of those that they are in. */
  dispose() {
    const { scenes, parser } = this.#gltf;
    for (const scene of scenes) scene.removeFromParent();
    /** @type {Set<Texture>} */
    const textures = new Set();
    // Materials of variants, which are loaded later, are known to the parser.
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
    // InstancedMesh and the like have buffers of their own.
    for (const scene of scenes) scene.traverse((object) => /** @type {{ dispose?: () => void }} */ (object).dispose?.());
  }
}
