//! Filters that turn the strips of a level into display strips.

use std::fmt;
use std::str::FromStr;

use tristrip::lod::Filter;

/// A filter for display strips. It either scans each strip separately, or repairs paths as the
/// level changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum DisplayFilter {
    /// Draws the renamed strips unchanged, degenerate triangles included.
    None,
    /// The simple triangle strip scanner of El-Sana et al. 2000.
    Stss,
    /// The degenerate-triangle-free scanner of Kim et al. 2005.
    Dtfs,
    /// Drops degenerate triangles and keeps the order of the others, at the minimum cost for this
    /// order.
    Linked,
    /// Maintains paths over the triangles of the level, and repairs them by local search where
    /// collapses break them.
    #[default]
    Repair,
}

impl DisplayFilter {
    /// All filters, in the order in which reports list them.
    pub const ALL: [Self; 5] = [Self::None, Self::Stss, Self::Dtfs, Self::Linked, Self::Repair];

    /// Returns the name in reports and on the command line.
    pub fn name(self) -> &'static str {
        self.scanner().map_or("repair", Filter::name)
    }

    /// Returns a one-line description, for the command's help.
    ///
    /// ```
    /// use tristrip_pipeline::levels::DisplayFilter;
    /// assert!(DisplayFilter::Dtfs.summary().ends_with("(Kim et al. 2005)"));
    /// ```
    pub fn summary(self) -> &'static str {
        let repair = "Keep paths over the triangles of the level, and repair them by a local search where collapses cut them";
        self.scanner().map_or(repair, Filter::summary)
    }

    /// Returns the filter that scans each strip separately; `None` for [`DisplayFilter::Repair`].
    pub fn scanner(self) -> Option<Filter> {
        match self {
            Self::None => Some(Filter::None),
            Self::Stss => Some(Filter::Stss),
            Self::Dtfs => Some(Filter::Dtfs),
            Self::Linked => Some(Filter::Linked),
            Self::Repair => None,
        }
    }
}

impl fmt::Display for DisplayFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Parses the name of a filter.
///
/// ```
/// use tristrip_pipeline::levels::DisplayFilter;
/// assert_eq!("dtfs".parse(), Ok(DisplayFilter::Dtfs));
/// assert!(DisplayFilter::ALL.iter().all(|filter| filter.to_string().parse() == Ok(*filter)));
/// ```
impl FromStr for DisplayFilter {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|filter| filter.name() == text);
        found.ok_or_else(|| format!("found `{text}`, expected none, stss, dtfs, linked or repair"))
    }
}
