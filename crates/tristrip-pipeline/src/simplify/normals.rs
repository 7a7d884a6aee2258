//! Normals of simplified parts: kept with the vertices, or rebuilt from the faces that are left.
//!
//! In a flat-shaded part every edge is a seam of normals, along which hardly anything can collapse. Such a part is simplified
//! by its shape and its other attributes; then each corner gets the normal of its face, and vertices are split where these differ.
//!
//! # Algorithm
//! 1. A part is rebuilt if it is flat-shaded, or has normals at all and the user wants it ([`Normals`]); unless its vertices cannot change in
//!    the file, or its normals mean more than the faces: a morph target changes them.
//! 2. Its collapses see neither normals nor tangents, so that vertices that differ only in these are no seam.
//! 3. The base mesh gets normals by its faces ([`Shading`]), and tangents by its texture coordinates. A new vertex is an old one
//!    with another normal and tangent; vertices of equal attributes count as one.

mod mode;
mod tangents;

use std::collections::{BTreeMap, HashMap};

use tristrip::normals::Shading;
use tristrip::{Attribute, Faces, Mesh, VertexWelds};
use tristrip_io::{Format, Model, NewVertices, Redrawn};

use super::parts::{Part, PartCollapses};
use crate::error::Error;
use crate::parts::map;
use crate::text::counted;
pub use mode::{NormalCounts, Normals};
use tangents::tangents;

/// How the normals of each part are rebuilt; `None` where they are kept.
pub(super) struct Rebuilding {
    of_parts: Vec<Option<Shading>>,
    pub(super) counts: NormalCounts,
    pub(super) notes: Vec<String>,
}

impl Rebuilding {
    /// Chooses the parts whose normals are rebuilt, and takes the normals away from what is simplified of these.
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
        let mut rebuilding = Self { of_parts: found?, counts: NormalCounts::default(), notes: Vec::new() };
        if rebuilding.of_parts.iter().any(Option::is_some) {
            rebuilding.keep_fixed(model, format, parts)?;
        }
        for (part, shading) in parts.iter_mut().zip(&rebuilding.of_parts) {
            let counts = &mut rebuilding.counts;
            match shading {
                None if has(&part.compact.mesh, "NORMAL") => counts.kept += 1,
                None => (),
                Some(shading) if shading.is_flat() => counts.flat += 1,
                Some(_) => counts.creased += 1,
            }
            if shading.is_some() {
                part.simplified = Some(without_directions(&part.compact.mesh)?);
            }
        }
        Ok(rebuilding)
    }

    /// Keeps the normals where vertices cannot change, with one note per reason.
    fn keep_fixed(&mut self, model: &Model, format: Format, parts: &[Part<'_>]) -> Result<(), Error> {
        let mut by_reason: BTreeMap<String, usize> = BTreeMap::new();
        let fixed = tristrip_io::fixed_vertices(model, format)?;
        for ((shading, part), fixed) in self.of_parts.iter_mut().zip(parts).zip(fixed) {
            let mesh = &part.compact.mesh;
            let bare = || (has(mesh, "TANGENT") && !has(mesh, "TEXCOORD_0")).then(|| NO_TEXTURE.to_owned());
            if let Some(why) = shading.and(fixed.or_else(bare)) {
                *shading = None;
                *by_reason.entry(why).or_default() += 1;
            }
        }
        let note = |(why, parts)| format!("kept the normals of {}: {why}", counted(parts, "part"));
        self.notes.extend(by_reason.into_iter().map(note));
        Ok(())
    }

    /// Builds the new vertices of the parts that are rebuilt.
    pub(super) fn rebuild(
        &self,
        parts: &[Part<'_>],
        done: &[PartCollapses],
    ) -> Result<Vec<Option<RebuiltPart>>, Error> {
        let all: Vec<_> = parts.iter().zip(done).zip(&self.of_parts).collect();
        let rebuilt = map(&all, |((part, done), shading)| {
            shading.map(|shading| RebuiltPart::new(part, done, shading)).transpose()
        });
        rebuilt.into_iter().collect()
    }
}

const NO_TEXTURE: &str = "their tangents need texture coordinates (TEXCOORD_0)";

/// A simplified part with new vertices.
pub(super) struct RebuiltPart {
    /// The new vertices, as copies of those of the reduced part.
    new: NewVertices,
    /// The triangles over the new vertices.
    triangles: Vec<u32>,
    /// The vertices of the reduced part, then the new ones.
    pub(super) mesh: Mesh,
}

impl RebuiltPart {
    fn new(part: &Part<'_>, done: &PartCollapses, shading: Shading) -> Result<Self, Error> {
        let mesh = &*part.compact.mesh;
        let mut base = done.sequence.drawn(0)?.into_flattened();
        // Vertices of equal attributes are one, so that triangles of one plane share vertices.
        if let Some(simplified) = &part.simplified {
            let welds = VertexWelds::of(&simplified.with_faces(Faces::from_triangles(base.clone())?)?);
            base.iter_mut().for_each(|v| *v = welds.vertex(*v));
        }
        let normals = shading.corner_normals(mesh, part.triangles(), &base)?;
        let tangents = tangents(mesh, &base, &normals)?;
        let mut numbers = HashMap::new();
        let mut new = NewVertices::default();
        let mut triangles = Vec::with_capacity(base.len());
        for (corner, (&source, normal)) in base.iter().zip(normals).enumerate() {
            let tangent = tangents.get(corner);
            let key = (source, normal.map(f32::to_bits), tangent.map(|tangent| tangent.map(f32::to_bits)));
            let number = *numbers.entry(key).or_insert_with(|| {
                new.sources.push(source);
                new.normals.push(normal);
                new.tangents.extend(tangent);
                new.sources.len() as u32 - 1
            });
            triangles.push(number);
        }
        Ok(Self { mesh: new.behind(mesh)?, new, triangles })
    }

    /// Returns the triangles over the vertices of `mesh`.
    pub(super) fn triangles_of_mesh(&self) -> Vec<u32> {
        let first = (self.mesh.vertex_count() - self.new.sources.len()) as u32;
        self.triangles.iter().map(|&v| v + first).collect()
    }
}

/// Returns the model with the triangles of each part, given over its old vertices; those of a rebuilt part are over new ones instead.
pub(super) fn redraw(
    model: &Model,
    parts: &[Part<'_>],
    rebuilt: Vec<Option<RebuiltPart>>,
    mut triangles: Vec<Vec<u32>>,
    format: Format,
) -> Result<Redrawn, Error> {
    if rebuilt.iter().all(Option::is_none) {
        return Ok(tristrip_io::with_triangles(model, triangles, format)?);
    }
    let mut added = Vec::with_capacity(parts.len());
    for ((part, rebuilt), triangles) in parts.iter().zip(rebuilt).zip(&mut triangles) {
        added.push(rebuilt.map(|mut rebuilt| {
            part.compact.used.outward(&mut rebuilt.new.sources);
            *triangles = rebuilt.triangles;
            rebuilt.new
        }));
    }
    let extended = tristrip_io::with_new_vertices(model, &added, format)?;
    for (triangles, first) in triangles.iter_mut().zip(&extended.first) {
        triangles.iter_mut().for_each(|v| *v += first.unwrap_or(0));
    }
    Ok(tristrip_io::with_triangles(&extended.model, triangles, format)?)
}

fn has(mesh: &Mesh, name: &str) -> bool {
    mesh.attributes().iter().any(|attribute| attribute.name == name)
}

/// Returns the mesh without normals and tangents, and without faces.
fn without_directions(mesh: &Mesh) -> Result<Mesh, Error> {
    let mut bare = Mesh::new(mesh.shared_positions(), Faces::default())?;
    let is_other = |attribute: &&Attribute| !["NORMAL", "TANGENT"].contains(&attribute.name.as_str());
    for attribute in mesh.attributes().iter().filter(is_other) {
        bare = bare.with_attribute(attribute.clone())?;
    }
    Ok(bare)
}
