//! Removes redundant JSON: members that equal the default, optional bounds, and unnecessary digits.
//!
//! Extensions and extras are not changed. Numbers keep their value as 64-bit floats, with two
//! exceptions. The bounds of 32-bit floats, which the specification rounds to that type, are
//! written with the fewest digits of the 32-bit float. With rounding, node transforms that are
//! exact 32-bit floats are written in the same way. This is lossless for programs that read them as
//! 32-bit floats.

use std::collections::HashSet;

use super::packing::{Packing, Rounding};
use crate::error::Error;
use crate::gltf::document::json::{JsonContent, Members, Value};
use crate::gltf::document::references::position_accessors;
use crate::gltf::document::{array, entries_mut, index, items};

/// Removes redundant JSON.
pub(super) fn tidy(scene: &mut Packing, rounding: Rounding) -> Result<(), Error> {
    let fixed = scene.fixed.accessors;
    let root = &mut scene.document.root;
    let mut bounded = position_accessors(root)?;
    bounded.extend(times(root)?);
    for (number, accessor) in entries_mut(root, "accessors")?.iter_mut().enumerate() {
        let Some(members) = accessor.as_object_mut() else { continue };
        if number >= fixed && !bounded.contains(&number) {
            ["min", "max"].into_iter().for_each(|name| members.remove(name));
        }
        if members.get("componentType").and_then(index) == Some(5126) {
            for name in ["min", "max"] {
                let numbers = members.get_mut(name).and_then(Value::as_array_mut);
                numbers.into_iter().flatten().for_each(shorten_float);
            }
        }
    }
    for node in entries_mut(root, "nodes")?.iter_mut().filter(|_| rounding != Rounding::None) {
        for name in PLACES {
            let numbers = node.as_object_mut().and_then(|node| node.get_mut(name)?.as_array_mut());
            numbers.into_iter().flatten().filter(|value| is_float(value)).for_each(shorten_float);
        }
    }
    for (list, defaults) in DEFAULTS {
        for entry in entries_mut(root, list)? {
            remove_defaults(entry, defaults);
        }
    }
    for mesh in entries_mut(root, "meshes")? {
        each_item(mesh, "primitives", &[("mode", "4")]);
    }
    for animation in entries_mut(root, "animations")? {
        each_item(animation, "samplers", &[("interpolation", "\"LINEAR\"")]);
    }
    let known = root.iter_mut().filter(|(name, _)| !matches!(*name, "extensions" | "extras"));
    known.for_each(|(_, value)| shorten_numbers(value));
    Ok(())
}

/// Members of a node's transform.
const PLACES: [&str; 4] = ["translation", "rotation", "scale", "matrix"];

/// Members with defaults in the specification, as JSON, by top-level array.
const DEFAULTS: [(&str, &[(&str, &str)]); 5] = [
    ("accessors", &[("byteOffset", "0"), ("normalized", "false")]),
    ("bufferViews", &[("byteOffset", "0")]),
    (
        "nodes",
        &[
            ("translation", "[0,0,0]"),
            ("rotation", "[0,0,0,1]"),
            ("scale", "[1,1,1]"),
            ("matrix", "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]"),
        ],
    ),
    ("samplers", &[("wrapS", "10497"), ("wrapT", "10497")]),
    ("materials", &[("doubleSided", "false"), ("alphaMode", "\"OPAQUE\""), ("emissiveFactor", "[0,0,0]")]),
];

fn each_item(owner: &mut Value, list: &str, defaults: &[(&str, &str)]) {
    let entries = owner.as_object_mut().and_then(|owner| owner.get_mut(list)?.as_array_mut());
    entries.into_iter().flatten().for_each(|entry| remove_defaults(entry, defaults));
}

fn remove_defaults(entry: &mut Value, defaults: &[(&str, &str)]) {
    let is_default =
        |&(name, default): &(&str, &str)| entry.get(name).is_some_and(|value| equals(value, default));
    let found: Vec<&str> = defaults.iter().filter(|one| is_default(one)).map(|&(name, _)| name).collect();
    if let Some(members) = Some(entry).filter(|_| !found.is_empty()).and_then(Value::as_object_mut) {
        found.into_iter().for_each(|name| members.remove(name));
    }
}

/// Compares a value with the JSON of an array of numbers, a number, a string or a bool.
fn equals(value: &Value, json: &str) -> bool {
    match &value.content {
        JsonContent::Array(items) => {
            json.strip_prefix('[').and_then(|json| json.strip_suffix(']')).is_some_and(|json| {
                items.len() == json.split(',').count()
                    && items.iter().zip(json.split(',')).all(|(item, json)| equals(item, json))
            })
        }
        JsonContent::Whole(_) | JsonContent::Number(_) => {
            // Negative zero is not the default, because its sign may matter.
            number(value)
                .zip(json.parse::<f64>().ok())
                .is_some_and(|(found, default)| found.to_bits() == default.to_bits())
        }
        JsonContent::String(text) => json.len() == text.len() + 2 && json[1..json.len() - 1] == **text,
        JsonContent::Bool(value) => json == value.to_string(),
        JsonContent::Null | JsonContent::Object(_) => false,
    }
}

fn number(value: &Value) -> Option<f64> {
    match &value.content {
        JsonContent::Whole(number) => Some(*number as f64),
        JsonContent::Number(text) => text.parse().ok(),
        _ => None,
    }
}

/// Writes all numbers outside extensions and extras with the fewest digits of the same 64-bit
/// float.
fn shorten_numbers(value: &mut Value) {
    match &value.content {
        JsonContent::Array(items) if items.iter().any(may_shorten) => {
            value.as_array_mut().into_iter().flatten().for_each(shorten_numbers);
        }
        JsonContent::Object(members) if members.values().any(may_shorten) => {
            let members = value.as_object_mut().into_iter().flat_map(Members::iter_mut);
            let known = members.filter(|(name, _)| !matches!(*name, "extensions" | "extras"));
            known.for_each(|(_, member)| shorten_numbers(member));
        }
        JsonContent::Number(text) => {
            let shorter = text.parse::<f64>().ok().filter(|x| x.is_finite()).map(|x| shortest(&x));
            if let Some(shorter) = shorter.filter(|shorter| shorter.len() < text.len()) {
                *value = Value::number(&shorter);
            }
        }
        _ => {}
    }
}

fn may_shorten(value: &Value) -> bool {
    matches!(value.content, JsonContent::Number(_) | JsonContent::Array(_) | JsonContent::Object(_))
}

/// Checks whether a number is exactly representable as a 32-bit float.
fn is_float(value: &Value) -> bool {
    number(value).is_some_and(|x| f64::from(x as f32).to_bits() == x.to_bits())
}

/// Writes a number with the fewest digits of the same 32-bit float.
fn shorten_float(value: &mut Value) {
    let float = number(value).map(|x| x as f32).filter(|x| x.is_finite());
    if let Some(float) = float {
        *value = Value::number(&shortest(&float));
    }
}

/// Returns the shorter of the decimal and the exponent notation of a float.
fn shortest(x: &(impl std::fmt::Display + std::fmt::LowerExp)) -> String {
    let (plain, exponent) = (x.to_string(), format!("{x:e}"));
    if exponent.len() < plain.len() { exponent } else { plain }
}

/// Returns the accessors of keyframe times.
fn times(root: &Members) -> Result<HashSet<usize>, Error> {
    let samplers = array(root, "animations")?.iter().flat_map(|animation| items(animation, "samplers"));
    Ok(samplers.filter_map(|sampler| index(sampler.get("input")?)).collect())
}
