//! Converts slices of numbers to little-endian bytes. The loops have no capacity checks, so they
//! compile to copies.

/// Appends numbers.
pub(crate) fn append<T: Copy, const N: usize>(out: &mut Vec<u8>, values: &[T], bytes: impl Fn(T) -> [u8; N]) {
    let start = out.len();
    out.resize(start + N * values.len(), 0);
    for (slot, &value) in out[start..].as_chunks_mut::<N>().0.iter_mut().zip(values) {
        *slot = bytes(value);
    }
}

/// Writes numbers into rows of `stride` bytes: `per_row` numbers per row, from byte `offset` of the
/// row on.
pub(crate) fn fill_rows<T: Copy, const N: usize>(
    rows: &mut [u8],
    stride: usize,
    offset: usize,
    values: &[T],
    per_row: usize,
    bytes: impl Fn(T) -> [u8; N],
) {
    for (row, values) in rows.chunks_exact_mut(stride).zip(values.chunks_exact(per_row)) {
        for (slot, &value) in row[offset..].as_chunks_mut::<N>().0.iter_mut().zip(values) {
            *slot = bytes(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_appended_and_filled_into_rows() {
        let mut out = vec![9];
        append(&mut out, &[1_u16, 0x203], u16::to_le_bytes);
        assert_eq!(out, [9, 1, 0, 3, 2]);
        let mut rows = vec![0; 12];
        fill_rows(&mut rows, 6, 1, &[1_u16, 2, 3, 4], 2, u16::to_le_bytes);
        assert_eq!(rows, [0, 1, 0, 2, 0, 0, 0, 3, 0, 4, 0, 0]);
    }
}
