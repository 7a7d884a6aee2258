//! Reproducible random numbers for the tests that mutate files.

/// Returns a generator (xorshift, always with the same seed) of numbers below its argument.
pub(crate) fn random() -> impl FnMut(usize) -> usize {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 32) as usize % below
    }
}
