//! The effort of a search: levels that count steps, never seconds, so that the result is the same
//! on any machine.

/// The effort of a search, from 0 to 9. It counts steps, never seconds, so that the result is the
/// same on any machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Effort(u8);

impl Effort {
    /// The level of the longest search.
    pub const MAX: Self = Self(9);

    /// Creates a level from 0 to 9; returns `None` for larger values.
    ///
    /// ```
    /// use tristrip::Effort;
    /// assert_eq!(Effort::new(9), Some(Effort::MAX));
    /// assert_eq!(Effort::new(10), None);
    /// ```
    pub const fn new(level: u8) -> Option<Self> {
        if level <= Self::MAX.0 { Some(Self(level)) } else { None }
    }

    /// Returns the level.
    ///
    /// ```
    /// use tristrip::Effort;
    /// assert_eq!((Effort::default().level(), Effort::MAX.level()), (5, 9));
    /// ```
    pub const fn level(self) -> u8 {
        self.0
    }
}

/// About a second per 100,000 triangles.
impl Default for Effort {
    fn default() -> Self {
        Self(5)
    }
}
