//! Arrays in smaller types: joints and indices where the smaller type holds every value; weights where it holds every value exactly, or
//! rounded on request.
//!
//! # Algorithm
//! 1. Each accessor that has one meaning everywhere, with values one directly after the other, is decoded.
//! 2. Joints become 8 bits, and indices of points, lines and triangle lists the smallest type in which no index has the highest value.
//! 3. Weights become 8 bits where each is exactly k/255. With rounding each becomes ⌊255 w⌋/255, and those with the largest remainders
//!    1/255 more, so that the four of a vertex sum to 1 as the specification requires, if they did before.

#![allow(clippy::cast_sign_loss, reason = "indices, joints and weights are not negative")]

use std::collections::BTreeMap;

use serde_json::json;

use super::packing::{NewAccessors, Packing, Rounding, entry_mut};
use crate::error::Error;
use crate::gltf::accessor::AccessorValues;
use crate::gltf::bounds::number;
use crate::gltf::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::component::ComponentType;
use crate::gltf::document::{Located, array, index, items, values, whole};
use crate::gltf::json::{Content, Members, Value};
use crate::gltf::permute::VERTEX_FACTOR;
use crate::gltf::references::skin_and_animation_accessors;
use crate::gltf::spec::TRIANGLES;

/// The greatest difference between 1 and the sum of a vertex's weights, above which the sum is not meant to be 1.
const SUM_TOLERANCE: f64 = 1e-3;

/// What the values of an accessor mean.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meaning {
    Joints,
    /// All weights of a vertex.
    Weights,
    Indices,
    Other,
}

/// Gives accessors smaller types.
pub(super) fn narrow(scene: &mut Packing, rounding: Rounding) -> Result<(), Error> {
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    let root = &scene.document.root;
    let mut new = NewAccessors::of(root)?;
    let mut replaced = Vec::new();
    for (accessor, meaning) in meanings(root)? {
        if meaning == Meaning::Other || accessor < scene.fixed.accessors {
            continue;
        }
        let number = Value::from(accessor);
        let reference = Located { value: &number, at: format!("accessors[{accessor}]") };
        // What cannot be decoded stays as it is.
        let Ok(values) = scene.resolver().values(&reference) else { continue };
        let is_plain =
            values.is_packed() && !values.matrix && budget.try_charge(values.count, 2 * values.element);
        if let Some((component, bytes)) =
            Some(values).filter(|_| is_plain).and_then(|v| narrowed(&v, meaning, rounding))
        {
            // The smaller values are elsewhere, without their old bounds.
            let old = array(root, "accessors")?.get(accessor).and_then(Value::as_object);
            let Some(mut members) = old.cloned() else { continue };
            ["byteOffset", "min", "max", "sparse"].into_iter().for_each(|name| members.remove(name));
            members.insert("componentType", u64::from(component.code()));
            if meaning == Meaning::Weights {
                members.insert("normalized", Value::from(json!(true)));
            }
            replaced.push((accessor, new.add(&bytes, Content::Object(members))));
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

/// Returns the meaning of each accessor that primitives use.
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
            // In the other modes the highest value may be a restart.
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

/// Returns the values in a smaller type.
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
        return weights(all.as_chunks::<4>().0, rounding).map(|bytes| (ComponentType::U8, bytes));
    }
    let highest = all.clone().fold(0.0, f64::max);
    // An index may not have the highest value of its type.
    let one = f64::from(u8::from(meaning == Meaning::Indices));
    match component {
        _ if highest + one <= 255.0 => Some((ComponentType::U8, all.map(|x| x as u8).collect())),
        ComponentType::U32 if highest + one <= 65535.0 => {
            Some((ComponentType::U16, all.flat_map(|x| (x as u16).to_le_bytes()).collect()))
        }
        _ => None,
    }
}

/// Returns weights in 8 bits: the same ones or, with rounding, those with a sum of 255 that are nearest.
fn weights(all: &[[f64; 4]], rounding: Rounding) -> Option<Vec<u8>> {
    let exact = |&weight: &f64| {
        let eight_bits = (0.0..=1.0).contains(&weight).then(|| (weight * 255.0).round())?;
        (f64::from(eight_bits as f32 / 255.0).to_bits() == weight.to_bits()).then_some(eight_bits as u8)
    };
    if let Some(bytes) = all.iter().flatten().map(exact).collect::<Option<Vec<u8>>>() {
        let sums = bytes.chunks(4).all(|four| four.iter().map(|&w| u32::from(w)).sum::<u32>() == 255);
        if sums {
            return Some(bytes);
        }
    }
    if rounding == Rounding::None {
        return None;
    }
    let mut out = Vec::with_capacity(4 * all.len());
    for four in all {
        if !four.iter().all(|weight| (0.0..=1.0 + SUM_TOLERANCE).contains(weight)) {
            return None;
        }
        let is_one = (four.iter().sum::<f64>() - 1.0).abs() <= SUM_TOLERANCE;
        let four = four.map(|weight| 255.0 * weight);
        out.extend(if is_one { rounded(four) } else { four.map(|weight| weight.round() as u8) });
    }
    Some(out)
}

/// Rounds four numbers up or down, so that their sum is 255; it is already, but for the tolerance.
fn rounded(four: [f64; 4]) -> [u8; 4] {
    let mut out = four.map(|x| x as u8);
    let mut order = [0, 1, 2, 3];
    let remainder = |i: usize| four[i] - f64::from(out[i]);
    order.sort_by(|&a, &b| remainder(b).total_cmp(&remainder(a)));
    let missing = 255_usize.saturating_sub(out.iter().map(|&w| usize::from(w)).sum());
    order.into_iter().take(missing).for_each(|i| out[i] = out[i].saturating_add(1));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_weights_are_near_and_sum_to_one() {
        let mut tried = 0;
        for a in 0..40 {
            for b in 0..40 - a {
                let (x, y) = (f64::from(a) / 41.3, f64::from(b) / 41.3);
                let all = [x, y, (1.0 - x - y) / 3.0, (1.0 - x - y) / 1.5];
                let [four] = [rounded(all.map(|w| 255.0 * w))];
                assert_eq!(four.iter().map(|&w| u32::from(w)).sum::<u32>(), 255);
                for (weight, byte) in all.iter().zip(four) {
                    assert!((weight - f64::from(byte) / 255.0).abs() < 1.0 / 255.0);
                    tried += 1;
                }
            }
        }
        assert!(tried > 3000);
    }

    #[test]
    fn weights_become_bytes_without_rounding_only_if_they_are_exact() {
        let exact = |k: [u8; 4]| k.map(|k| f64::from(f32::from(k) / 255.0));
        assert_eq!(
            weights(&[exact([255, 0, 0, 0]), exact([1, 254, 0, 0])], Rounding::None).unwrap(),
            [255, 0, 0, 0, 1, 254, 0, 0]
        );
        let half = [[0.5, 0.5, 0.0, 0.0]];
        assert!(weights(&half, Rounding::None).is_none());
        assert_eq!(weights(&half, Rounding::WeightsAndRotations).unwrap(), [128, 127, 0, 0]);
        assert_eq!(
            weights(&[[0.25, 0.25, 0.1, 0.0]], Rounding::WeightsAndRotations).unwrap(),
            [64, 64, 26, 0]
        );
        for bad in [[1.5, 0.0, 0.0, 0.0], [1.5, -0.5, 0.0, 0.0], [f64::NAN, 1.0, 0.0, 0.0]] {
            assert!(weights(&[bad], Rounding::WeightsAndRotations).is_none(), "{bad:?}");
        }
    }
}
