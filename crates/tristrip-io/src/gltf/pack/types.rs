//! Stores arrays in smaller types. Joints and indices are converted if the type can represent every
//! value. Weights are converted if the type represents every value exactly, or if rounding is
//! requested.
//!
//! # Algorithm
//! 1. Decode each accessor whose values are contiguous and have the same use everywhere.
//! 2. Store joints in 8 bits if possible, and indices of points, lines and triangle lists in the
//!    smallest type whose maximum value exceeds every index.
//! 3. Store weights in 8 bits if each is exactly k/255, and in 16 bits if each is exactly k/65535.
//!    With rounding to h = 255 or 65535, each weight becomes ⌊h w⌋/h. If the four weights of a
//!    vertex summed to 1 before, 1/h is then added to the weights with the largest remainders until
//!    the sum is 1 again. The specification requires this sum.

#![allow(clippy::cast_sign_loss, reason = "indices, joints and weights are not negative")]

use std::collections::BTreeMap;

use serde_json::json;

use super::packing::{AppendedAccessors, Packing, Rounding, entry_mut};
use crate::error::Error;
use crate::gltf::document::accessor::AccessorValues;
use crate::gltf::document::bounds::number;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::json::{JsonContent, Members, Value};
use crate::gltf::document::references::skin_and_animation_accessors;
use crate::gltf::document::spec::ComponentType;
use crate::gltf::document::spec::TRIANGLES;
use crate::gltf::document::{Located, array, index, items, values, whole};
use crate::gltf::edit::permute::VERTEX_FACTOR;

/// Maximum difference between 1 and the sum of a vertex's weights for the sum to count as 1.
const SUM_TOLERANCE: f64 = 1e-3;

/// The use of an accessor's values.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meaning {
    Joints,
    /// The only weights of each vertex.
    Weights,
    Indices,
    Other,
}

/// Stores accessors in smaller types.
pub(super) fn narrow(scene: &mut Packing, rounding: Rounding) -> Result<(), Error> {
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    let root = &scene.document.root;
    let mut new = AppendedAccessors::of(root)?;
    let mut replaced = Vec::new();
    for (accessor, meaning) in meanings(root)? {
        if meaning == Meaning::Other || accessor < scene.fixed.accessors {
            continue;
        }
        let number = Value::from(accessor);
        let reference = Located { value: &number, at: format!("accessors[{accessor}]") };
        // Values that cannot be decoded are not changed.
        let Ok(values) = scene.resolver().values(&reference) else { continue };
        let is_plain =
            values.is_packed() && !values.matrix && budget.try_charge(values.count, 2 * values.element);
        if let Some((component, bytes)) =
            Some(values).filter(|_| is_plain).and_then(|v| narrowed(&v, meaning, rounding))
        {
            // The smaller values are in a new view and have no bounds.
            let old = array(root, "accessors")?.get(accessor).and_then(Value::as_object);
            let Some(mut members) = old.cloned() else { continue };
            ["byteOffset", "min", "max", "sparse"].into_iter().for_each(|name| members.remove(name));
            members.insert("componentType", u64::from(component.code()));
            if meaning == Meaning::Weights {
                members.insert("normalized", Value::from(json!(true)));
            }
            replaced.push((accessor, new.add(&bytes, JsonContent::Object(members))));
        }
    }
    scene.append(new)?;
    for (accessor, new) in replaced {
        let members = array(&scene.document.root, "accessors")?.get(new).and_then(Value::as_object).cloned();
        if let Some((members, slot)) =
            members.zip(entry_mut(&mut scene.document.root, "accessors", accessor)?)
        {
            *slot = members;
        }
    }
    Ok(())
}

/// Returns the use of each accessor that primitives refer to.
fn meanings(root: &Members) -> Result<BTreeMap<usize, Meaning>, Error> {
    let mut found: BTreeMap<usize, Meaning> = BTreeMap::new();
    let mut add = |value: &Value, meaning: Meaning| {
        if let Some(accessor) = index(value) {
            let known = found.entry(accessor).or_insert(meaning);
            *known = if *known == meaning { meaning } else { Meaning::Other };
        }
    };
    for primitive in array(root, "meshes")?.iter().flat_map(|mesh| items(mesh, "primitives")) {
        let attributes = primitive.get("attributes").and_then(Value::as_object);
        let has_more_weights = attributes.is_some_and(|attributes| attributes.contains_key("WEIGHTS_1"));
        for (name, value) in attributes.into_iter().flat_map(Members::iter) {
            add(
                value,
                match name {
                    name if name.starts_with("JOINTS_") => Meaning::Joints,
                    "WEIGHTS_0" if !has_more_weights => Meaning::Weights,
                    _ => Meaning::Other,
                },
            );
        }
        items(primitive, "targets").iter().flat_map(values).for_each(|value| add(value, Meaning::Other));
        if let Some(indices) = primitive.get("indices") {
            // In the other modes, the highest value may be a restart.
            let mode = primitive.get("mode").map_or(Some(TRIANGLES), whole);
            let is_list = matches!(mode, Some(0 | 1 | TRIANGLES));
            add(indices, if is_list { Meaning::Indices } else { Meaning::Other });
        }
    }
    for accessor in skin_and_animation_accessors(root)? {
        found.insert(accessor, Meaning::Other);
    }
    Ok(found)
}

/// Returns the values in a smaller type, if there is one.
fn narrowed(
    values: &AccessorValues<'_>,
    meaning: Meaning,
    rounding: Rounding,
) -> Option<(ComponentType, Vec<u8>)> {
    let component = values.component;
    let is_four_floats = component == ComponentType::F32 && values.components == 4;
    let is_whole = matches!(component, ComponentType::U16 | ComponentType::U32) && !values.normalized;
    if !(if meaning == Meaning::Weights { is_four_floats } else { is_whole }) {
        return None;
    }
    let raw = values.raw().ok()?;
    let all = raw.chunks_exact(component.bytes()).map(|bytes| number(component, bytes));
    if meaning == Meaning::Weights {
        let all: Vec<f64> = all.collect();
        return weights(all.as_chunks::<4>().0, rounding);
    }
    let highest = all.clone().fold(0.0, f64::max);
    // An index must not have the highest value of its type.
    let one = f64::from(u8::from(meaning == Meaning::Indices));
    match component {
        _ if highest + one <= 255.0 => Some((ComponentType::U8, all.map(|x| x as u8).collect())),
        ComponentType::U32 if highest + one <= 65535.0 => {
            Some((ComponentType::U16, all.flat_map(|x| (x as u16).to_le_bytes()).collect()))
        }
        _ => None,
    }
}

/// Returns weights in fewer bits: exactly, or rounded to the nearest values with the same sum.
fn weights(all: &[[f64; 4]], rounding: Rounding) -> Option<(ComponentType, Vec<u8>)> {
    let exact = [ComponentType::U8, ComponentType::U16].into_iter().find_map(|component| {
        let fours = all.iter().map(|&four| exact(four, highest(component)));
        fours.collect::<Option<Vec<_>>>().map(|fours| (component, fours))
    });
    let rounded = || {
        let component = match rounding {
            Rounding::None => return None,
            Rounding::Weights => ComponentType::U16,
            Rounding::WeightsAndRotations => ComponentType::U8,
        };
        let fours = all.iter().map(|&four| nearest(four, highest(component)));
        Some((component, fours.collect::<Option<Vec<_>>>()?))
    };
    // If 8 bits were requested, an exact 16-bit result does not suffice.
    let is_enough = |(component, _): &(ComponentType, _)| {
        rounding != Rounding::WeightsAndRotations || *component == ComponentType::U8
    };
    let (component, fours) = exact.filter(is_enough).or_else(rounded)?;
    let parts = fours.into_iter().flatten();
    let bytes = if component == ComponentType::U8 {
        parts.map(|part| part as u8).collect()
    } else {
        parts.flat_map(u16::to_le_bytes).collect()
    };
    Some((component, bytes))
}

/// Returns the integer that represents the weight 1 in 8 or 16 bits.
fn highest(component: ComponentType) -> u16 {
    if component == ComponentType::U8 { 255 } else { u16::MAX }
}

/// Returns four weights as multiples of 1/`highest`, if they are exactly representable and sum to
/// 1.
fn exact(four: [f64; 4], highest: u16) -> Option<[u16; 4]> {
    let parts = four.map(|weight| (weight * f64::from(highest)).round());
    let is_exact = four.iter().zip(&parts).all(|(weight, &part)| {
        (0.0..=1.0).contains(weight)
            && f64::from(part as f32 / f32::from(highest)).to_bits() == weight.to_bits()
    });
    let parts = parts.map(|part| part as u16);
    let sum: u32 = parts.iter().map(|&part| u32::from(part)).sum();
    (is_exact && sum == u32::from(highest)).then_some(parts)
}

/// Returns four weights as the nearest multiples of 1/`highest`, or `None` if one is outside 0 to
/// 1. If the weights sum to 1, the results sum to `highest`.
fn nearest(four: [f64; 4], highest: u16) -> Option<[u16; 4]> {
    if !four.iter().all(|weight| (0.0..=1.0 + SUM_TOLERANCE).contains(weight)) {
        return None;
    }
    let sum: f64 = four.iter().sum();
    if (sum - 1.0).abs() > SUM_TOLERANCE {
        return Some(four.map(|weight| (f64::from(highest) * weight).round() as u16));
    }
    let four = four.map(|weight| f64::from(highest) * (weight / sum));
    let mut parts = four.map(|x| x as u16);
    let mut order = [0, 1, 2, 3];
    let remainder = |i: usize| four[i] - f64::from(parts[i]);
    order.sort_by(|&a, &b| remainder(b).total_cmp(&remainder(a)));
    let missing = usize::from(highest).saturating_sub(parts.iter().map(|&part| usize::from(part)).sum());
    order.into_iter().take(missing).for_each(|i| parts[i] = parts[i].saturating_add(1));
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_weights_are_near_and_sum_to_one() {
        let mut tried = 0;
        for highest in [255, u16::MAX] {
            for a in 0..40 {
                for b in 0..40 - a {
                    let (x, y) = (f64::from(a) / 41.3, f64::from(b) / 41.3);
                    let all = [x, y, (1.0 - x - y) / 3.0, (1.0 - x - y) / 1.5];
                    let parts = nearest(all, highest).unwrap();
                    assert_eq!(parts.iter().map(|&part| u32::from(part)).sum::<u32>(), u32::from(highest));
                    for (weight, part) in all.iter().zip(parts) {
                        assert!(
                            (weight - f64::from(part) / f64::from(highest)).abs() < 1.0 / f64::from(highest)
                        );
                        tried += 1;
                    }
                }
            }
        }
        assert!(tried > 6000);
    }

    #[test]
    fn weights_become_smaller_without_rounding_only_if_they_are_exact() {
        let exact = |k: [u16; 4], highest: f32| k.map(|k| f64::from(f32::from(k) / highest));
        let eight_bits = [exact([255, 0, 0, 0], 255.0), exact([1, 254, 0, 0], 255.0)];
        let bytes = vec![255, 0, 0, 0, 1, 254, 0, 0];
        assert_eq!(weights(&eight_bits, Rounding::None), Some((ComponentType::U8, bytes.clone())));
        assert_eq!(weights(&eight_bits, Rounding::Weights), Some((ComponentType::U8, bytes)));
        let sixteen_bits = [exact([65534, 1, 0, 0], 65535.0)];
        let bytes = vec![254, 255, 1, 0, 0, 0, 0, 0];
        assert_eq!(weights(&sixteen_bits, Rounding::None), Some((ComponentType::U16, bytes)));
        assert_eq!(
            weights(&sixteen_bits, Rounding::WeightsAndRotations),
            Some((ComponentType::U8, vec![255, 0, 0, 0]))
        );
    }

    #[test]
    fn weights_are_rounded_on_request() {
        let half = [[0.5, 0.5, 0.0, 0.0]];
        assert_eq!(weights(&half, Rounding::None), None);
        let sixteen_bits = vec![0, 128, 255, 127, 0, 0, 0, 0];
        assert_eq!(weights(&half, Rounding::Weights), Some((ComponentType::U16, sixteen_bits)));
        for (four, bytes) in [(half[0], [128, 127, 0, 0]), ([0.25, 0.25, 0.1, 0.0], [64, 64, 26, 0])] {
            let rounded = weights(&[four], Rounding::WeightsAndRotations);
            assert_eq!(rounded, Some((ComponentType::U8, bytes.to_vec())));
        }
        for bad in [[1.5, 0.0, 0.0, 0.0], [1.5, -0.5, 0.0, 0.0], [f64::NAN, 1.0, 0.0, 0.0]] {
            for rounding in [Rounding::Weights, Rounding::WeightsAndRotations] {
                assert_eq!(weights(&[bad], rounding), None, "{bad:?}");
            }
        }
    }
}
