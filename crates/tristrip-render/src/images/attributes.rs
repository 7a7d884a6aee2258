//! Converts vertex attributes of any type to floats.

use tristrip::{Attribute, AttributeData};

/// Returns the first values of a vertex as floats. Normalized integers become fractions of their
/// range. Missing components are zero.
pub(super) fn values<const N: usize>(attribute: &Attribute, vertex: u32) -> [f32; N] {
    let components = usize::from(attribute.components);
    std::array::from_fn(|i| {
        let at = vertex as usize * components + i;
        if i < components { value(attribute, at).unwrap_or_default() } else { 0.0 }
    })
}

fn value(attribute: &Attribute, at: usize) -> Option<f32> {
    let (value, range) = match &attribute.data {
        AttributeData::F32(all) => return all.get(at).copied(),
        AttributeData::F64(all) => return Some(*all.get(at)? as f32),
        AttributeData::U8(all) => (f64::from(*all.get(at)?), f64::from(u8::MAX)),
        AttributeData::I8(all) => (f64::from(*all.get(at)?), f64::from(i8::MAX)),
        AttributeData::U16(all) => (f64::from(*all.get(at)?), f64::from(u16::MAX)),
        AttributeData::I16(all) => (f64::from(*all.get(at)?), f64::from(i16::MAX)),
        AttributeData::U32(all) => (f64::from(*all.get(at)?), f64::from(u32::MAX)),
        AttributeData::I32(all) => (f64::from(*all.get(at)?), f64::from(i32::MAX)),
    };
    Some(if attribute.normalized { (value / range).max(-1.0) as f32 } else { value as f32 })
}
