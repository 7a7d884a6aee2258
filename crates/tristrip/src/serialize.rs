//! Serialization with `serde`: options by the names of the command line, strips and collapse sequences as lists of numbers. Nothing is
//! deserialized that the library's functions would not have made.
//!
//! ```text
//! Layout, Cost, Filter …   "restart"                       VertexCache        "fifo:16"
//! Method                   "tunnel" · "tunnel length=5"     parameters that are not the default follow the name
//! Effort                   5
//! Strips                   vertices, ends, keeps_order, welds
//! CollapseSequence         vertex_count, triangles, renames, rename_ends, errors; from the full mesh to the base mesh
//! ```

use std::fmt::Display;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Error as _, Serialize, Serializer};

use crate::collapse::{CollapseSequence, Rename};
use crate::effort::Effort;
use crate::lod::Encoding;
use crate::lod::{Filter, RepairOptions};
use crate::mesh::VertexWelds;
use crate::simplify::{AttributeWeights, Price, SimplifyOptions};
use crate::strip::{Cost, Layout, Strips};
use crate::stripify::{
    EtaOptions, FaceTriangulation, Method, Objective, Patches, Start, StripifyOptions, Ties,
};
use crate::vertex_cache::{FlushPolicy, Replacement, VertexCache};

/// Serializes a value as it is written. A value that would not be parsed is refused.
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
    Layout,
    Objective,
    Patches,
    Price,
    Replacement,
    Start,
    Ties,
    VertexCache,
);

/// Returns the parameters of a method, by the names of their flags.
fn parameters(method: Method) -> Vec<(&'static str, String)> {
    match method {
        Method::StripeLocal { triangulation, ties } => {
            vec![("triangulation", triangulation.to_string()), ("ties", ties.to_string())]
        }
        Method::StripeGlobal { patches, cutoff } => {
            vec![("patches", patches.to_string()), ("cutoff", cutoff.to_string())]
        }
        Method::Tunnel { length } => vec![("length", length.to_string())],
        Method::Eta(eta) => vec![
            ("length", eta.length().to_string()),
            ("threshold", eta.threshold().to_string()),
            ("start", eta.start().to_string()),
        ],
        _ => Vec::new(),
    }
}

/// Returns a method with another value of a parameter; `None` if it has no such parameter, or no such value.
fn with_parameter(method: Method, name: &str, value: &str) -> Option<Method> {
    Some(match (method, name) {
        (Method::StripeLocal { ties, .. }, "triangulation") => {
            Method::StripeLocal { triangulation: value.parse().ok()?, ties }
        }
        (Method::StripeLocal { triangulation, .. }, "ties") => {
            Method::StripeLocal { triangulation, ties: value.parse().ok()? }
        }
        (Method::StripeGlobal { cutoff, .. }, "patches") => {
            Method::StripeGlobal { patches: value.parse().ok()?, cutoff }
        }
        (Method::StripeGlobal { patches, .. }, "cutoff") => {
            Method::StripeGlobal { patches, cutoff: value.parse().ok()? }
        }
        (Method::Tunnel { .. }, "length") => Method::Tunnel { length: value.parse().ok()? },
        (Method::Eta(eta), _) => Method::Eta(eta_with(eta, name, value)?),
        _ => return None,
    })
}

fn eta_with(eta: EtaOptions, name: &str, value: &str) -> Option<EtaOptions> {
    match name {
        "length" => Some(eta.with_length(value.parse().ok()?)),
        "threshold" => Some(eta.with_threshold(value.parse().ok()?)),
        "start" => Some(eta.with_start(value.parse().ok()?)),
        _ => None,
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut text = self.name().to_owned();
        let usual: Method = text.parse().map_err(S::Error::custom)?;
        for ((name, value), (_, usual)) in parameters(*self).into_iter().zip(parameters(usual)) {
            if value != usual {
                text = format!("{text} {name}={value}");
            }
        }
        to.serialize_str(&text)
    }
}

impl<'de> Deserialize<'de> for Method {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = <std::borrow::Cow<'de, str>>::deserialize(from)?;
        let mut words = text.split(' ');
        let method = words.next().unwrap_or_default().parse().map_err(D::Error::custom)?;
        words.try_fold(method, |method, word| {
            let parameter =
                word.split_once('=').and_then(|(name, value)| with_parameter(method, name, value));
            parameter
                .ok_or_else(|| D::Error::custom(format!("found `{word}`, expected a parameter of {method}")))
        })
    }
}

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

/// The fields of [`StripifyOptions`]. Without an effort it is the default of the method.
#[derive(serde::Serialize, serde::Deserialize, Default)]
#[serde(rename = "StripifyOptions", default, deny_unknown_fields)]
struct StripifyFields {
    method: Method,
    cost: Cost,
    effort: Option<Effort>,
    vertex_cache: VertexCache,
    objective: Objective,
    weld: bool,
    seed: u64,
}

impl Serialize for StripifyOptions {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let fields = StripifyFields {
            method: self.method(),
            weld: self.weld(),
            seed: self.seed(),
            cost: self.cost(),
            effort: self.set_effort(),
            vertex_cache: self.vertex_cache(),
            objective: self.objective(),
        };
        fields.serialize(to)
    }
}

impl<'de> Deserialize<'de> for StripifyOptions {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let fields = StripifyFields::deserialize(from)?;
        let options = Self::default()
            .with_method(fields.method)
            .with_weld(fields.weld)
            .with_seed(fields.seed)
            .with_cost(fields.cost)
            .with_vertex_cache(fields.vertex_cache)
            .with_objective(fields.objective);
        Ok(fields.effort.map_or(options, |effort| options.with_effort(effort)))
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
    /// None for components that stay: not every format has infinity.
    vanishing: Vec<Option<f32>>,
    permissive: bool,
    weights: WeightFields,
    price: Price,
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
            self.vanishing().iter().map(|&error| (error >= 0.0 && error.is_finite()).then_some(error));
        let fields = SimplifyFields {
            triangle_count: self.triangle_count(),
            error: self.error(),
            locked: self.locked().to_vec(),
            locked_borders: self.locks_borders(),
            vanishing: vanishing.collect(),
            permissive: self.is_permissive(),
            weights: (*self.weights()).into(),
            price: self.price(),
        };
        fields.serialize(to)
    }
}

impl<'de> Deserialize<'de> for SimplifyOptions {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let fields = SimplifyFields::deserialize(from)?;
        let vanishing = fields.vanishing.into_iter().map(|error| error.unwrap_or(f32::INFINITY)).collect();
        let options = Self::default()
            .with_triangles(fields.triangle_count)
            .with_locked(fields.locked)
            .with_locked_borders(fields.locked_borders)
            .with_vanishing(vanishing)
            .with_permissive(fields.permissive)
            .with_weights(fields.weights.into())
            .with_price(fields.price);
        let options = match fields.error {
            Some(error) => options.with_error(error),
            None => options,
        };
        options.check_limits().map_err(D::Error::custom)?;
        Ok(options)
    }
}

/// The fields of [`RepairOptions`].
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "RepairOptions", default, deny_unknown_fields)]
struct RepairFields {
    effort: Effort,
    seed: u64,
    cost: Cost,
}

impl From<RepairOptions> for RepairFields {
    fn from(options: RepairOptions) -> Self {
        Self { effort: options.effort(), seed: options.seed(), cost: options.cost() }
    }
}

impl Default for RepairFields {
    fn default() -> Self {
        RepairOptions::default().into()
    }
}

impl Serialize for RepairOptions {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        RepairFields::from(*self).serialize(to)
    }
}

impl<'de> Deserialize<'de> for RepairOptions {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let fields = RepairFields::deserialize(from)?;
        Ok(Self::default().with_effort(fields.effort).with_seed(fields.seed).with_cost(fields.cost))
    }
}

/// The fields of [`Strips`].
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Strips", deny_unknown_fields)]
struct StripsFields {
    vertices: Vec<u32>,
    ends: Vec<u32>,
    keeps_order: bool,
    welds: Vec<(u32, u32)>,
}

impl Serialize for Strips {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let ends = self.iter().scan(0, |end, strip| {
            *end += strip.len() as u32;
            Some(*end)
        });
        let fields = StripsFields {
            vertices: self.vertices().to_vec(),
            ends: ends.collect(),
            keeps_order: self.keeps_order(),
            welds: self.welds().iter().collect(),
        };
        fields.serialize(to)
    }
}

impl<'de> Deserialize<'de> for Strips {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let fields = StripsFields::deserialize(from)?;
        let strips = Self::from_parts(fields.vertices, fields.ends).map_err(D::Error::custom)?;
        let welds = VertexWelds::from_pairs(fields.welds).map_err(D::Error::custom)?;
        let strips = strips.with_welds(welds);
        Ok(if fields.keeps_order { strips.with_kept_order() } else { strips })
    }
}

/// The fields of [`CollapseSequence`]; the triangles that a collapse drops follow from the others.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "CollapseSequence", deny_unknown_fields)]
struct SequenceFields {
    vertex_count: u32,
    triangles: Vec<u32>,
    /// The removed vertex and the kept one.
    renames: Vec<(u32, u32)>,
    rename_ends: Vec<u32>,
    errors: Vec<f32>,
}

impl Serialize for CollapseSequence {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let renames = self.iter().flat_map(|collapse| collapse.renames);
        let ends = self.iter().scan(0, |end, collapse| {
            *end += collapse.renames.len() as u32;
            Some(*end)
        });
        let fields = SequenceFields {
            vertex_count: self.vertex_count() as u32,
            triangles: self.triangles().to_vec(),
            renames: renames.map(|rename| (rename.removed, rename.kept)).collect(),
            rename_ends: ends.collect(),
            errors: self.iter().map(|collapse| collapse.error).collect(),
        };
        fields.serialize(to)
    }
}

impl<'de> Deserialize<'de> for CollapseSequence {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let SequenceFields { vertex_count, triangles, renames, rename_ends: ends, errors } =
            SequenceFields::deserialize(from)?;
        let (last, count) = (ends.last().copied().unwrap_or(0), ends.len());
        if !ends.is_sorted() || last as usize != renames.len() || count != errors.len() {
            let renames = renames.len();
            let found = format!("{renames} renames, {count} ends up to {last}, {} errors", errors.len());
            return Err(D::Error::custom(format!(
                "collapses: found {found}, expected an end and an error for each"
            )));
        }
        let renames: Vec<Rename> =
            renames.into_iter().map(|(removed, kept)| Rename { removed, kept }).collect();
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let of_collapse = |(start, end): (u32, u32)| &renames[start as usize..end as usize];
        let collapses = starts.zip(ends.iter().copied()).map(of_collapse).zip(errors);
        Self::from_collapses(vertex_count as usize, triangles, collapses).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Faces, Mesh};
    use crate::simplify::simplify;
    use crate::stripify::stripify;
    use serde::de::DeserializeOwned;

    fn round_trip<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T) -> String {
        let json = serde_json::to_string(value).unwrap();
        assert_eq!(serde_json::from_str::<T>(&json).unwrap(), *value, "{json}");
        json
    }

    fn refuses<T: DeserializeOwned + std::fmt::Debug>(json: &str, why: &str) {
        let error = serde_json::from_str::<T>(json).unwrap_err().to_string();
        assert!(error.contains(why), "{json}: {error}");
    }

    #[test]
    fn options_have_the_names_of_the_command() {
        for method in Method::ALL {
            assert_eq!(round_trip(method), format!("\"{method}\""));
        }
        let eta = EtaOptions::default().with_threshold(7).with_start(Start::Sgi);
        assert_eq!(round_trip(&Method::Eta(eta)), r#""eta threshold=7 start=sgi""#);
        assert_eq!(round_trip(&Method::Tunnel { length: 5 }), r#""tunnel length=5""#);
        round_trip(&Method::StripeGlobal { patches: Patches::Full, cutoff: 0 });
        let local = Method::StripeLocal { triangulation: FaceTriangulation::Partial, ties: Ties::LookAhead };
        assert_eq!(round_trip(&local), r#""stripe-local triangulation=partial ties=look-ahead""#);
        assert_eq!(round_trip(&Layout::Separate), r#""separate""#);
        assert_eq!(round_trip(&VertexCache::lru(24)), r#""lru:24""#);
        assert!(serde_json::to_string(&VertexCache::fifo(0)).is_err());
        let options = StripifyOptions::default().with_method(local).with_weld(true).with_seed(u64::MAX);
        let options = options.with_cost(Cost::Gl).with_objective(Objective::Misses).with_effort(Effort::MAX);
        assert!(round_trip(&options).contains(r#""effort":9"#));
        assert!(round_trip(&StripifyOptions::default()).contains(r#""effort":null"#));
        let usual = StripifyOptions::default().effort();
        assert!(round_trip(&StripifyOptions::default().with_effort(usual)).contains(r#""effort":2"#));
        round_trip(&RepairOptions::default().with_seed(3).with_cost(Cost::Restart));
        round_trip(
            &SimplifyOptions::default().with_triangles(7).with_error(0.5).with_locked(vec![true, false]),
        );
        round_trip(
            &SimplifyOptions::default()
                .with_locked_borders(true)
                .with_vanishing(vec![0.5, f32::INFINITY])
                .with_permissive(true)
                .with_weights(AttributeWeights { uv: 0.5, ..AttributeWeights::NONE })
                .with_price(Price::Planes),
        );
        assert_eq!(serde_json::from_str::<StripifyOptions>("{}").unwrap(), StripifyOptions::default());
    }

    #[test]
    fn wrong_options_are_refused() {
        refuses::<Method>(r#""tunnel length=-1""#, "a parameter of tunnel");
        refuses::<Method>(r#""best length=1""#, "a parameter of best");
        refuses::<Method>(r#""""#, "method");
        refuses::<Effort>("10", "found 10, expected 0 to 9");
        refuses::<VertexCache>(r#""fifo:0""#, "N from 1");
        refuses::<StripifyOptions>(r#"{"methods":"best"}"#, "unknown field");
        refuses::<RepairOptions>(r#"{"cost":"cheap"}"#, "cost");
        refuses::<SimplifyOptions>(r#"{"error":-1.0}"#, "0 or more");
    }

    #[test]
    fn strips_and_collapses_come_back() {
        let at = |i: u32| [(i % 5) as f32, (i / 5) as f32, 0.0];
        let quads = (0..16).map(|i| i / 4 * 5 + i % 4).map(|i| [i, i + 1, i + 6, i + 5]);
        let faces = Faces::from_polygons(quads).unwrap();
        // The two halves share no vertices until they are welded.
        let positions: Vec<_> = (0..50).map(|i| at(i % 25)).collect();
        let corners = faces.corners().iter().enumerate().map(|(i, &v)| if i < 32 { v } else { v + 25 });
        let mesh = Mesh::new(positions, faces.with_corners(corners.collect()).unwrap()).unwrap();
        let strips = stripify(&mesh, &StripifyOptions::default().with_weld(true)).unwrap();
        assert!(!strips.welds().is_empty());
        round_trip(&strips);
        round_trip(&strips.with_kept_order());
        round_trip(&Strips::default());
        let sequence = simplify(&mesh, &SimplifyOptions::default()).unwrap().simplification.sequence;
        assert!(!sequence.is_empty());
        round_trip(&sequence);
        round_trip(&CollapseSequence::default());
    }

    #[test]
    fn wrong_strips_and_collapses_are_refused() {
        let strips = |ends: &str, welds: &str| {
            format!(r#"{{"vertices":[0,1,2],"ends":{ends},"keeps_order":false,"welds":{welds}}}"#)
        };
        assert!(serde_json::from_str::<Strips>(&strips("[3]", "[[4,1]]")).is_ok());
        for ends in ["[2]", "[4]", "[3,2]", "[]"] {
            refuses::<Strips>(&strips(ends, "[]"), "by ends that never decrease");
        }
        for welds in ["[[1,1]]", "[[2,1],[1,0]]", "[[1,0],[2,1]]", "[[1,0],[1,2]]"] {
            refuses::<Strips>(&strips("[3]", welds), "welds");
        }
        let sequence = |count: &str, renames: &str, ends: &str, errors: &str| {
            let rest = format!(r#""renames":{renames},"rename_ends":{ends},"errors":{errors}"#);
            format!(r#"{{"vertex_count":{count},"triangles":[0,1,2,2,1,3],{rest}}}"#)
        };
        assert!(serde_json::from_str::<CollapseSequence>(&sequence("4", "[[3,2]]", "[1]", "[0.5]")).is_ok());
        let wrong = [
            (sequence("3", "[[3,2]]", "[1]", "[0.5]"), "found vertex index 3"),
            (sequence("4", "[[3,2]]", "[2]", "[0.5]"), "ends up to 2"),
            (sequence("4", "[[3,2]]", "[1]", "[]"), "0 errors"),
            (sequence("4", "[[3,2],[2,0]]", "[2,1]", "[0.5,1]"), "ends up to 1"),
            (sequence("4", "[[3,3]]", "[1]", "[0.5]"), "3 renamed to 3"),
            (sequence("4", "[[3,4294967295]]", "[1]", "[0.5]"), "3 renamed to 4294967295"),
            (sequence("4", "[[3,2]]", "[1]", "[-0.5]"), "0 or more"),
            (sequence("4294967295", "[]", "[]", "[]"), "limit"),
        ];
        wrong.iter().for_each(|(json, why)| refuses::<CollapseSequence>(json, why));
    }
}
