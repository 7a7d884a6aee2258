//! Seeded random numbers, identical on every machine.
//!
//! # References
//! Steele, Lea, Flood: *Fast Splittable Pseudorandom Number Generators*, 2014 (`SplitMix64`).

/// A seeded generator of random numbers.
///
/// ```
/// let mut random = tristrip::random::Random::new(7);
/// assert!(random.below(6) < 6);
/// ```
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// Creates a generator from a seed.
    ///
    /// ```
    /// use tristrip::random::Random;
    /// let numbers = |seed| {
    ///     let mut random = Random::new(seed);
    ///     [(); 3].map(|()| random.below(1000))
    /// };
    /// assert_eq!(numbers(7), numbers(7));
    /// assert_ne!(numbers(7), numbers(8));
    /// ```
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the next 64 random bits.
    ///
    /// ```
    /// let mut random = tristrip::random::Random::new(1_234_567);
    /// assert_eq!(random.next_u64(), 6_457_827_717_110_365_317);
    /// assert_eq!(random.next_u64(), 3_203_168_211_198_807_973);
    /// ```
    #[inline]
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Returns a random number below `n`, or 0 if `n` is 0. The result is one of at most 2³² evenly
    /// spaced values.
    ///
    /// ```
    /// let mut random = tristrip::random::Random::new(7);
    /// let mut thrown = [0; 6];
    /// (0..6000).for_each(|_| thrown[random.below(6)] += 1);
    /// assert!(thrown.iter().all(|count| (900..1100).contains(count)));
    /// assert_eq!((random.below(0), random.below(1)), (0, 0));
    /// assert!(random.below(usize::MAX) < usize::MAX);
    /// ```
    #[inline]
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.next_u64() >> 32) * n as u128) >> 32) as usize
    }

    /// Returns `true` or `false` with equal probability.
    ///
    /// ```
    /// let mut random = tristrip::random::Random::new(7);
    /// let heads = (0..1000).filter(|_| random.coin()).count();
    /// assert!((450..550).contains(&heads));
    /// ```
    #[inline]
    pub fn coin(&mut self) -> bool {
        self.next_u64() >> 63 == 0
    }
}

/// Returns the probabilities of accepting cost increases of 1, 2, … at a temperature, in units of
/// 2⁻³². Uses only basic arithmetic, so results are identical on every machine.
#[expect(clippy::cast_sign_loss, reason = "odds are not negative")]
pub(crate) fn metropolis<const RISES: usize>(temperature: f64) -> [u32; RISES] {
    let x = 1.0 / (1024.0 * temperature);
    let mut once = 1.0 / (1.0 + x + x * x / 2.0);
    for _ in 0..10 {
        once *= once;
    }
    let mut odds = [0; RISES];
    let mut power = 1.0;
    for odds in &mut odds {
        power *= once;
        *odds = (power * f64::from(u32::MAX)) as u32;
    }
    odds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odds_are_those_of_metropolis() {
        for temperature in [0.06, 0.15, 0.5, 1.2, 9.0] {
            for (i, odds) in metropolis::<12>(temperature).into_iter().enumerate() {
                let exact = (-(i as f64 + 1.0) / temperature).exp();
                let found = f64::from(odds) / f64::from(u32::MAX);
                assert!((found - exact).abs() < 1e-4 * exact + 1e-9, "{temperature} {i}: {found} {exact}");
            }
        }
    }
}
