//! Strips and collapse sequences as lists of numbers, checked on deserialization.

use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Serialize, Serializer};

use crate::collapse::{CollapseSequence, Rename};
use crate::mesh::VertexWelds;
use crate::strip::Strips;
use crate::text::counted;

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

/// The fields of [`CollapseSequence`]. The triangles that a collapse removes are computed from
/// these fields.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "CollapseSequence", deny_unknown_fields)]
struct SequenceFields {
    vertex_count: u32,
    triangles: Vec<u32>,
    /// Pairs of the removed vertex and the kept one.
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
            let [renames, ends, errors] =
                [(renames.len(), "rename"), (count, "end"), (errors.len(), "error")]
                    .map(|(count, noun)| counted(count, noun));
            let found = format!("{renames}, {ends} up to {last}, {errors}");
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
