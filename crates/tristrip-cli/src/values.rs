//! The values of flags, and their names on the command line.
//!
//! These types do not depend on other parts of the command. Flags, tasks and subcommands share
//! them.

#[cfg(feature = "serve")]
mod rates;

use std::fmt;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use tristrip::Effort;
use tristrip::Layout;
use tristrip_io::Format;
use tristrip_render::images::MAX_SIZE;

#[cfg(feature = "serve")]
pub(crate) use rates::{BitRate, ByteCount};

/// Returns a parser for the names of formats, which are their file name extensions.
pub(crate) fn format_parser(formats: &'static [Format]) -> impl TypedValueParser<Value = Format> {
    let names = formats.iter().map(|format| format.extension());
    PossibleValuesParser::new(names).try_map(|name| {
        let format = formats.iter().find(|format| format.extension() == name);
        format.copied().ok_or_else(|| format!("unknown format `{name}`"))
    })
}

/// Returns a parser for search efforts from 0 to 9.
pub(crate) fn effort_parser() -> impl TypedValueParser<Value = Effort> {
    clap::value_parser!(u8)
        .range(0..=9)
        .try_map(|level| Effort::new(level).ok_or_else(|| format!("{level} is not in 0..=9")))
}

/// Returns a parser for the named values of a library type, with one line of help per value.
pub(crate) fn named<T>(
    values: impl IntoIterator<Item = T>,
    name: fn(T) -> &'static str,
    help: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: fmt::Display> + Copy + Send + Sync + 'static,
{
    let values = values.into_iter().map(|value| PossibleValue::new(name(value)).help(help(value)));
    PossibleValuesParser::new(values).try_map(|text| text.parse::<T>().map_err(|error| error.to_string()))
}

/// Returns a line of help about a layout.
pub(crate) fn layout_help(layout: Layout) -> &'static str {
    match layout {
        Layout::Restart => {
            "Strips separated by the restart index; in glTF a draft extension that three.js does not support"
        }
        Layout::Degenerate => "One strip, joined by degenerate triangles; most glTF viewers draw it",
        Layout::Separate => "One primitive (glTF) or row (PLY) per strip",
        Layout::List => "A triangle list in strip order",
    }
}

/// A number of triangles as typed: `50000`, `200k` or `2M`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Amount(pub(crate) usize);

impl FromStr for Amount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (digits, factor) = match text.strip_suffix(['k', 'M']) {
            Some(digits) if text.ends_with('k') => (digits, 1_000),
            Some(digits) => (digits, 1_000_000),
            None => (text, 1),
        };
        let amount = digits.parse::<usize>().ok().and_then(|number| number.checked_mul(factor));
        amount.map(Self).ok_or_else(|| format!("found `{text}`, expected a number such as 50000, 200k or 2M"))
    }
}

/// The size of an image as typed: `1920x1080`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ImageSize(pub(crate) [u32; 2]);

impl FromStr for ImageSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let size = text
            .split_once('x')
            .and_then(|(columns, rows)| Some([columns.parse().ok()?, rows.parse().ok()?]));
        let size = size.filter(|size| size.iter().all(|pixels| (1..=MAX_SIZE).contains(pixels)));
        size.map(Self).ok_or_else(|| {
            format!("found `{text}`, expected columns and rows from 1 to {MAX_SIZE}, such as 1920x1080")
        })
    }
}

impl fmt::Display for ImageSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

/// A point or direction as typed: `0,1.5,-3`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VectorArg(pub(crate) [f32; 3]);

impl FromStr for VectorArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let vector = finite_numbers(text).map(Self);
        vector.ok_or_else(|| format!("found `{text}`, expected three finite numbers such as 0,1.5,-3"))
    }
}

/// A point of an image as typed: `0.5,0.25`, in fractions of its width and height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImagePoint(pub(crate) [f32; 2]);

impl FromStr for ImagePoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let point = finite_numbers(text).filter(|point| point.iter().all(|x| (0.0..=1.0).contains(x)));
        let expected = "expected two fractions from 0 to 1 such as 0.5,0.25";
        point.map(Self).ok_or_else(|| format!("found `{text}`, {expected}"))
    }
}

impl fmt::Display for ImagePoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.0[0], self.0[1])
    }
}

/// Parses N finite numbers separated by commas.
fn finite_numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let numbers = <[f32; N]>::try_from(numbers?).ok()?;
    numbers.iter().all(|x| x.is_finite()).then_some(numbers)
}

impl fmt::Display for VectorArg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_typed() {
        let amounts = ["50000", "200k", "2M"].map(|text| text.parse::<Amount>().map(|amount| amount.0));
        assert_eq!(amounts, [Ok(50_000), Ok(200_000), Ok(2_000_000)]);
        assert!(
            ["", "k", "-1", "1.5k", "2G", "99999999999999999999"]
                .iter()
                .all(|t| t.parse::<Amount>().is_err())
        );
        assert_eq!("640x480".parse(), Ok(ImageSize([640, 480])));
        assert!(["640", "0x5", "9000x1", "ax5", "1x2x3"].iter().all(|t| t.parse::<ImageSize>().is_err()));
        assert_eq!("0,1.5, -3".parse(), Ok(VectorArg([0.0, 1.5, -3.0])));
        assert!(["0,1", "0,1,NaN", "0,1,inf", "0,1,2,3"].iter().all(|t| t.parse::<VectorArg>().is_err()));
        assert_eq!("0.5,1".parse(), Ok(ImagePoint([0.5, 1.0])));
        assert!(["0.5", "0,1,0", "0,NaN", "-0.1,0"].iter().all(|t| t.parse::<ImagePoint>().is_err()));
    }
}
