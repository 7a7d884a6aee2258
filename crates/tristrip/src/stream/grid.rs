//! Positions and attributes on grids.

use super::channels::ChannelKind;
use super::fans::GridPlace;
use crate::error::Error;
use crate::mesh::{Attribute, AttributeData};

/// The position grid. All axes have the same step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    pub(super) origin: [f32; 3],
    pub(super) step: f32,
}

impl Grid {
    /// Creates the grid of finite positions, with a number of bits per coordinate.
    pub(super) fn new(positions: impl Iterator<Item = [f32; 3]>, bits: u32) -> Self {
        let (mut least, mut most) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for position in positions {
            for j in 0..3 {
                least[j] = least[j].min(position[j]);
                most[j] = most[j].max(position[j]);
            }
        }
        let size = |j: usize| f64::from(most[j]) - f64::from(least[j]);
        let extent = (0..3).map(size).fold(0.0, f64::max);
        let step = extent / f64::from((1_u32 << bits) - 1);
        // Rounded up, so the last step reaches the far end.
        let mut rounded = step as f32;
        if f64::from(rounded) < step {
            rounded = rounded.next_up();
        }
        if extent > 0.0 {
            Self { origin: least, step: rounded }
        } else {
            Self { origin: least.map(finite), step: 0.0 }
        }
    }

    /// Returns whether all positions of the grid are finite.
    pub(super) fn is_finite(&self, bits: u32) -> bool {
        let far = f64::from(self.step) * f64::from(1_u32 << bits);
        let is_finite = |x: &f32| (f64::from(*x) + far).abs() <= f64::from(f32::MAX);
        self.step >= 0.0 && self.origin.iter().all(is_finite)
    }

    pub(super) fn place(&self, position: [f32; 3], bits: u32) -> GridPlace {
        let most = f64::from((1_u32 << bits) - 1);
        let steps = |j: usize| (f64::from(position[j]) - f64::from(self.origin[j])) / f64::from(self.step);
        [0, 1, 2].map(|j| if self.step > 0.0 { (steps(j) + 0.5).floor().clamp(0.0, most) as i32 } else { 0 })
    }

    /// Returns the center of the positions that a grid position with unknown low bits can
    /// represent.
    pub(super) fn position(&self, place: GridPlace, unknown_bits: u32) -> [f32; 3] {
        let half = f64::from((1_u32 << unknown_bits) - 1) / 2.0;
        let steps = |j: usize| f64::from(place[j]) * f64::from(1_u32 << unknown_bits) + half;
        [0, 1, 2].map(|j| (f64::from(self.origin[j]) + steps(j) * f64::from(self.step)) as f32)
    }

    /// Returns the maximum error of a position, in mesh units.
    pub(super) fn error(&self, unknown_bits: u32) -> f32 {
        (f64::from(self.step) * f64::from(1_u32 << unknown_bits) * 0.75_f64.sqrt()) as f32
    }
}

fn finite(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}

/// The type of the values of an attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum AttributeType {
    F32,
    F64,
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
}

impl AttributeType {
    pub(super) const ALL: [Self; 8] =
        [Self::F32, Self::F64, Self::U8, Self::I8, Self::U16, Self::I16, Self::U32, Self::I32];

    fn of(data: &AttributeData) -> Self {
        match data {
            AttributeData::F32(_) => Self::F32,
            AttributeData::F64(_) => Self::F64,
            AttributeData::U8(_) => Self::U8,
            AttributeData::I8(_) => Self::I8,
            AttributeData::U16(_) => Self::U16,
            AttributeData::I16(_) => Self::I16,
            AttributeData::U32(_) => Self::U32,
            AttributeData::I32(_) => Self::I32,
        }
    }

    #[expect(clippy::cast_sign_loss, reason = "a negative number becomes 0")]
    fn data(self, values: impl Iterator<Item = f64>) -> AttributeData {
        match self {
            Self::F32 => AttributeData::F32(values.map(|x| x as f32).collect()),
            Self::F64 => AttributeData::F64(values.collect()),
            Self::U8 => AttributeData::U8(values.map(|x| (x + 0.5).floor() as u8).collect()),
            Self::I8 => AttributeData::I8(values.map(|x| (x + 0.5).floor() as i8).collect()),
            Self::U16 => AttributeData::U16(values.map(|x| (x + 0.5).floor() as u16).collect()),
            Self::I16 => AttributeData::I16(values.map(|x| (x + 0.5).floor() as i16).collect()),
            Self::U32 => AttributeData::U32(values.map(|x| (x + 0.5).floor() as u32).collect()),
            Self::I32 => AttributeData::I32(values.map(|x| (x + 0.5).floor() as i32).collect()),
        }
    }
}

/// An attribute, and the grid of its values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) components: u8,
    pub(super) normalized: bool,
    pub(super) value_type: AttributeType,
    pub(super) kind: ChannelKind,
    pub(super) bits: u32,
    /// The minimum of each component, and the step of a linear channel.
    pub(super) origins: Vec<f64>,
    pub(super) step: f64,
}

/// The name of the attribute that stores the part of each vertex, if a mesh has several parts.
pub const PART: &str = "part";

/// Bits per component of attributes that are not integers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct AttributeBits {
    pub(super) normal: u32,
    pub(super) uv: u32,
    pub(super) other: u32,
}

/// The maximum number of bits of integers that are stored exactly.
const MAX_EXACT_BITS: u32 = 24;

impl Channel {
    /// Chooses the grid of an attribute.
    #[expect(clippy::cast_sign_loss, reason = "an extent is not negative")]
    pub(super) fn new(attribute: &Attribute, bits: AttributeBits) -> Result<Self, Error> {
        let components = usize::from(attribute.components);
        let mut channel = Self {
            name: attribute.name.clone(),
            components: attribute.components,
            normalized: attribute.normalized,
            value_type: AttributeType::of(&attribute.data),
            kind: ChannelKind::Linear,
            bits: 0,
            origins: Vec::new(),
            step: 0.0,
        };
        let value = |i: usize| raw(&attribute.data, i);
        if let Some(i) = (0..attribute.data.len()).find(|&i| !value(i).is_finite()) {
            let found =
                format!("{} of vertex {} in attribute `{}`", value(i), i / components, attribute.name);
            return Err(Error::Parameter { name: "attributes", found, expected: "finite numbers" });
        }
        let is_float = matches!(channel.value_type, AttributeType::F32 | AttributeType::F64);
        let is = |name: &str| attribute.name == name || attribute.name.starts_with(&format!("{name}_"));
        if is_float && is("NORMAL") && components == 3 || is_float && is("TANGENT") && components == 4 {
            let is_unit = |i: usize| {
                let square: f64 = (0..3).map(|j| value(i * components + j).powi(2)).sum();
                (square - 1.0).abs() < 0.02 && (components == 3 || [1.0, -1.0].contains(&value(i * 4 + 3)))
            };
            if (0..attribute.data.len() / components).all(is_unit) {
                channel.kind = if components == 3 { ChannelKind::Octahedral } else { ChannelKind::Tangent };
                channel.bits = bits.normal;
                return Ok(channel);
            }
        }
        let mut most = vec![f64::NEG_INFINITY; components];
        channel.origins = vec![f64::INFINITY; components];
        for i in 0..attribute.data.len() {
            let j = i % components;
            channel.origins[j] = channel.origins[j].min(value(i));
            most[j] = most[j].max(value(i));
        }
        if attribute.data.is_empty() {
            channel.origins = vec![0.0; components];
            most = vec![0.0; components];
        }
        let extent = most.iter().zip(&channel.origins).map(|(a, b)| a - b).fold(0.0, f64::max);
        if !extent.is_finite() {
            let found =
                format!("values of attribute `{}` from {:?} to {most:?}", attribute.name, channel.origins);
            return Err(Error::Parameter { name: "attributes", found, expected: "finite differences" });
        }
        // Integers such as feature ids, even if they are stored as floats.
        let is_whole = !is_float || (0..attribute.data.len()).all(|i| value(i).fract() == 0.0);
        if is_whole && extent < f64::from(1_u32 << MAX_EXACT_BITS) {
            channel.step = 1.0;
            channel.bits = u32::BITS - (extent as u32).leading_zeros();
            if is("JOINTS") || attribute.name == PART {
                channel.kind = ChannelKind::Names;
            }
            return Ok(channel);
        }
        channel.bits = match () {
            () if !is_float => MAX_EXACT_BITS,
            () if is("TEXCOORD") => {
                // Each repeat of a texture gets the same number of steps.
                let repeats = extent.ceil().clamp(1.0, f64::from(1_u32 << MAX_EXACT_BITS)) as u32;
                (bits.uv + repeats.next_power_of_two().ilog2()).min(MAX_EXACT_BITS)
            }
            () => bits.other,
        };
        let is_share = |component: usize| channel.origins[component] >= 0.0 && most[component] <= 1.0;
        if is("WEIGHTS") && (0..components).all(is_share) {
            // Use shares of one, so that their sum remains one.
            channel.origins = vec![0.0; components];
            channel.step = 1.0 / f64::from((1_u32 << channel.bits) - 1);
        } else {
            channel.step = extent / f64::from((1_u32 << channel.bits) - 1);
        }
        Ok(channel)
    }

    /// Returns the number of integers per vertex.
    pub(super) fn width(&self) -> usize {
        match self.kind {
            ChannelKind::Octahedral => 2,
            ChannelKind::Tangent => 3,
            ChannelKind::Linear | ChannelKind::Names => self.components.into(),
        }
    }

    /// Returns the integers of a vertex.
    pub(super) fn integers(&self, attribute: &Attribute, vertex: usize) -> Vec<i32> {
        let components = usize::from(self.components);
        let value = |j: usize| raw(&attribute.data, vertex * components + j);
        let most = f64::from((1_u32 << self.bits) - 1);
        if matches!(self.kind, ChannelKind::Octahedral | ChannelKind::Tangent) {
            let mut integers = octahedral([value(0), value(1), value(2)], most).to_vec();
            integers.extend((components == 4).then(|| i32::from(value(3) < 0.0)));
            return integers;
        }
        let steps = |j: usize| {
            let steps = if self.step > 0.0 { (value(j) - self.origins[j]) / self.step } else { 0.0 };
            (steps + 0.5).floor().clamp(0.0, most)
        };
        let mut integers: Vec<i32> = (0..components).map(|j| steps(j) as i32).collect();
        let is_of_shares =
            self.step.to_bits() == (1.0 / most).to_bits() && self.origins.iter().all(|&origin| origin == 0.0);
        if self.name.starts_with("WEIGHTS_") && self.value_type == AttributeType::F32 && is_of_shares {
            let sum: f64 = (0..components).map(value).sum();
            if (sum - 1.0).abs() < 1e-3 {
                // The largest one absorbs the rounding error.
                let rest = most as i32 - integers.iter().sum::<i32>();
                if let Some(largest) = integers.iter_mut().max() {
                    *largest += rest;
                }
            }
        }
        integers
    }

    /// Returns the attribute with the values of integers.
    pub(super) fn attribute(&self, integers: &[i32]) -> Attribute {
        let most = f64::from((1_u32 << self.bits) - 1);
        let width = self.width().max(1);
        let vertices = integers.chunks_exact(width);
        let values: Vec<f64> = match self.kind {
            ChannelKind::Octahedral | ChannelKind::Tangent => {
                let unit = |vertex: &[i32]| {
                    let [x, y, z] = unit_vector([vertex[0], vertex[1]], most);
                    let sign = vertex.get(2).map(|&sign| if sign == 0 { 1.0 } else { -1.0 });
                    [Some(x), Some(y), Some(z), sign].into_iter().flatten()
                };
                vertices.flat_map(unit).collect()
            }
            ChannelKind::Linear | ChannelKind::Names => {
                let value = |(j, &integer): (usize, &i32)| self.origins[j] + f64::from(integer) * self.step;
                vertices.flat_map(|vertex| vertex.iter().enumerate().map(value)).collect()
            }
        };
        Attribute {
            name: self.name.clone(),
            components: self.components,
            normalized: self.normalized,
            data: self.value_type.data(values.into_iter()),
        }
    }
}

/// Returns a stored value without normalization.
fn raw(data: &AttributeData, i: usize) -> f64 {
    match data {
        AttributeData::F32(v) => v[i].into(),
        AttributeData::F64(v) => v[i],
        AttributeData::U8(v) => v[i].into(),
        AttributeData::I8(v) => v[i].into(),
        AttributeData::U16(v) => v[i].into(),
        AttributeData::I16(v) => v[i].into(),
        AttributeData::U32(v) => v[i].into(),
        AttributeData::I32(v) => v[i].into(),
    }
}

/// Maps a unit vector to an octahedron, unfolded to a square of `most` steps.
fn octahedral([x, y, z]: [f64; 3], most: f64) -> [i32; 2] {
    let sum = x.abs() + y.abs() + z.abs();
    let [u, v] = if sum > 0.0 { [x / sum, y / sum] } else { [0.0; 2] };
    let fold = |a: f64, b: f64| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
    let [u, v] = if z < 0.0 { [fold(u, v), fold(v, u)] } else { [u, v] };
    [u, v].map(|t| (f64::midpoint(t, 1.0) * most + 0.5).floor().clamp(0.0, most) as i32)
}

fn unit_vector(steps: [i32; 2], most: f64) -> [f64; 3] {
    let [u, v] = steps.map(|t| f64::from(t) / most * 2.0 - 1.0);
    let z = 1.0 - u.abs() - v.abs();
    let below = (-z).max(0.0);
    let fold = |t: f64| if t < 0.0 { t + below } else { t - below };
    let vector = [fold(u), fold(v), z];
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    vector.map(|x| x / length)
}
