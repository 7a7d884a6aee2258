//! The treatment of normals, as users select it, and the number of parts per treatment.

use std::fmt;
use std::str::FromStr;

/// The treatment of the normals of simplified parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Normals {
    /// Rebuild the normals of flat-shaded parts; keep all others where they still fit the faces.
    #[default]
    Auto,
    /// Keep the normals of vertices. Vertices on normal seams collapse only along the seam.
    Keep,
    /// Rebuild all normals from the faces: flat, or smooth up to the crease angle of the hard edges
    /// of the part.
    Rebuild,
}

impl Normals {
    /// All values, in the order of the help.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Keep, Self::Rebuild];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Keep => "keep",
            Self::Rebuild => "rebuild",
        }
    }

    /// Returns a one-line help text.
    ///
    /// ```
    /// assert!(tristrip_pipeline::simplify::Normals::Auto.summary().contains("flat-shaded"));
    /// ```
    pub fn summary(self) -> &'static str {
        match self {
            Self::Auto => {
                "Rebuild those of flat-shaded parts; keep all others where they still fit the faces"
            }
            Self::Keep => {
                "Keep the normals of the vertices; edges at which they differ collapse only along themselves"
            }
            Self::Rebuild => {
                "Rebuild all: flat, or smooth up to the crease angle that the hard edges of a part show"
            }
        }
    }
}

impl fmt::Display for Normals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Parses a name.
///
/// ```
/// use tristrip_pipeline::simplify::Normals;
/// assert!(Normals::ALL.iter().all(|normals| normals.to_string().parse() == Ok(*normals)));
/// assert!("smooth".parse::<Normals>().is_err());
/// ```
impl FromStr for Normals {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|normals| normals.name() == text);
        found.ok_or_else(|| format!("found `{text}`, expected auto, keep or rebuild"))
    }
}

/// The number of parts per treatment of their normals. Parts without normals are not counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PartNormals {
    /// The number of parts that kept their normals.
    pub kept: usize,
    /// The number of parts that kept their normals except where these no longer fitted the faces.
    pub repaired: usize,
    /// The number of flat-shaded parts: each corner has the normal of its remaining face.
    pub flat: usize,
    /// The number of parts with new normals that are smooth up to a crease angle.
    pub creased: usize,
}
