//! The effort of a search. Levels limit steps, not time, so results are identical on every machine.

/// The effort of a search, from 0 to 9. A level limits steps, not time, so results are identical on
/// every machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Effort(u8);

impl Effort {
    /// The highest level, with the longest search.
    pub const MAX: Self = Self(9);

    /// Creates a level from 0 to 9, or returns `None` for larger values.
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

/// Level 5: about a second per 100,000 triangles.
impl Default for Effort {
    fn default() -> Self {
        Self(5)
    }
}
