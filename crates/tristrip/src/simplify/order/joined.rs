//! Simplifies several meshes as one surface, with seams where they touch.
//!
//! A model with several materials has one mesh per material. Where two meshes meet, each has its
//! own vertices at the same positions. If the meshes were simplified separately, they would have to
//! keep all of these vertices, or gaps would open. When they are simplified as one surface, both
//! sides of such a border collapse together, only along the border, and to the same points. The
//! last triangle of a mesh is kept, so no material vanishes.
//!
//! # Algorithm
//! The vertices of all meshes are concatenated into one mesh. Vertices of different meshes are
//! assumed to differ in their attributes, which makes the borders between meshes seams. These seams
//! cost as much as borders of a mesh, since materials meet there. Every rename stays within one
//! mesh, so the collapses can be assigned to their meshes at the end.
//!
//! # Complexity
//! Time and memory are the same as for one mesh with all triangles, plus 12 bytes per vertex.

use super::decimate::Decimation;
use crate::collapse::{CollapseSequence, Rename};
use crate::error::Error;
use crate::ids::check_count;
use crate::mesh::{Mesh, attribute_bits, check_corners};
use crate::simplify::price::attributes::PricedAttributes;
use crate::simplify::{SimplifyOptions, Stopped};

/// The collapses of meshes that were simplified as one surface.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JoinedSimplification {
    /// The collapses of each mesh, over its own vertices.
    pub sequences: Vec<CollapseSequence>,
    /// For each collapse of a mesh, from the full mesh on, the index of the joined collapse that it
    /// belongs to; ascending. Collapses of different meshes with the same index change a shared
    /// border together; applying only one of them opens a gap.
    pub steps: Vec<Vec<u32>>,
    /// For each collapse of the joined surface, the maximum cost so far, as returned by
    /// [`SurfaceSimplifier::cost`].
    pub costs: Vec<f64>,
    /// Why all meshes together have more triangles than requested; `None` if the target was
    /// reached.
    pub stopped: Option<Stopped>,
}

impl JoinedSimplification {}

/// Simplifies several meshes, each with triangles over its vertices, as one surface. The limits of
/// the options apply to all meshes together. Per-vertex options are indexed by the concatenated
/// vertices of all meshes.
///
/// # Errors
/// The number of indices of a mesh is not a multiple of three; an index is out of range; there are
/// more than 2²⁷ triangles; an option is invalid; the meshes together have too many vertices for
/// 32-bit ids.
///
/// ```
/// use tristrip::{Faces, Mesh, simplify::{SimplifyOptions, simplify_joined}};
/// // Two flat strips of 2 × 8 triangles, one above the other. They share the border between them.
/// let strip = |y: f32| {
///     let corners: Vec<[f32; 3]> = (0..18).map(|i| [(i / 2) as f32, y + (i % 2) as f32, 0.0]).collect();
///     Mesh::new(corners, Faces::default())
/// };
/// let triangles: Vec<u32> = (0..8).map(|i| 2 * i).flat_map(|i| [i, i + 2, i + 1, i + 1, i + 2, i + 3]).collect();
/// let (lower, upper) = (strip(0.0)?, strip(1.0)?);
/// let parts = [(&lower, &triangles[..]), (&upper, &triangles[..])];
/// let joined = simplify_joined(&parts, &SimplifyOptions::default().with_triangles(4))?;
/// assert_eq!([joined.sequences[0].triangle_count(0)?, joined.sequences[1].triangle_count(0)?], [2, 2]);
/// assert!(joined.stopped.is_none());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn simplify_joined(
    parts: &[(&Mesh, &[u32])],
    options: &SimplifyOptions,
) -> Result<JoinedSimplification, Error> {
    let mut surface = SurfaceSimplifier::new(parts.to_vec(), options)?;
    surface.simplify_to(options.triangle_count);
    let stopped = (surface.triangle_count() > options.triangle_count).then(|| surface.stopped());
    Ok(JoinedSimplification { stopped, ..surface.finish(options.triangle_count)? })
}

/// Simplifies one or several meshes as one surface, step by step. To distribute a triangle budget
/// across several surfaces, always advance the one whose last collapse was cheapest.
///
/// ```
/// use tristrip::simplify::{SimplifyOptions, SurfaceSimplifier};
/// use tristrip::{Faces, Mesh};
/// // A flat fan of four triangles around vertex 4.
/// let corners = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
/// let (mesh, fan) = (Mesh::new(corners, Faces::default())?, [0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4]);
/// let mut surface = SurfaceSimplifier::new(vec![(&mesh, &fan)], &SimplifyOptions::default())?;
/// assert_eq!(surface.triangle_count(), 4);
/// assert!(surface.simplify_to(3) && surface.triangle_count() == 2);
/// assert!(surface.cost() < 1e-5);
/// assert_eq!(surface.finish(3)?.sequences[0].len(), 1);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug)]
pub struct SurfaceSimplifier<'a> {
    parts: Vec<(&'a Mesh, &'a [u32])>,
    /// The first vertex of each mesh.
    starts: Vec<u32>,
    decimation: Decimation,
    sequence: CollapseSequence,
}

impl<'a> SurfaceSimplifier<'a> {
    /// Joins meshes, each with triangles over its vertices, into one surface. The target number of
    /// triangles in the options is ignored.
    ///
    /// # Errors
    /// The number of indices of a mesh is not a multiple of three; an index is out of range; there
    /// are more than 2²⁷ triangles; an option is invalid; the meshes together have too many
    /// vertices for 32-bit ids.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let options = SimplifyOptions::default();
    /// assert!(SurfaceSimplifier::new(vec![(&grid, &[0, 1, 2])], &options).is_ok());
    /// assert!(SurfaceSimplifier::new(vec![(&grid, &[0, 1, 81])], &options).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(parts: Vec<(&'a Mesh, &'a [u32])>, options: &SimplifyOptions) -> Result<Self, Error> {
        let vertex_count = parts.iter().map(|(mesh, _)| mesh.vertex_count()).sum();
        check_count("vertices", vertex_count)?;
        // 1. Concatenate all vertices and triangles into one mesh.
        let (mut positions, mut triangles) = (Vec::with_capacity(vertex_count), Vec::new());
        let mut starts = Vec::with_capacity(parts.len());
        for (mesh, corners) in &parts {
            check_corners(corners, mesh.vertex_count())?;
            if corners.len() % 3 != 0 {
                CollapseSequence::new(mesh.vertex_count(), corners.to_vec())?;
            }
            let start = positions.len() as u32;
            starts.push(start);
            positions.extend_from_slice(mesh.positions());
            triangles.extend(corners.iter().map(|&v| start + v));
        }
        options.check(vertex_count, triangles.len())?;

        // 2. Prepare what its collapses depend on.
        let mesh_of = |v: u32| starts.partition_point(|&start| start <= v).saturating_sub(1);
        let bits = |v: u32| {
            let part = mesh_of(v);
            let mut bits = (part as u32).to_le_bytes().to_vec();
            bits.extend(attribute_bits(parts[part].0, (v - starts[part]) as usize));
            bits
        };
        let priced = |_: &[u32], unit: f64| {
            let of_part = |(mesh, triangles): &(&Mesh, &[u32])| {
                (PricedAttributes::new(mesh, triangles, unit, options.weights), mesh.vertex_count())
            };
            PricedAttributes::joined(&parts.iter().map(of_part).collect::<Vec<_>>())
        };
        let sequence = CollapseSequence::new(vertex_count, triangles)?;
        let decimation =
            Decimation::new(&positions[..], bits, sequence.triangles(), priced, options, &starts);
        Ok(Self { parts, starts, decimation, sequence })
    }

    /// Returns the number of remaining triangles.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let surface = SurfaceSimplifier::new(vec![(&grid, grid.faces().corners())], &SimplifyOptions::default())?;
    /// assert_eq!(surface.triangle_count(), 128);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangle_count(&self) -> usize {
        self.sequence.triangles_at(0)
    }

    /// Simplifies until at most this many triangles remain or no more collapses are possible.
    /// Returns whether the target was reached. Fewer triangles can remain, because collapses are
    /// applied in batches; [`SurfaceSimplifier::finish`] sorts them by cost.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut surface = SurfaceSimplifier::new(vec![(&grid, grid.faces().corners())], &SimplifyOptions::default())?;
    /// assert!(surface.simplify_to(100) && surface.triangle_count() <= 100);
    /// // The peak and the corners are kept.
    /// assert!(!surface.simplify_to(0) && surface.triangle_count() > 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn simplify_to(&mut self, triangle_count: usize) -> bool {
        self.decimation.run(triangle_count, &mut self.sequence)
    }

    /// Returns the maximum cost of the collapses so far, in cubic mesh units: squared deviations of
    /// the surface and its attributes, times the square root of the affected area. With
    /// [`Price::Quadric`](crate::simplify::Price::Quadric) the cost does not include the area, and
    /// its unit is square mesh units. The cheapest collapse is always next. The surface with the
    /// lowest cost therefore loses least with its next collapse.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut surface = SurfaceSimplifier::new(vec![(&grid, grid.faces().corners())], &SimplifyOptions::default())?;
    /// surface.simplify_to(100);
    /// let flat = surface.cost();
    /// surface.simplify_to(0);
    /// // The side of the peak is more expensive.
    /// assert!(surface.cost() > 1e3 * flat);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn cost(&self) -> f64 {
        f64::from(self.decimation.greatest_cost()) * self.cost_unit()
    }

    /// Returns why the remaining vertices cannot be removed, as counts per reason.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut surface = SurfaceSimplifier::new(vec![(&grid, grid.faces().corners())], &SimplifyOptions::default())?;
    /// surface.simplify_to(0);
    /// assert_eq!(surface.stopped().triangle_count, surface.triangle_count());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn stopped(&mut self) -> Stopped {
        self.decimation.stopped()
    }

    /// Returns the collapses of each mesh in order of cost, until all meshes together have at most
    /// this many triangles. With 0, returns all collapses. `stopped` is `None` in the result.
    ///
    /// # Errors
    /// The triangles of a mesh are invalid. This does not happen after [`SurfaceSimplifier::new`],
    /// which checks them.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut surface = SurfaceSimplifier::new(vec![(&grid, grid.faces().corners())], &SimplifyOptions::default())?;
    /// surface.simplify_to(100);
    /// let count = surface.triangle_count();
    /// let joined = surface.finish(0)?;
    /// assert_eq!(joined.sequences[0].triangle_count(0)?, count);
    /// assert!(joined.costs.is_sorted() && joined.costs.len() == joined.steps[0].len());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn finish(mut self, triangle_count: usize) -> Result<JoinedSimplification, Error> {
        let unit = self.cost_unit();
        let costs = self.decimation.finish(triangle_count, &mut self.sequence);
        let costs = costs.into_iter().map(|cost| f64::from(cost) * unit).collect();
        if self.parts.len() == 1 {
            let steps = (0..self.sequence.len() as u32).collect();
            return Ok(JoinedSimplification {
                sequences: vec![self.sequence],
                steps: vec![steps],
                costs,
                stopped: None,
            });
        }
        let (sequences, steps) = split(&self.sequence, &self.parts, &self.starts)?;
        Ok(JoinedSimplification { sequences, steps, costs, stopped: None })
    }

    /// Returns the unit of costs in the local frame, in mesh units.
    fn cost_unit(&self) -> f64 {
        self.decimation.cost_unit()
    }
}

/// Splits the collapses of the joined mesh among the meshes, with the indices of the joined
/// collapses.
fn split(
    joined: &CollapseSequence,
    parts: &[(&Mesh, &[u32])],
    starts: &[u32],
) -> Result<(Vec<CollapseSequence>, Vec<Vec<u32>>), Error> {
    let empty =
        |(mesh, triangles): &(&Mesh, &[u32])| CollapseSequence::new(mesh.vertex_count(), triangles.to_vec());
    let mut sequences = parts.iter().map(empty).collect::<Result<Vec<_>, Error>>()?;
    let mut steps = vec![Vec::new(); parts.len()];
    let mut first_triangle = 0;
    let first_triangles = parts.iter().map(|(_, triangles)| {
        first_triangle += triangles.len() as u32 / 3;
        first_triangle - triangles.len() as u32 / 3
    });
    let first_triangles: Vec<u32> = first_triangles.collect();
    let (mut renames, mut dropped): (Vec<(usize, Rename)>, Vec<u32>) = (Vec::new(), Vec::new());
    let mut own = Vec::new();
    for (step, collapse) in (0..).zip(joined.iter()) {
        renames.clear();
        renames.extend(collapse.renames.iter().map(|&Rename { removed, kept }| {
            let part = starts.partition_point(|&start| start <= removed) - 1;
            (part, Rename { removed: removed - starts[part], kept: kept - starts[part] })
        }));
        renames.sort_by_key(|&(part, _)| part);
        for of_part in renames.chunk_by(|a, b| a.0 == b.0) {
            let part = of_part[0].0;
            own.clear();
            own.extend(of_part.iter().map(|&(_, rename)| rename));
            let (first, end) =
                (first_triangles[part], first_triangles[part] + parts[part].1.len() as u32 / 3);
            dropped.clear();
            dropped
                .extend(collapse.dropped.iter().filter(|&&t| (first..end).contains(&t)).map(|t| t - first));
            sequences[part].push(&own, &dropped, collapse.error);
            steps[part].push(step);
        }
    }
    Ok((sequences, steps))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::mesh::{Attribute, AttributeData, Faces};

    /// Returns a grid of squares with the given columns, heights `z(x, y)`, and normals or texture
    /// coordinates.
    fn grid(columns: std::ops::Range<u32>, uv: bool) -> (Mesh, Vec<u32>) {
        let (width, height) = (columns.end - columns.start, 12);
        let at = |i: u32| [columns.start + i % (width + 1), i / (width + 1)];
        let points: Vec<[u32; 2]> = (0..(width + 1) * (height + 1)).map(at).collect();
        let bump = |x: u32, y: u32| ((x * 7 + y * 13) % 5) as f32 / 20.0;
        let positions: Vec<[f32; 3]> =
            points.iter().map(|&[x, y]| [x as f32, y as f32, bump(x, y)]).collect();
        let quad = |i: u32| {
            let v = i / width * (width + 1) + i % width;
            [v, v + 1, v + width + 1, v + width + 1, v + 1, v + width + 2]
        };
        let (name, components) = if uv { ("TEXCOORD_0", 2) } else { ("NORMAL", 3) };
        let value =
            |&[x, y]: &[u32; 2]| if uv { vec![x as f32 / 9.0, y as f32] } else { vec![0.0, 0.0, 1.0] };
        let data = AttributeData::F32(points.iter().flat_map(value).collect());
        let mesh = Mesh::new(positions, Faces::default()).unwrap();
        let attribute = Attribute { name: name.into(), components, normalized: false, data };
        (mesh.with_attribute(attribute).unwrap(), (0..width * height).flat_map(quad).collect())
    }

    type BorderEdge = [[u32; 3]; 2];

    /// Returns the edges of one triangle along the line x = 8 in a mesh, as the bits of their
    /// positions.
    fn border(mesh: &Mesh, triangles: &[[u32; 3]]) -> Vec<BorderEdge> {
        let mut count: BTreeMap<BorderEdge, usize> = BTreeMap::new();
        for [a, b, c] in triangles {
            for edge in [[a, b], [b, c], [c, a]] {
                let mut edge = edge.map(|&v| mesh.positions()[v as usize].map(f32::to_bits));
                edge.sort_unstable();
                *count.entry(edge).or_default() += 1;
            }
        }
        let on_line = |edge: &BorderEdge| edge.iter().all(|p| p[0] == 8.0_f32.to_bits());
        count.into_iter().filter(|(edge, n)| *n == 1 && on_line(edge)).map(|(edge, _)| edge).collect()
    }

    #[test]
    fn both_sides_of_a_border_stay_the_same_at_every_step() {
        let (left, right) = (grid(0..8, true), grid(8..14, false));
        let parts = [(&left.0, &left.1[..]), (&right.0, &right.1[..])];
        let joined = simplify_joined(&parts, &SimplifyOptions::default().with_triangles(60)).unwrap();
        let counts: Vec<usize> = joined.sequences.iter().map(|s| s.triangle_count(0).unwrap()).collect();
        assert!(joined.stopped.is_none() && counts.iter().sum::<usize>() <= 60, "{counts:?}");
        let together = joined.steps[0].iter().filter(|step| joined.steps[1].contains(step)).count();
        assert!(together > 3, "{together}");
        let mut lengths = Vec::new();
        for step in 0..=joined.costs.len() as u32 {
            let edges = [0, 1].map(|i| {
                joined.sequences[i].check().unwrap();
                let done = joined.steps[i].partition_point(|&s| s < step);
                let drawn = joined.sequences[i].drawn(joined.sequences[i].len() - done).unwrap();
                border(parts[i].0, &drawn)
            });
            assert_eq!(edges[0], edges[1], "after {step} collapses");
            lengths.push(edges[0].len());
        }
        assert!(lengths[0] == 12 && *lengths.last().unwrap() < 9, "{lengths:?}");
    }

    /// On a plane with constant attributes, no collapse moves the surface: only the line between
    /// the meshes is visible.
    #[test]
    fn the_line_between_meshes_costs_as_much_as_a_border() {
        let flat = |(mesh, triangles): (Mesh, Vec<u32>)| {
            // The line is a zigzag.
            let at = |&[x, y, _]: &[f32; 3]| {
                let is_on_line = (x - 8.0).abs() < 0.1;
                [if is_on_line && y % 4.0 > 1.5 { 8.4 } else { x }, y, 0.0]
            };
            let positions: Vec<[f32; 3]> = mesh.positions().iter().map(at).collect();
            (Mesh::new(positions, Faces::default()).unwrap(), triangles)
        };
        let (left, right) = (flat(grid(0..8, true)), flat(grid(8..14, true)));
        let parts = [(&left.0, &left.1[..]), (&right.0, &right.1[..])];
        let options = SimplifyOptions::default().with_error(0.02);
        let joined = simplify_joined(&parts, &options).unwrap();
        let left_now = joined.sequences[0].drawn(0).unwrap();
        let on_line = |v: &u32| (8.0..8.5).contains(&left.0.positions()[*v as usize][0]);
        let mut kept: Vec<u32> = left_now.into_flattened().into_iter().filter(on_line).collect();
        kept.sort_unstable();
        kept.dedup();
        assert_eq!(kept.len(), 13, "the corners of the line stay");
    }

    #[test]
    fn one_mesh_is_simplified_as_alone_and_wrong_triangles_are_refused() {
        let (mesh, triangles) = grid(0..8, true);
        let options = SimplifyOptions::default().with_triangles(40);
        let joined = simplify_joined(&[(&mesh, &triangles)], &options).unwrap();
        let alone = crate::simplify::simplify_triangles(&mesh, triangles, &options).unwrap();
        assert_eq!((&joined.sequences[0], joined.stopped), (&alone.sequence, alone.stopped));
        assert_eq!(joined.costs.len(), alone.sequence.len());
        assert!(simplify_joined(&[(&mesh, &[0, 1])], &options).is_err());
        let other = grid(8..9, true).0;
        assert!(simplify_joined(&[(&mesh, &[0, 1, 2]), (&other, &[0, 1, 200])], &options).is_err());
        assert_eq!(simplify_joined(&[], &options).unwrap().costs.len(), 0);
    }
}
