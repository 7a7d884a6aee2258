//! Normals of simplified parts. They are kept with the vertices, repaired where they do not fit the
//! remaining faces, or rebuilt from these faces.
//!
//! In a flat-shaded part, every edge is a normal seam, and seams block nearly all collapses. Such a
//! part is simplified by its shape and its other attributes. Each corner then gets the normal of
//! its face, and vertices are split where these normals differ.
//!
//! # Algorithm
//! 1. A part is rebuilt if it is flat-shaded, or if it has normals and the user requests it
//!    ([`Normals`]). A part is not rebuilt if its vertices cannot change in the file, or if a morph
//!    target changes its normals.
//! 2. Its collapses ignore normals and tangents: vertices that differ only in these do not form a
//!    seam.
//! 3. Other parts with flat sides are repaired if normals that do not fit would cover a larger
//!    fraction of their area than before. Without the repair, the vertices of a collapsed bevel
//!    would darken the sides next to it. Normals that fit are kept.
//! 4. The base mesh gets normals from its faces ([`Shading`]), and tangents from its texture
//!    coordinates. A new vertex is a copy of an old one with another normal and tangent, and with
//!    its fitted position. Vertices with equal attributes are merged.

mod mode;
mod tangents;

use std::collections::{BTreeMap, HashMap};

use tristrip::normals::{NormalFit, Shading};
use tristrip::{Attribute, Faces, Mesh, VertexWelds};
use tristrip_io::{Format, Model, NewValues, NewVertices, Redrawn};

use super::order::PartCollapses;
use super::parts::Part;
use crate::error::Error;
use crate::parts::map;
use crate::text::counted;
pub use mode::{Normals, PartNormals};
use tangents::tangents;

/// The growth of the area share with normals that do not fit ([`NormalFit`]) above which the
/// normals of a part are repaired. At a fifth of the triangles, the growth is 0.01 for a duck, and
/// 0.12 for a truck with dark smears.
const MAX_UNFIT: f64 = 0.02;

/// The share of flat sides above which the normals of a part are repaired. It is 0.65 for the body
/// of a truck, 0.44 for its wheels, 0.28 for a cloth with 115,200 triangles, and 0.11 for a man.
/// Without flat sides, the kept normals are closer to those of the original surface than normals of
/// the few remaining faces.
const FLAT_SIDES: f64 = 0.33;

/// How the normals of a part are computed.
#[derive(Debug, Clone, Copy)]
enum Making {
    /// From the remaining faces. Collapses ignore normals.
    Rebuilt(Shading),
    /// From the remaining faces, but only where the normals of the vertices do not fit.
    Repaired(Shading),
}

/// How the normals of each part are computed; `None` if they are kept.
pub(super) struct Rebuilding {
    of_parts: Vec<Option<Making>>,
    pub(super) notes: Vec<String>,
}

impl Rebuilding {
    /// Chooses the parts whose normals are rebuilt, and removes normals and tangents from their
    /// meshes to simplify.
    pub(super) fn choose(
        normals: Normals,
        model: &Model,
        format: Format,
        parts: &mut [Part<'_>],
    ) -> Result<Self, Error> {
        let shading = |part: &Part<'_>| match normals {
            Normals::Auto => Shading::of_flat(&part.compact.mesh, part.triangles()),
            Normals::Keep => Ok(None),
            Normals::Rebuild => Shading::of(&part.compact.mesh, part.triangles()),
        };
        let found: Result<Vec<Option<Shading>>, _> = map(parts, shading).into_iter().collect();
        let (found, notes) = changeable(found?, model, format, parts)?;
        for (part, shading) in parts.iter_mut().zip(&found) {
            if shading.is_some() {
                part.simplified = Some(without_directions(&part.compact.mesh)?);
            }
        }
        let of_parts = found.into_iter().map(|shading| shading.map(Making::Rebuilt)).collect();
        Ok(Self { of_parts, notes })
    }

    /// Chooses the simplified parts whose normals are repaired, because many kept normals do not
    /// fit the remaining faces.
    pub(super) fn choose_unfit(
        &mut self,
        model: &Model,
        format: Format,
        parts: &[Part<'_>],
        done: &[PartCollapses],
    ) -> Result<(), Error> {
        let all: Vec<_> = parts.iter().zip(done).zip(&self.of_parts).collect();
        let shading = |((part, done), making): &((&Part<'_>, &PartCollapses), &Option<Making>)| {
            if making.is_some() || done.sequence.is_empty() {
                return Ok(None);
            }
            let mesh = &*part.compact.mesh;
            let Some(before) = NormalFit::of(mesh, part.triangles())? else { return Ok(None) };
            let after = NormalFit::of(mesh, done.sequence.drawn(0)?.as_flattened())?.unwrap_or_default();
            let is_unfit = before.flat >= FLAT_SIDES && after.unfit - before.unfit > MAX_UNFIT;
            if is_unfit { Shading::of(mesh, part.triangles()) } else { Ok(None) }
        };
        let found: Result<Vec<Option<Shading>>, tristrip::Error> = map(&all, shading).into_iter().collect();
        let (found, notes) = changeable(found?, model, format, parts)?;
        for (making, shading) in self.of_parts.iter_mut().zip(found) {
            *making = making.or(shading.map(Making::Repaired));
        }
        self.notes.extend(notes);
        Ok(())
    }

    /// Counts the parts per treatment of their normals.
    pub(super) fn counts(&self, parts: &[Part<'_>]) -> PartNormals {
        let mut counts = PartNormals::default();
        for (part, making) in parts.iter().zip(&self.of_parts) {
            match making {
                None => counts.kept += usize::from(has(&part.compact.mesh, "NORMAL")),
                Some(Making::Repaired(_)) => counts.repaired += 1,
                Some(Making::Rebuilt(shading)) if shading.is_flat() => counts.flat += 1,
                Some(Making::Rebuilt(_)) => counts.creased += 1,
            }
        }
        counts
    }

    /// Builds the new vertices of parts that are rebuilt or have moved positions.
    pub(super) fn rebuild(
        &self,
        parts: &[Part<'_>],
        done: &[PartCollapses],
        fitted: &[Option<Mesh>],
    ) -> Result<Vec<Option<RebuiltPart>>, Error> {
        let all: Vec<_> = parts.iter().zip(done).zip(&self.of_parts).zip(fitted).collect();
        let rebuilt = map(&all, |(((part, done), making), fitted)| {
            let is_changed = making.is_some() || fitted.is_some();
            is_changed.then(|| RebuiltPart::new(part, done, **making, fitted.as_ref())).transpose()
        });
        rebuilt.into_iter().collect()
    }
}

/// Removes the parts whose vertices cannot change. Returns a note per reason.
fn changeable(
    mut shadings: Vec<Option<Shading>>,
    model: &Model,
    format: Format,
    parts: &[Part<'_>],
) -> Result<(Vec<Option<Shading>>, Vec<String>), Error> {
    let mut reasons = Vec::new();
    if shadings.iter().any(Option::is_some) {
        let fixed = tristrip_io::fixed_vertices(model, NewValues::Directions, format)?;
        for ((shading, part), fixed) in shadings.iter_mut().zip(parts).zip(fixed) {
            let mesh = &part.compact.mesh;
            let bare = || (has(mesh, "TANGENT") && !has(mesh, "TEXCOORD_0")).then(|| NO_TEXTURE.to_owned());
            if let Some(why) = shading.and(fixed.or_else(bare)) {
                *shading = None;
                reasons.push(why);
            }
        }
    }
    Ok((shadings, kept_notes("normals", reasons)))
}

/// Returns a note per reason why parts keep their values.
pub(super) fn kept_notes(what: &str, reasons: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut by_reason: BTreeMap<String, usize> = BTreeMap::new();
    reasons.into_iter().for_each(|why| *by_reason.entry(why).or_default() += 1);
    let note = |(why, parts)| format!("kept the {what} of {}: {why}", counted(parts, "part"));
    by_reason.into_iter().map(note).collect()
}

const NO_TEXTURE: &str = "their tangents need texture coordinates (TEXCOORD_0)";

/// The vertices that were added to a part, as copies with other normals or positions.
#[derive(Debug, Clone)]
pub(super) struct Copies {
    /// The index of the first copy.
    pub(super) first: u32,
    /// The source vertex of each copy.
    pub(super) sources: Vec<u32>,
}

/// A simplified part with new vertices.
pub(super) struct RebuiltPart {
    /// The new vertices, as copies of vertices of the reduced part.
    new: NewVertices,
    /// The triangles over the new vertices.
    triangles: Vec<u32>,
    /// The vertices of the reduced part, followed by the new ones.
    pub(super) mesh: Mesh,
}

impl RebuiltPart {
    /// Builds the new vertices for a treatment of normals, and for the mesh with new positions, if
    /// there is one.
    fn new(
        part: &Part<'_>,
        done: &PartCollapses,
        making: Option<Making>,
        fitted: Option<&Mesh>,
    ) -> Result<Self, Error> {
        let old = &*part.compact.mesh;
        let mesh = fitted.unwrap_or(old);
        let mut base = done.sequence.drawn(0)?.into_flattened();
        // Merge vertices with equal attributes, so that triangles of one plane share vertices.
        if let Some(simplified) = &part.simplified {
            let welds = VertexWelds::of(&simplified.with_faces(Faces::from_triangles(base.clone())?)?);
            base.iter_mut().for_each(|v| *v = welds.vertex(*v));
        }
        let normals = match making {
            Some(Making::Rebuilt(shading)) => shading.corner_normals(mesh, part.triangles(), &base)?,
            Some(Making::Repaired(shading)) => shading.repaired_normals(mesh, part.triangles(), &base)?,
            None => Vec::new(),
        };
        let tangents = if making.is_some() { tangents(mesh, &base, &normals)? } else { Vec::new() };
        let mut numbers = HashMap::new();
        let mut new = NewVertices::default();
        let mut triangles = Vec::with_capacity(base.len());
        for (corner, &source) in base.iter().enumerate() {
            let (normal, tangent) = (normals.get(corner), tangents.get(corner));
            let key = (
                source,
                normal.map(|normal| normal.map(f32::to_bits)),
                tangent.map(|tangent| tangent.map(f32::to_bits)),
            );
            let number = *numbers.entry(key).or_insert_with(|| {
                new.sources.push(source);
                new.normals.extend(normal);
                new.tangents.extend(tangent);
                new.positions.extend(fitted.map(|fitted| fitted.positions()[source as usize]));
                new.sources.len() as u32 - 1
            });
            triangles.push(number);
        }
        Ok(Self { mesh: new.behind(old)?, new, triangles })
    }

    /// Returns the triangles over the vertices of `mesh`.
    pub(super) fn triangles_of_mesh(&self) -> Vec<u32> {
        let first = (self.mesh.vertex_count() - self.new.sources.len()) as u32;
        self.triangles.iter().map(|&v| v + first).collect()
    }
}

/// Returns the model with the triangles of each part, given over its old vertices. A rebuilt part
/// uses its new vertices instead, and equal vertices are merged.
pub(super) fn redraw(
    model: &Model,
    parts: &[Part<'_>],
    rebuilt: &[Option<RebuiltPart>],
    mut triangles: Vec<Vec<u32>>,
    format: Format,
) -> Result<(Redrawn, Vec<Option<Copies>>), Error> {
    if rebuilt.iter().all(Option::is_none) {
        tristrip_io::merge_equal_vertices(model, &mut triangles, format)?;
        let redrawn = tristrip_io::with_triangles(model, triangles, format)?;
        return Ok((redrawn, vec![None; parts.len()]));
    }
    let mut added = Vec::with_capacity(parts.len());
    for ((part, rebuilt), triangles) in parts.iter().zip(rebuilt).zip(&mut triangles) {
        added.push(rebuilt.as_ref().map(|rebuilt| {
            let mut new = rebuilt.new.clone();
            part.compact.used.outward(&mut new.sources);
            triangles.clone_from(&rebuilt.triangles);
            new
        }));
    }
    let extended = tristrip_io::with_new_vertices(model, &added, format)?;
    for (triangles, first) in triangles.iter_mut().zip(&extended.first) {
        triangles.iter_mut().for_each(|v| *v += first.unwrap_or(0));
    }
    tristrip_io::merge_equal_vertices(&extended.model, &mut triangles, format)?;
    let redrawn = tristrip_io::with_triangles(&extended.model, triangles, format)?;
    let copies = |(new, first): (Option<NewVertices>, Option<u32>)| {
        new.zip(first).map(|(new, first)| Copies { first, sources: new.sources })
    };
    Ok((redrawn, added.into_iter().zip(extended.first).map(copies).collect()))
}

fn has(mesh: &Mesh, name: &str) -> bool {
    mesh.attributes().iter().any(|attribute| attribute.name == name)
}

/// Returns the mesh without normals, tangents and faces.
fn without_directions(mesh: &Mesh) -> Result<Mesh, Error> {
    let mut bare = Mesh::new(mesh.shared_positions(), Faces::default())?;
    let is_other = |attribute: &&Attribute| !["NORMAL", "TANGENT"].contains(&attribute.name.as_str());
    for attribute in mesh.attributes().iter().filter(is_other) {
        bare = bare.with_attribute(attribute.clone())?;
    }
    Ok(bare)
}
