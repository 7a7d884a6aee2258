//! Byte counts and bit rates with a unit: values of the flags of `serve` and `view`.

use std::str::FromStr;

/// A number of bytes as typed: `4096`, `16K`, `512M` or `2G`, in powers of 1024.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ByteCount(pub(crate) u64);

impl FromStr for ByteCount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let units = [('K', 1 << 10), ('M', 1 << 20), ('G', 1 << 30)];
        let bytes = scaled(text, &units).map(Self);
        bytes.ok_or_else(|| format!("found `{text}`, expected bytes such as 4096, 16K, 512M or 2G"))
    }
}

/// Bits per second as typed: `64000`, `500k`, `5M` or `1G`, in powers of 1000.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BitRate(pub(crate) u64);

impl FromStr for BitRate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let units = [('k', 1_000), ('M', 1_000_000), ('G', 1_000_000_000)];
        // At a lower rate, a page of text would take minutes.
        let rate = scaled(text, &units).filter(|rate| *rate >= 1000).map(Self);
        rate.ok_or_else(|| {
            format!("found `{text}`, expected at least 1000 bits per second, such as 500k or 5M")
        })
    }
}

/// Parses an integer with an optional unit suffix.
fn scaled(text: &str, units: &[(char, u64)]) -> Option<u64> {
    let unit = units.iter().find_map(|&(unit, factor)| Some((text.strip_suffix(unit)?, factor)));
    let (digits, factor) = unit.unwrap_or((text, 1));
    digits.parse::<u64>().ok()?.checked_mul(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_a_unit_are_read() {
        let bytes = ["4096", "16K", "512M", "2G"].map(|text| text.parse().map(|ByteCount(bytes)| bytes));
        assert_eq!(bytes, [Ok(4096), Ok(16 << 10), Ok(512 << 20), Ok(2 << 30)]);
        assert!(
            ["", "K", "1k", "-1", "1.5M", "99999999999G"].iter().all(|t| t.parse::<ByteCount>().is_err())
        );
        let rates = ["1000", "500k", "5M", "1G"].map(|text| text.parse().map(|BitRate(rate)| rate));
        assert_eq!(rates, [Ok(1000), Ok(500_000), Ok(5_000_000), Ok(1_000_000_000)]);
        assert!(["0", "999", "5K", "5Mbit"].iter().all(|t| t.parse::<BitRate>().is_err()));
    }
}
