/**
 * Returns triangles rotated to their lowest vertex and sorted, without degenerate ones.
 * @param {Iterable<ArrayLike<number>>} triangles
 */
export function canonical(triangles) {
  const rows = [];
  for (const { 0: a, 1: b, 2: c } of triangles) {
    if (a === b || b === c || a === c) continue;
    const least = Math.min(a, b, c);
    rows.push(least === a ? `${a} ${b} ${c}` : least === b ? `${b} ${c} ${a}` : `${c} ${a} ${b}`);
  }
  return rows.sort();
}

/**
 * Returns the triangles that a GPU draws for strips with restarts.
 * @param {Uint16Array | Uint32Array} indices
 */
export function* drawnByStrips(indices) {
  const restart = indices instanceof Uint16Array ? 65535 : 4294967295;
  let start = 0;
  for (let i = 0; i < indices.length; i++) {
    if (indices[i] === restart) start = i + 1;
    else if (i >= start + 2) yield (i - start) % 2 ? [indices[i - 1], indices[i - 2], indices[i]] : [indices[i - 2], indices[i - 1], indices[i]];
  }
}

/** @param {ArrayLike<number>} list */
export function* triples(list) {
  for (let i = 0; i < list.length; i += 3) yield [list[i], list[i + 1], list[i + 2]];
}
