//! The values that flags parse to, and their names on the command line.
//!
//! These types depend on no other part of the command, so that flags, tasks and subcommands can share them.

use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use tristrip::Layout;
use tristrip::stripify::Effort;
use tristrip_io::Format;
use tristrip_pipeline::DisplayFilter;

/// The formats that can be written.
pub(crate) const WRITTEN_FORMATS: [Format; 3] = [Format::Glb, Format::Ply, Format::Obj];

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

/// Returns the name of a value on the command line.
pub(crate) fn name_of<E: ValueEnum + Copy>(value: E) -> String {
    value.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

/// A layout of strips in an index buffer.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum LayoutName {
    /// Strips separated by the restart index (in glTF: a draft extension, which three.js and other viewers ignore and draw wrong)
    Restart,
    /// One strip, joined by degenerate triangles; every glTF viewer draws it
    Degenerate,
    /// One primitive (glTF) or row (PLY) per strip
    Separate,
    /// A triangle list in strip order
    List,
}

impl From<LayoutName> for Layout {
    fn from(name: LayoutName) -> Self {
        match name {
            LayoutName::Restart => Self::Restart,
            LayoutName::Degenerate => Self::Degenerate,
            LayoutName::Separate => Self::Separate,
            LayoutName::List => Self::List,
        }
    }
}

/// Returns the name of a layout on the command line.
pub(crate) fn layout_name(layout: Layout) -> &'static str {
    match layout {
        Layout::Restart => "restart",
        Layout::Degenerate => "degenerate",
        Layout::Separate => "separate",
        Layout::List => "list",
    }
}

/// A level-of-detail model: how levels are stored and replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ModelName {
    /// Progressive strips: collapses and vertex splits in one fixed order (Kim et al. 2005)
    Progressive,
}

/// A filter: how the strips of a level become display strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FilterName {
    /// Draw the renamed strips unchanged, degenerate triangles included
    None,
    /// Simple triangle strip scanner: send repeated pairs of vertices once (El-Sana et al. 2000)
    Stss,
    /// Degenerate-triangle-free scanner: send valid triangles only (Kim et al. 2005)
    Dtfs,
    /// Send valid triangles only, in the same order, at the least cost for this order
    Linked,
    /// Keep paths over the triangles of the level, and repair them by a local search where collapses cut them
    Repair,
}

impl FilterName {
    pub(crate) const DEFAULT: Self = Self::Repair;
}

impl From<FilterName> for DisplayFilter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::None => Self::None,
            FilterName::Stss => Self::Stss,
            FilterName::Dtfs => Self::Dtfs,
            FilterName::Linked => Self::Linked,
            FilterName::Repair => Self::Repair,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_have_the_same_name_in_both_directions() {
        for &name in LayoutName::value_variants() {
            assert_eq!(name_of(name), layout_name(name.into()));
        }
    }

    #[test]
    fn filters_have_the_names_of_the_library() {
        let names =
            FilterName::value_variants().iter().map(|&name| (name_of(name), DisplayFilter::from(name)));
        assert!(names.eq(DisplayFilter::ALL.map(|filter| (filter.to_string(), filter))));
    }
}
