//! Axes: from figures to places, and the ticks between.
//!
//! A scale gives each figure a place; a span holds the places from end to end, and its ticks with their texts. Steps of a linear axis are
//! 1, 2 or 5 times a power of ten, found by multiplication alone, so that no machine's logarithm decides.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use crate::text::grouped;

/// Steps that a linear axis has at most.
const STEPS: f64 = 6.0;
/// Ticks that a logarithmic axis has at most.
const LOG_TICKS: usize = 10;

/// Figures beyond are not shown: their steps could not be told apart.
const LARGEST: f64 = 1e15;

/// How figures are laid along an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Scale {
    /// Equal steps from 0, or from near the least figure.
    Linear {
        /// Whether the axis begins at 0.
        from_zero: bool,
    },
    /// Equal ratios, ticks at powers of two.
    Log2,
    /// Equal ratios, ticks at powers of ten, with 2 and 5 between where there is room.
    Log10,
    /// Names at 0, 1, 2 …
    Names(Vec<String>),
}

/// What an axis shows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    pub(super) title: String,
    pub(super) scale: Scale,
}

impl Axis {
    /// Makes an axis; the title says the unit.
    pub(crate) fn new(title: &str, scale: Scale) -> Self {
        Self { title: title.into(), scale }
    }

    /// Spans figures; with bars there is half a step more at both ends.
    pub(super) fn span(&self, figures: impl Iterator<Item = f64>, bars: bool) -> Span {
        let places = figures.filter_map(|figure| self.scale.place(figure));
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
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
    /// Gives the place of a figure; none for what the scale cannot show.
    pub(super) fn place(&self, figure: f64) -> Option<f64> {
        let place = match self {
            Self::Linear { .. } | Self::Names(_) => figure,
            Self::Log2 | Self::Log10 => figure.log2(),
        };
        (place.abs() <= LARGEST).then_some(place)
    }
}

/// The places of an axis from end to end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Places and their texts, from low to high.
    ticks: Vec<(f64, String)>,
}

impl Span {
    pub(super) fn tick_count(&self) -> usize {
        self.ticks.len()
    }

    pub(super) fn longest_label(&self) -> &str {
        self.ticks.iter().map(|(_, text)| text.as_str()).max_by_key(|text| text.chars().count()).unwrap_or("")
    }
}

impl Ranged for Span {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (place - self.low) / (self.high - self.low);
        from + (f64::from(to - from) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|&(place, _)| place).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Span {
    fn format_ext(&self, place: &f64) -> String {
        let tick = self.ticks.iter().find(|(tick, _)| tick.total_cmp(place).is_eq());
        tick.map(|(_, text)| text.clone()).unwrap_or_default()
    }
}

fn linear(low: f64, high: f64) -> Span {
    // A single figure stands in the middle of something.
    let (low, high) = if low < high {
        (low, high)
    } else {
        (low - 0.5 * low.abs().max(1.0), low + 0.5 * low.abs().max(1.0))
    };
    let (step, digits) = step((high - low) / STEPS);
    let (first, last) = ((low / step).floor(), (high / step).ceil());
    let steps = (0..20_u8).map(|i| first + f64::from(i)).take_while(|&number| number <= last);
    let ticks = steps.map(|number| (number * step, figure_text(number * step, digits)));
    Span { low: first * step, high: (last * step).max(first * step + step), ticks: ticks.collect() }
}

/// Gives the least step of 1, 2 or 5 times a power of ten that is not below a length, and its digits after the point.
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

fn figure_text(figure: f64, digits: usize) -> String {
    let text = format!("{figure:.digits$}");
    if digits > 0 {
        return text;
    }
    match text.strip_prefix('-') {
        Some("0") => "0".into(),
        Some(rest) => format!("-{}", grouped(rest)),
        None => grouped(&text),
    }
}

fn log2(low: f64, high: f64) -> Span {
    let (first, last) = (low.floor() as i32, (high.ceil() as i32).max(low.floor() as i32 + 1));
    let every = (first.abs_diff(last) as usize).div_ceil(LOG_TICKS).max(1);
    let ticks =
        (first..=last).step_by(every).map(|power| (f64::from(power), log_text(f64::from(power).exp2())));
    Span { low: f64::from(first), high: f64::from(last), ticks: ticks.collect() }
}

fn log10(low: f64, high: f64) -> Span {
    // Read from text, each is the nearest to what its digits say.
    let powers = (-12..=15).filter_map(|power| format!("1e{power}").parse::<f64>().ok());
    let figures: Vec<f64> = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|factor| factor * power)).collect();
    let from = figures.iter().rposition(|f| f.log2() <= low + 1e-9).unwrap_or(0);
    let to = figures.iter().position(|f| f.log2() >= high - 1e-9).unwrap_or(figures.len() - 1).max(from + 1);
    let to = to.min(figures.len() - 1);
    let every = if to - from < LOG_TICKS { 1 } else { 3 * (to - from).div_ceil(3 * LOG_TICKS) };
    let ticks = (from..=to).filter(|i| i % every == 0);
    let ticks = ticks.map(|i| (figures[i].log2(), log_text(figures[i]))).collect();
    Span { low: figures[from.min(to)].log2(), high: figures[to].log2(), ticks }
}

/// Writes a tick of a logarithmic axis with the digits that it needs: `0.5`, `20k`, `1M`.
fn log_text(figure: f64) -> String {
    let units = [(1e9, "G"), (1e6, "M"), (1e3, "k")];
    let (unit, letter) = units.into_iter().find(|(unit, _)| figure >= *unit).unwrap_or((1.0, ""));
    let figure = figure / unit;
    let digits = (0..12).find(|&digits| {
        let text = format!("{figure:.digits$}");
        text.parse::<f64>().is_ok_and(|read| (read - figure).abs() <= 1e-6 * figure)
    });
    figure_text(figure, digits.unwrap_or(12)) + letter
}

fn named(names: &[String]) -> Span {
    let ticks = names.iter().enumerate().map(|(i, name)| (i as f64, super::printable(name))).collect();
    Span { low: -0.5, high: names.len().max(1) as f64 - 0.5, ticks }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(scale: Scale, figures: &[f64]) -> String {
        let span = Axis::new("", scale).span(figures.iter().copied(), false);
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
    fn no_figure_makes_an_axis_without_end() {
        let odd = [0.0, -1.0, 1e300, -1e300, 1e-300, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, f64::MAX];
        for scale in
            [Scale::Linear { from_zero: true }, Scale::Linear { from_zero: false }, Scale::Log2, Scale::Log10]
        {
            for a in odd {
                for b in odd {
                    let span = Axis::new("", scale.clone()).span([a, b].into_iter(), true);
                    assert!(span.ticks.len() <= 20 && span.low < span.high, "{scale:?} {a} {b}: {span:?}");
                }
            }
        }
    }
}
