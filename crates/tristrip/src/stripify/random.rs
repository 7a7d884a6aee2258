//! Random numbers from a seed: the same on any machine.
//!
//! # References
//! Steele, Lea, Flood: *Fast Splittable Pseudorandom Number Generators*, 2014 (`SplitMix64`).

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// Creates a stream.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the next number.
    #[inline]
    #[expect(clippy::should_implement_trait, reason = "an endless stream")]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number below `n`, which must be at most 2³².
    #[inline]
    pub fn below(&mut self, n: usize) -> usize {
        (((self.next() >> 32) * n as u64) >> 32) as usize
    }

    /// True or false, each half the time.
    #[inline]
    pub fn coin(&mut self) -> bool {
        self.next() >> 63 == 0
    }
}

/// Gives the odds of accepting rises of 1, 2, … at a temperature, in 2³²ths. Made of multiplications alone, so that it is
/// the same on every machine.
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
