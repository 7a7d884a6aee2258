/**
 * 4 × 4 matrices in column-major order, as in WebGL, and 3-component vectors.
 * @module
 */

/** @typedef {number[]} Matrix 16 numbers, column after column */
/** @typedef {number[]} Vector three numbers */

/** @returns {Matrix} */
export const identity = () => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/**
 * Returns the product a b, which applies `b` first.
 * @param {Matrix} a
 * @param {Matrix} b
 * @returns {Matrix}
 */
export function multiply(a, b) {
  const product = new Array(16);
  for (let column = 0; column < 16; column += 4) {
    for (let row = 0; row < 4; row++) {
      product[column + row] =
        a[row] * b[column] + a[4 + row] * b[column + 1] + a[8 + row] * b[column + 2] + a[12 + row] * b[column + 3];
    }
  }
  return product;
}

/**
 * Returns the matrix that scales, then rotates, then translates.
 * @param {number[]} t
 * @param {number[]} q a quaternion, x, y, z, w
 * @param {number[]} s
 * @returns {Matrix}
 */
export function compose(t, [x, y, z, w], s) {
  return [
    (1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y + z * w) * s[0], 2 * (x * z - y * w) * s[0], 0,
    2 * (x * y - z * w) * s[1], (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z + x * w) * s[1], 0,
    2 * (x * z + y * w) * s[2], 2 * (y * z - x * w) * s[2], (1 - 2 * (x * x + y * y)) * s[2], 0,
    t[0], t[1], t[2], 1,
  ];
}

/**
 * Returns a transformed point.
 * @param {Matrix} m
 * @param {ArrayLike<number>} p
 * @returns {Vector}
 */
export function transformPoint(m, p) {
  return [0, 1, 2].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);
}

/**
 * Returns the axis-aligned box around a transformed box.
 * @param {Matrix} m
 * @param {{ min: Vector, max: Vector }} box
 */
export function transformBox(m, { min, max }) {
  const least = m.slice(12, 15);
  const most = m.slice(12, 15);
  for (let row = 0; row < 3; row++) {
    for (let i = 0; i < 3; i++) {
      const a = m[4 * i + row] * min[i];
      const b = m[4 * i + row] * max[i];
      least[row] += Math.min(a, b);
      most[row] += Math.max(a, b);
    }
  }
  return { min: least, max: most };
}

/**
 * Returns the cofactors of the upper-left 3 × 3 matrix. They transform normals, up to a scale, and
 * mirror them if the matrix mirrors.
 * @param {Matrix} m
 */
export function cofactors(m) {
  return [
    m[5] * m[10] - m[6] * m[9], m[6] * m[8] - m[4] * m[10], m[4] * m[9] - m[5] * m[8],
    m[2] * m[9] - m[1] * m[10], m[0] * m[10] - m[2] * m[8], m[1] * m[8] - m[0] * m[9],
    m[1] * m[6] - m[2] * m[5], m[2] * m[4] - m[0] * m[6], m[0] * m[5] - m[1] * m[4],
  ];
}

/**
 * Returns the determinant of the upper-left 3 × 3 matrix; it is negative if the matrix mirrors.
 * @param {Matrix} m
 */
export function determinant(m) {
  const c = cofactors(m);
  return m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
}

/**
 * Returns a perspective projection.
 * @param {number} height of the view at distance 1
 * @param {number} aspect width by height
 * @param {number} near
 * @param {number} far
 * @returns {Matrix}
 */
export function perspective(height, aspect, near, far) {
  const f = 2 / height;
  const depth = 1 / (near - far);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) * depth, -1, 0, 0, 2 * near * far * depth, 0];
}

/**
 * Returns the view matrix of a camera with the axes `right`, `up` and `back`.
 * @param {Vector[]} axes
 * @param {Vector} eye
 * @returns {Matrix}
 */
export function view([r, u, b], eye) {
  return [r[0], u[0], b[0], 0, r[1], u[1], b[1], 0, r[2], u[2], b[2], 0, -dot(r, eye), -dot(u, eye), -dot(b, eye), 1];
}

/**
 * @param {ArrayLike<number>} a
 * @param {ArrayLike<number>} b
 */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
