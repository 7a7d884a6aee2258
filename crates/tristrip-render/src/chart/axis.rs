//! Axes: the mapping of values to coordinates, and the ticks.
//!
//! A scale maps a value to a coordinate. A span contains the range of coordinates and the ticks
//! with their labels. Steps of a linear axis are 1, 2 or 5 times a power of ten, found by
//! multiplication. Logarithmic axes use `libm`, because the precision of the platform's logarithms
//! differs, and a chart must have the same bytes on every machine.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::style::printable;
use tristrip_pipeline::text::grouped;

/// The maximum number of steps of a linear axis.
const STEPS: f64 = 6.0;
/// The maximum number of ticks of a logarithmic axis.
const LOG_TICKS: usize = 10;

/// Larger coordinates are not shown, because `f64` could not distinguish their ticks.
const LARGEST: f64 = 1e15;

/// The mapping of values to coordinates.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// Equal steps, starting at 0 or near the minimum.
    Linear {
        /// Whether the axis starts at 0.
        from_zero: bool,
    },
    /// Logarithmic, with ticks at powers of two.
    Log2,
    /// Logarithmic, with ticks at powers of ten, and at 2 and 5 times these if there is space.
    Log10,
    /// Names at 0, 1, 2, …
    Names(Vec<String>),
}

/// The title and scale of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub(super) title: String,
    pub(super) scale: Scale,
}

impl Axis {
    /// Creates an axis; the title names the quantity and its unit.
    pub fn new(title: &str, scale: Scale) -> Self {
        Self { title: title.into(), scale }
    }

    /// Returns a span that contains the values. With bars, it extends by 0.5 at both ends.
    pub(super) fn span(&self, values: impl Iterator<Item = f64>, bars: bool) -> AxisSpan {
        let coordinates = values.filter_map(|value| self.scale.coordinate(value));
        let (low, high) =
            coordinates.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let mut span = match &self.scale {
            Scale::Linear { from_zero } => linear(if *from_zero { low.min(0.0) } else { low }, high),
            Scale::Log2 => log2(low, high),
            Scale::Log10 => log10(low, high),
            Scale::Names(names) => named(names),
        };
        if bars && !matches!(self.scale, Scale::Names(_)) {
            (span.low, span.high) = (span.low - 0.5, span.high + 0.5);
        }
        span
    }
}

impl Scale {
    /// Returns the coordinate of a value, or `None` if the scale cannot show it.
    pub(super) fn coordinate(&self, value: f64) -> Option<f64> {
        let coordinate = match self {
            Self::Linear { .. } | Self::Names(_) => value,
            Self::Log2 | Self::Log10 => libm::log2(value),
        };
        (coordinate.abs() <= LARGEST).then_some(coordinate)
    }
}

/// The range of coordinates of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisSpan {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Coordinates and their labels, from low to high.
    ticks: Vec<(f64, String)>,
}

impl AxisSpan {
    pub(super) fn tick_count(&self) -> usize {
        self.ticks.len()
    }

    pub(super) fn longest_label(&self) -> &str {
        self.ticks.iter().map(|(_, text)| text.as_str()).max_by_key(|text| text.chars().count()).unwrap_or("")
    }
}

impl Ranged for AxisSpan {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, coordinate: &f64, (from, to): (i32, i32)) -> i32 {
        let fraction = (coordinate - self.low) / (self.high - self.low);
        from + (f64::from(to - from) * fraction).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|&(coordinate, _)| coordinate).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for AxisSpan {
    fn format_ext(&self, coordinate: &f64) -> String {
        let tick = self.ticks.iter().find(|(tick, _)| tick.total_cmp(coordinate).is_eq());
        tick.map(|(_, text)| text.clone()).unwrap_or_default()
    }
}

fn linear(low: f64, high: f64) -> AxisSpan {
    // A single value is centred in an interval.
    let (low, high) = if low < high {
        (low, high)
    } else {
        (low - 0.5 * low.abs().max(1.0), low + 0.5 * low.abs().max(1.0))
    };
    let (step, digits) = step((high - low) / STEPS);
    let (first, last) = ((low / step).floor(), (high / step).ceil());
    let steps = (0..20_u8).map(|i| first + f64::from(i)).take_while(|&number| number <= last);
    let ticks = steps.map(|number| (number * step, value_text(number * step, digits)));
    AxisSpan { low: first * step, high: (last * step).max(first * step + step), ticks: ticks.collect() }
}

/// Returns the smallest step of 1, 2 or 5 times a power of ten that is at least `least`, and its
/// number of decimals.
fn step(least: f64) -> (f64, usize) {
    let mut power = 1.0_f64;
    let mut digits = 0_usize;
    while power >= least && digits < 12 {
        power /= 10.0;
        digits += 1;
    }
    while power * 10.0 < least {
        power *= 10.0;
        digits = digits.saturating_sub(1);
    }
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|factor| power * factor >= least).unwrap_or(10.0);
    if factor >= 10.0 { (power * 10.0, digits.saturating_sub(1)) } else { (power * factor, digits) }
}

/// Formats a tick label of a linear axis.
fn value_text(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if digits > 0 {
        return text;
    }
    match text.strip_prefix('-') {
        Some("0") => "0".into(),
        Some(rest) => format!("-{}", grouped(rest)),
        None => grouped(&text),
    }
}

fn log2(low: f64, high: f64) -> AxisSpan {
    let (first, last) = (low.floor() as i32, (high.ceil() as i32).max(low.floor() as i32 + 1));
    let every = (first.abs_diff(last) as usize).div_ceil(LOG_TICKS).max(1);
    let ticks =
        (first..=last).step_by(every).map(|power| (f64::from(power), log_text(libm::exp2(f64::from(power)))));
    AxisSpan { low: f64::from(first), high: f64::from(last), ticks: ticks.collect() }
}

fn log10(low: f64, high: f64) -> AxisSpan {
    // Powers are parsed from text, so each is the nearest `f64`.
    let powers = (-12..=15).filter_map(|power| format!("1e{power}").parse::<f64>().ok());
    let candidates: Vec<f64> =
        powers.flat_map(|power| [1.0, 2.0, 5.0].map(|factor| factor * power)).collect();
    let from = candidates.iter().rposition(|&value| libm::log2(value) <= low + 1e-9).unwrap_or(0);
    let last = candidates.len() - 1;
    let to =
        candidates.iter().position(|&value| libm::log2(value) >= high - 1e-9).unwrap_or(last).max(from + 1);
    let to = to.min(last);
    let every = if to - from < LOG_TICKS { 1 } else { 3 * (to - from).div_ceil(3 * LOG_TICKS) };
    let ticks = (from..=to).filter(|i| i % every == 0);
    let ticks = ticks.map(|i| (libm::log2(candidates[i]), log_text(candidates[i]))).collect();
    AxisSpan { low: libm::log2(candidates[from.min(to)]), high: libm::log2(candidates[to]), ticks }
}

/// Formats a tick label of a logarithmic axis with as few digits as possible: `0.5`, `20k`, `1M`.
fn log_text(value: f64) -> String {
    let units = [(1e9, "G"), (1e6, "M"), (1e3, "k")];
    let (unit, letter) = units.into_iter().find(|(unit, _)| value >= *unit).unwrap_or((1.0, ""));
    let value = value / unit;
    let digits = (0..12).find(|&digits| {
        let text = format!("{value:.digits$}");
        text.parse::<f64>().is_ok_and(|parsed| (parsed - value).abs() <= 1e-6 * value)
    });
    value_text(value, digits.unwrap_or(12)) + letter
}

fn named(names: &[String]) -> AxisSpan {
    let ticks = names.iter().enumerate().map(|(i, name)| (i as f64, printable(name))).collect();
    AxisSpan { low: -0.5, high: names.len().max(1) as f64 - 0.5, ticks }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(scale: Scale, values: &[f64]) -> String {
        let span = Axis::new("", scale).span(values.iter().copied(), false);
        span.ticks.iter().map(|(_, text)| text.as_str()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn ticks_are_round() {
        let linear = |from_zero| Scale::Linear { from_zero };
        assert_eq!(texts(linear(true), &[3.0, 1234.0]), "0 500 1,000 1,500");
        assert_eq!(texts(linear(false), &[0.61, 0.74]), "0.60 0.65 0.70 0.75");
        assert_eq!(texts(linear(false), &[5.0]), "2 3 4 5 6 7 8");
        assert_eq!(texts(linear(true), &[]), "0.0 0.2 0.4 0.6 0.8 1.0");
        assert_eq!(texts(linear(false), &[-3.0, 3.0]), "-3 -2 -1 0 1 2 3");
        assert_eq!(texts(Scale::Log2, &[2.0, 64.0]), "2 4 8 16 32 64");
        assert_eq!(texts(Scale::Log10, &[1200.0, 870_000.0]), "1k 2k 5k 10k 20k 50k 100k 200k 500k 1M");
        assert_eq!(texts(Scale::Log10, &[0.5, 8.0]), "0.5 1 2 5 10");
        assert_eq!(texts(Scale::Names(vec!["a".into(), "b".into()]), &[9.0]), "a b");
    }

    #[test]
    fn extreme_values_give_few_ticks() {
        let extreme =
            [0.0, -1.0, 1e300, -1e300, 1e-300, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, f64::MAX];
        for scale in
            [Scale::Linear { from_zero: true }, Scale::Linear { from_zero: false }, Scale::Log2, Scale::Log10]
        {
            for a in extreme {
                for b in extreme {
                    let span = Axis::new("", scale.clone()).span([a, b].into_iter(), true);
                    assert!(span.ticks.len() <= 20 && span.low < span.high, "{scale:?} {a} {b}: {span:?}");
                }
            }
        }
    }
}
