//! Reproducible random numbers for the tests that mutate files.

/// Returns a generator, always with the same seed, of numbers below its argument.
pub(crate) fn random() -> impl FnMut(usize) -> usize {
    let mut random = tristrip::random::Random::new(1);
    move |below: usize| random.below(below)
}
