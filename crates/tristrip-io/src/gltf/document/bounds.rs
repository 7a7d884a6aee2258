//! The minimum and maximum of each component of an accessor.

use serde_json::json;

use crate::error::Error;
use crate::gltf::document::accessor::AccessorValues;
use crate::gltf::document::json::Value;
use crate::gltf::document::spec::ComponentType;

/// Returns `min` and `max` of an accessor, or `None` if a value is not finite.
///
/// # Errors
/// The sparse indices are not ascending.
pub(in crate::gltf) fn bounds(values: &AccessorValues<'_>) -> Result<Option<[Value; 2]>, Error> {
    let raw = values.raw()?;
    let offsets: Vec<usize> = values.component_offsets().collect();
    let mut lowest = vec![f64::INFINITY; offsets.len()];
    let mut highest = vec![f64::NEG_INFINITY; offsets.len()];
    for value in raw.chunks_exact(values.element) {
        for ((&offset, low), high) in offsets.iter().zip(&mut lowest).zip(&mut highest) {
            let x = number(values.component, &value[offset..]);
            if !x.is_finite() {
                return Ok(None);
            }
            (*low, *high) = (low.min(x), high.max(x));
        }
    }
    let is_float = values.component == ComponentType::F32;
    let list = |all: Vec<f64>| {
        let number = |x: f64| if is_float { json!(x) } else { json!(x as i64) };
        Value::from(all.into_iter().map(number).collect::<serde_json::Value>())
    };
    Ok(Some([list(lowest), list(highest)]))
}

/// Reads a component as a 64-bit float, which is exact. Returns NaN if `bytes` is too short.
pub(in crate::gltf) fn number(component: ComponentType, bytes: &[u8]) -> f64 {
    match (component, bytes) {
        (ComponentType::I8, &[a, ..]) => i8::from_le_bytes([a]).into(),
        (ComponentType::U8, &[a, ..]) => a.into(),
        (ComponentType::I16, &[a, b, ..]) => i16::from_le_bytes([a, b]).into(),
        (ComponentType::U16, &[a, b, ..]) => u16::from_le_bytes([a, b]).into(),
        (ComponentType::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]).into(),
        (ComponentType::F32, &[a, b, c, d, ..]) => f32::from_le_bytes([a, b, c, d]).into(),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_type_are_exact() {
        let bytes = [0xFE, 0xFF, 0xFF, 0xFF];
        let all = [
            ComponentType::I8,
            ComponentType::U8,
            ComponentType::I16,
            ComponentType::U16,
            ComponentType::U32,
        ];
        let found = all.map(|component| number(component, &bytes));
        let expected: [f64; 5] = [-2.0, 254.0, -2.0, 65534.0, 4_294_967_294.0];
        assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits));
        let float = number(ComponentType::F32, &0.1_f32.to_le_bytes());
        assert_eq!(float.to_bits(), f64::from(0.1_f32).to_bits());
        assert!(number(ComponentType::U16, &[1]).is_nan());
    }
}
