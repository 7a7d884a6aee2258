//! Serialization with `serde`. Options use their command-line names; strips and collapse sequences
//! are lists of numbers. Deserialization rejects data that the library's functions could not have
//! produced.
//!
//! ```text
//! Layout, Cost, Filter …   "restart"                       VertexCache        "fifo:16"
//! Method                   "tunnel" · "tunnel length=5"     with the non-default parameters
//! Effort                   5
//! Strips                   vertices, ends, keeps_order, welds
//! CollapseSequence         vertex_count, triangles, renames, rename_ends, errors (full to base)
//! ```

mod methods;
mod sequences;
#[cfg(test)]
mod tests;

use std::fmt::Display;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Error as _, Serialize, Serializer};

use crate::effort::Effort;
use crate::lod::{Encoding, Filter};
use crate::simplify::{AttributeWeights, Price, SimplifyOptions};
use crate::strip::{Cost, Layout};
use crate::stripify::{FaceTriangulation, LastTie, Objective, Patches, Start, Ties};
use crate::vertex_cache::{FlushPolicy, Replacement, VertexCache};

/// Serializes a value as its text form. Fails if the text cannot be parsed back.
fn write_name<T: Display + FromStr + PartialEq, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    let name = value.to_string();
    if name.parse().is_ok_and(|parsed: T| parsed == *value) {
        return to.serialize_str(&name);
    }
    Err(S::Error::custom(format!("`{name}` has no name that can be parsed")))
}

fn parse_name<'de, T: FromStr<Err: Display>, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    let name = <std::borrow::Cow<'de, str>>::deserialize(from)?;
    name.parse().map_err(D::Error::custom)
}

macro_rules! by_name {
    ($($type:ty),+ $(,)?) => {$(
        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                write_name(self, to)
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                parse_name(from)
            }
        }
    )+};
}

by_name!(
    Cost,
    Encoding,
    FaceTriangulation,
    Filter,
    FlushPolicy,
    LastTie,
    Layout,
    Objective,
    Patches,
    Price,
    Replacement,
    Start,
    Ties,
    VertexCache,
);

impl Serialize for Effort {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_u8(self.level())
    }
}

impl<'de> Deserialize<'de> for Effort {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let level = u8::deserialize(from)?;
        Self::new(level).ok_or_else(|| D::Error::custom(format!("effort: found {level}, expected 0 to 9")))
    }
}

/// The fields of [`SimplifyOptions`].
#[derive(serde::Serialize, serde::Deserialize, Default)]
#[serde(rename = "SimplifyOptions", default, deny_unknown_fields)]
struct SimplifyFields {
    triangle_count: usize,
    error: Option<f32>,
    locked: Vec<bool>,
    locked_borders: bool,
    /// `None` for components that are kept, because not every format can represent infinity.
    vanishing: Vec<Option<f32>>,
    permissive: bool,
    weights: WeightFields,
    price: Price,
    weld_distance: f32,
}

/// The fields of [`AttributeWeights`].
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "AttributeWeights", default, deny_unknown_fields)]
struct WeightFields {
    normal: f32,
    uv: f32,
    colour: f32,
    tangent: f32,
    skin: f32,
}

impl Default for WeightFields {
    fn default() -> Self {
        AttributeWeights::default().into()
    }
}

impl From<AttributeWeights> for WeightFields {
    fn from(AttributeWeights { normal, uv, colour, tangent, skin }: AttributeWeights) -> Self {
        Self { normal, uv, colour, tangent, skin }
    }
}

impl From<WeightFields> for AttributeWeights {
    fn from(WeightFields { normal, uv, colour, tangent, skin }: WeightFields) -> Self {
        Self { normal, uv, colour, tangent, skin }
    }
}

impl Serialize for SimplifyOptions {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let vanishing =
            self.vanishing.iter().map(|&error| (error >= 0.0 && error.is_finite()).then_some(error));
        let fields = SimplifyFields {
            triangle_count: self.triangle_count,
            error: self.error,
            locked: self.locked.clone(),
            locked_borders: self.locked_borders,
            vanishing: vanishing.collect(),
            permissive: self.permissive,
            weights: self.weights.into(),
            price: self.price,
            weld_distance: self.weld_distance,
        };
        fields.serialize(to)
    }
}

impl<'de> Deserialize<'de> for SimplifyOptions {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let fields = SimplifyFields::deserialize(from)?;
        let vanishing = fields.vanishing.into_iter().map(|error| error.unwrap_or(f32::INFINITY)).collect();
        let options = Self {
            triangle_count: fields.triangle_count,
            error: fields.error,
            locked: fields.locked,
            error_factors: Vec::new(),
            locked_borders: fields.locked_borders,
            vanishing,
            permissive: fields.permissive,
            weights: fields.weights.into(),
            price: fields.price,
            weld_distance: fields.weld_distance,
        };
        options.check_limits().map_err(D::Error::custom)?;
        Ok(options)
    }
}
