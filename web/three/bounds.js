/**
 * Bounds for frustum culling and raycasting. An update extends them by the changed vertices only.
 * They never shrink, and always include the base mesh.
 * @module
 */
import { Sphere } from 'three';

/** @import { Box3, BufferGeometry, InstancedMesh, SkinnedMesh } from 'three' */

/**
 * Extends a box by vertices.
 * @param {Box3} box
 * @param {ArrayLike<number>} positions three coordinates per vertex
 * @param {ArrayLike<number>} [indices] the vertices to include; all by default
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
 * Sets the bounding sphere of a geometry from its box, as GLTFLoader does.
 * @param {BufferGeometry} geometry with a bounding box
 */
export function boundSphere(geometry) {
  geometry.boundingSphere ??= new Sphere();
  geometry.boundingBox?.getBoundingSphere(geometry.boundingSphere);
}

/**
 * Skinned meshes whose bounds already include a margin.
 * @type {WeakSet<object>}
 */
const grown = new WeakSet();

/**
 * Extends the bounds of a mesh that has its own, which three.js computes only once. The bounds of a
 * skinned mesh, in the pose of the first frame, grow by the maximum distance of future vertices
 * from the current mesh. The bounds of an instanced mesh are recomputed from its geometry when
 * needed.
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
