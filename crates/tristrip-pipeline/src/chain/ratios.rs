//! Parses the levels of a chain, such as `100%,50%,25%,10%`.

use std::fmt;
use std::str::FromStr;

use crate::goal::Ratio;

/// The maximum number of levels. Each level adds nodes, meshes and indices to a scene.
const MAX_LEVELS: usize = 16;

/// The ratios of triangles that the levels of a chain keep, in strictly decreasing order.
///
/// ```
/// use tristrip_pipeline::chain::ChainRatios;
/// let ratios: ChainRatios = "100%,50%,0.1".parse()?;
/// assert_eq!(ratios.as_slice().iter().map(|ratio| ratio.of(500)).collect::<Vec<_>>(), [500, 250, 50]);
/// assert!("50%,50%".parse::<ChainRatios>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ChainRatios(Vec<Ratio>);

impl ChainRatios {
    /// Returns the ratios. There is at least one.
    pub fn as_slice(&self) -> &[Ratio] {
        &self.0
    }

    /// Returns the ratio of the coarsest level.
    pub(crate) fn last(&self) -> Ratio {
        self.0.last().copied().unwrap_or(Ratio::ZERO)
    }
}

/// The full mesh, a half, a quarter and a tenth.
impl Default for ChainRatios {
    fn default() -> Self {
        Self([1.0, 0.5, 0.25, 0.1].into_iter().filter_map(Ratio::new).collect())
    }
}

impl fmt::Display for ChainRatios {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent: Vec<String> = self.0.iter().map(|ratio| format!("{}%", ratio.value() * 100.0)).collect();
        f.write_str(&percent.join(","))
    }
}

impl FromStr for ChainRatios {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ratios = text.split(',').map(str::parse).collect::<Result<Vec<Ratio>, _>>()?;
        if !ratios.is_sorted_by(|a, b| a > b) {
            return Err(format!("found `{text}`, expected ratios that decrease, such as 100%,50%,25%"));
        }
        if ratios.len() > MAX_LEVELS {
            return Err(format!("found {} levels, expected at most {MAX_LEVELS}", ratios.len()));
        }
        Ok(Self(ratios))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_decrease() {
        let read = |text: &str| text.parse::<ChainRatios>().map(|ratios| ratios.0.len());
        assert_eq!(["100%", "1,50%,0.25", "0"].map(|text| read(text).ok()), [1, 3, 1].map(Some));
        for wrong in ["", "50%,", "50%,50%", "50%,100%", "101%", "a"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        assert_eq!(ChainRatios::default().to_string(), "100%,50%,25%,10%");
        assert_eq!("100%,50%,25%,10%".parse(), Ok(ChainRatios::default()));
        let many: Vec<String> = (0..17).rev().map(|i| format!("{i}%")).collect();
        assert!(read(&many.join(",")).is_err() && read(&many[1..].join(",")) == Ok(16));
    }
}
