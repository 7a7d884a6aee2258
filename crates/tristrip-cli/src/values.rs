//! The values that flags parse to, and their names on the command line.
//!
//! These types depend on no other part of the command, so that flags, tasks and subcommands can share them.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use tristrip::Effort;
use tristrip::{Layout, Method};
use tristrip_io::Format;

/// The formats that can be written.
pub(crate) const WRITTEN_FORMATS: [Format; 4] = [Format::Glb, Format::Gltf, Format::Ply, Format::Obj];

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

/// Returns a parser for the values of a type of the library, by their names and with a line of help each.
pub(crate) fn named<T>(
    values: impl IntoIterator<Item = T>,
    name: fn(T) -> &'static str,
    help: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: std::fmt::Display> + Copy + Send + Sync + 'static,
{
    let values = values.into_iter().map(|value| PossibleValue::new(name(value)).help(help(value)));
    PossibleValuesParser::new(values).try_map(|text| text.parse::<T>().map_err(|error| error.to_string()))
}

/// Returns a parser for the names of methods; `stripe` is one of them with its authors' settings.
pub(crate) fn method_parser() -> impl TypedValueParser<Value = Method> {
    let mut names: Vec<(&str, &str)> =
        Method::ALL.iter().map(|method| (method.name(), method.summary())).collect();
    let first = names.iter().position(|(name, _)| name.starts_with("stripe")).unwrap_or(names.len());
    names.insert(first, ("stripe", "STRIPE as its authors recommend it: stripe-global by rows, cutoff 5"));
    let values = names.into_iter().map(|(name, help)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(values).try_map(|text| text.parse::<Method>())
}

/// Returns a line on a layout, in the words of files.
pub(crate) fn layout_help(layout: Layout) -> &'static str {
    match layout {
        Layout::Restart => {
            "Strips separated by the restart index (in glTF: a draft extension, which three.js and other viewers ignore and draw wrong)"
        }
        Layout::Degenerate => "One strip, joined by degenerate triangles; every glTF viewer draws it",
        Layout::Separate => "One primitive (glTF) or row (PLY) per strip",
        Layout::List => "A triangle list in strip order",
    }
}
