//! Simplifies the parts of a model separately, with the vertices that parts share locked.

use std::borrow::Cow;

use tristrip::PositionIds;
use tristrip::simplify::{self, AttributeWeights, Simplification};
use tristrip::{Error, Faces, Mesh};

use crate::parts::map;

/// The ratio of vertices to corners above which a part is simplified over its used vertices only: thousands of parts may share one
/// long vertex list.
const SPARSE: usize = 16;

/// The vertices of a part that a reduced mesh has, ascending; `None` if it has all of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct UsedVertices(Option<Vec<u32>>);

impl UsedVertices {
    /// Returns the number of vertices of the reduced mesh; `None` if it is not reduced.
    pub(crate) fn count(&self) -> Option<usize> {
        self.0.as_ref().map(Vec::len)
    }

    /// Converts vertices of the part to vertices of the reduced mesh.
    pub(crate) fn inward(&self, vertices: &mut [u32]) {
        if let Some(used) = &self.0 {
            vertices.iter_mut().for_each(|v| *v = used.partition_point(|&u| u < *v) as u32);
        }
    }

    /// Converts vertices of the reduced mesh to vertices of the part.
    pub(crate) fn outward(&self, vertices: &mut [u32]) {
        if let Some(used) = &self.0 {
            vertices.iter_mut().for_each(|v| *v = used[*v as usize]);
        }
    }
}

/// A part reduced to its used vertices, with their attributes, if it uses few of many; otherwise the part itself.
pub(crate) struct Compact<'a> {
    pub(crate) mesh: Cow<'a, Mesh>,
    pub(crate) used: UsedVertices,
}

impl<'a> Compact<'a> {
    /// Reduces a part to the vertices of the triangles to simplify.
    pub(crate) fn new(mesh: &'a Mesh, triangles: &[u32]) -> Result<Self, Error> {
        if mesh.vertex_count() / SPARSE <= triangles.len() {
            return Ok(Self { mesh: Cow::Borrowed(mesh), used: UsedVertices(None) });
        }
        let mut used = triangles.to_vec();
        used.sort_unstable();
        used.dedup();
        let reduced = mesh.select_vertices(&used)?;
        Ok(Self { mesh: Cow::Owned(reduced), used: UsedVertices(Some(used)) })
    }
}

/// A part to simplify.
pub(crate) struct Part<'a> {
    pub(crate) compact: Compact<'a>,
    /// Over the vertices of `compact`.
    triangles: Vec<u32>,
    /// The mesh that the collapses see, if it is not the part's own: it has the same vertices, with fewer attributes.
    pub(crate) simplified: Option<Mesh>,
    /// Which vertices are locked, because other parts use their positions; empty if none is.
    locked: Vec<bool>,
}

impl<'a> Part<'a> {
    /// Builds the parts of a model from their meshes and triangles, and locks the vertices that parts share.
    pub(crate) fn of_all(parts: Vec<(&'a Mesh, Vec<u32>)>) -> Result<Vec<Self>, Error> {
        let compacted = parts.into_iter().map(|(mesh, mut triangles)| {
            let compact = Compact::new(mesh, &triangles)?;
            compact.used.inward(&mut triangles);
            Ok(Self { compact, triangles, simplified: None, locked: Vec::new() })
        });
        let mut parts: Vec<Self> = compacted.collect::<Result<_, Error>>()?;
        if parts.len() > 1 {
            lock(&mut parts)?;
        }
        Ok(parts)
    }

    /// Returns the triangles, over the vertices of the reduced mesh.
    pub(crate) fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Returns the number of triangles.
    pub(crate) fn triangle_count(&self) -> usize {
        self.triangles.len() / 3
    }

    /// Returns the number of locked vertices.
    pub(crate) fn locked_count(&self) -> usize {
        self.locked.iter().filter(|&&locked| locked).count()
    }
}

/// Locks the vertices whose position a triangle of another part uses.
fn lock(parts: &mut [Part<'_>]) -> Result<(), Error> {
    let drawn: Vec<Mesh> = parts
        .iter()
        .map(|part| part.compact.mesh.with_faces(Faces::from_triangles(part.triangles.clone())?))
        .collect::<Result<_, Error>>()?;
    let ids = PositionIds::default().faces(&drawn.iter().collect::<Vec<_>>())?;
    let id_count = ids.corners().iter().max().map_or(0, |&id| id as usize + 1);
    // The part that uses a position, counted from 1; 0 for none, `several` for more than one.
    let mut users = vec![0_usize; id_count];
    let several = parts.len() + 1;
    let mut corners = ids.corners();
    for (part, mesh) in drawn.iter().enumerate() {
        let (own, rest) = corners.split_at(mesh.faces().corner_count());
        for &id in own {
            let user = &mut users[id as usize];
            *user = if *user == 0 || *user == part + 1 { part + 1 } else { several };
        }
        corners = rest;
    }
    let mut corners = ids.corners();
    for part in parts {
        let (own, rest) = corners.split_at(part.triangles.len());
        if own.iter().any(|&id| users[id as usize] == several) {
            part.locked = vec![false; part.compact.mesh.vertex_count()];
            for (&id, &vertex) in own.iter().zip(&part.triangles) {
                part.locked[vertex as usize] |= users[id as usize] == several;
            }
        }
        corners = rest;
    }
    Ok(())
}

/// Simplifies each part to its own number of triangles, or until the error would exceed the maximum, in mesh units. The results are in the
/// order of the parts.
pub(crate) fn simplify_all(
    parts: &[Part<'_>],
    shares: &[usize],
    error: Option<f32>,
    weights: AttributeWeights,
) -> Result<Vec<Simplification>, Error> {
    let with_shares: Vec<_> = parts.iter().zip(shares).collect();
    let done = map(&with_shares, |(part, share)| {
        let mut options = simplify::SimplifyOptions::default().with_triangles(**share).with_weights(weights);
        if let Some(error) = error {
            options = options.with_error(error);
        }
        if !part.locked.is_empty() {
            options = options.with_locked(part.locked.clone());
        }
        let mesh = part.simplified.as_ref().unwrap_or(&part.compact.mesh);
        simplify::simplify_triangles(mesh, part.triangles.clone(), &options)
    });
    done.into_iter().collect()
}

/// Counts the triangles of each base mesh.
pub(crate) fn base_triangles(done: &[Simplification]) -> Result<Vec<usize>, Error> {
    done.iter().map(|done| done.sequence.triangle_count(0)).collect()
}

/// Returns the largest error of all collapses, in mesh units.
pub(crate) fn surface_error(done: &[Simplification]) -> Result<f32, Error> {
    done.iter().try_fold(0.0, |largest: f32, done| Ok(largest.max(done.sequence.error(0)?)))
}

/// Returns the diagonal of the bounding box of all triangles, in mesh units.
pub(crate) fn diagonal(parts: &[Part<'_>]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for part in parts {
        for &vertex in &part.triangles {
            for (axis, &x) in part.compact.mesh.positions()[vertex as usize].iter().enumerate() {
                low[axis] = low[axis].min(x.into());
                high[axis] = high[axis].max(x.into());
            }
        }
    }
    let squares = (0..3).map(|axis| (high[axis] - low[axis]).max(0.0).powi(2));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::{Attribute, AttributeData};

    fn strip_of(length: usize, y: f32) -> (Mesh, Vec<u32>) {
        let positions: Vec<[f32; 3]> =
            (0..2 * length as u32).map(|i| [(i / 2) as f32, y + (i % 2) as f32, 0.0]).collect();
        let triangles = (0..length as u32 - 1)
            .flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3]);
        (Mesh::new(positions, Faces::default()).unwrap(), triangles.collect())
    }

    #[test]
    fn shared_positions_are_locked() {
        let (lower, upper, far) = (strip_of(4, 0.0), strip_of(4, 1.0), strip_of(3, 7.0));
        let parts = [&lower, &upper, &far].map(|(mesh, triangles)| (mesh, triangles.clone()));
        let parts = Part::of_all(parts.to_vec()).unwrap();
        assert_eq!(parts.iter().map(Part::locked_count).collect::<Vec<_>>(), [4, 4, 0]);
        assert!(parts[0].locked.iter().enumerate().all(|(v, &locked)| locked == (v % 2 == 1)));
        assert!((diagonal(&parts) - (3.0_f64 * 3.0 + 8.0 * 8.0).sqrt()).abs() < 1e-9);
        assert_eq!(diagonal(&[]).to_bits(), 0);
    }

    #[test]
    fn few_of_many_vertices_are_renumbered_and_restored() {
        let positions: Vec<[f32; 3]> = (0..1000).map(|i| [i as f32, 0.0, 0.0]).collect();
        let mesh = Mesh::new(positions, Faces::default()).unwrap();
        let data = AttributeData::U16((0..1000).collect());
        let number = Attribute { name: "number".into(), components: 1, normalized: false, data };
        let mesh = mesh.with_attribute(number).unwrap();
        let parts = Part::of_all(vec![(&mesh, vec![900, 5, 77])]).unwrap();
        let kept = &parts[0].compact.mesh.attributes()[0].data;
        assert_eq!(*kept, AttributeData::U16(vec![5, 77, 900]), "attributes decide where seams are");

        assert_eq!(parts[0].triangles, [2, 0, 1]);
        assert_eq!(
            parts[0].compact.mesh.positions()[2].map(f32::to_bits),
            [900.0_f32, 0.0, 0.0].map(f32::to_bits)
        );
        let mut back = parts[0].triangles.clone();
        parts[0].compact.used.outward(&mut back);
        assert_eq!(back, [900, 5, 77]);
    }
}
