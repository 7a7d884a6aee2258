/**
 * Bounds for frustum culling and raycasting. They are grown by the vertices that change, so that an update takes no time for the others; they never
 * shrink, and include what the base mesh had.
 * @module
 */
import { Sphere } from 'three';

/** @import { Box3, BufferGeometry, InstancedMesh, SkinnedMesh } from 'three' */

/**
 * Grows a box by vertices.
 * @param {Box3} box
 * @param {ArrayLike<number>} positions three coordinates per vertex
 * @param {ArrayLike<number>} [indices] the vertices that count; all unless they are given
 */
export function growBox({ min, max }, positions, indices) {
  let { x: minX, y: minY, z: minZ } = min;
  let { x: maxX, y: maxY, z: maxZ } = max;
  const count = indices?.length ?? positions.length / 3;
  for (let i = 0; i < count; i++) {
    const at = 3 * (indices ? indices[i] : i);
    const x = positions[at];
    const y = positions[at + 1];
    const z = positions[at + 2];
    if (x < minX) minX = x;
    if (y < minY) minY = y;
    if (z < minZ) minZ = z;
    if (x > maxX) maxX = x;
    if (y > maxY) maxY = y;
    if (z > maxZ) maxZ = z;
  }
  min.set(minX, minY, minZ);
  max.set(maxX, maxY, maxZ);
}

/**
 * Sets the bounding sphere of a geometry to that of its box, as GLTFLoader does.
 * @param {BufferGeometry} geometry with a box
 */
export function boundSphere(geometry) {
  geometry.boundingSphere ??= new Sphere();
  geometry.boundingBox?.getBoundingSphere(geometry.boundingSphere);
}

/** The bounds of skinned meshes that include a margin already. @type {WeakSet<object>} */
const grown = new WeakSet();

/**
 * Grows the bounds of a mesh that has its own ones, which three.js computes once: those of a skinned mesh, in the pose of the first frame, by the distance that
 * vertices to come may have from the mesh as it is. Those of an instanced mesh are computed again from its geometry when they are needed.
 * @param {SkinnedMesh | InstancedMesh} mesh
 * @param {number} margin in mesh units
 */
export function growMeshBounds(mesh, margin) {
  if ('isInstancedMesh' in mesh) {
    mesh.boundingBox = mesh.boundingSphere = null;
    return;
  }
  const { boundingBox, boundingSphere } = mesh;
  if (boundingBox && !grown.has(boundingBox)) grown.add(boundingBox.expandByScalar(margin));
  if (boundingSphere && !grown.has(boundingSphere)) {
    boundingSphere.radius += margin;
    grown.add(boundingSphere);
  }
}
