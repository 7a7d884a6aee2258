//! Simplifies the parts of a model. Parts that share positions are simplified together, and
//! vertices that touch parts placed by other nodes are locked.

use std::borrow::Cow;
use std::sync::Arc;

use tristrip::union_find::UnionFind;
use tristrip::{Error, Faces, Mesh, NearPositions, PositionIds};

use super::touching::{PlacedPositions, Touching, bounds, box_corners, touching};
use crate::goal::Deviation;
use crate::places::{Place, Places};

/// The ratio of vertices to corners above which a part is simplified over its used vertices only.
/// Thousands of parts may share one long vertex array.
const SPARSE: usize = 16;

/// The maximum number of positions in all instances for which the bounding box is exact. Above it,
/// the boxes of parts are transformed instead.
const MAX_PLACED: usize = 1 << 27;

/// The vertices of a part that a reduced mesh has, ascending; `None` for all vertices.
#[derive(Debug, Clone, Default)]
pub(crate) struct UsedVertices(Option<Vec<u32>>);

impl UsedVertices {
    /// Returns the number of vertices of the reduced mesh; `None` if the mesh is not reduced.
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

/// A part reduced to its used vertices, with their attributes, if it uses few of its vertices;
/// otherwise the part itself.
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
    /// The triangles, over the vertices of `compact`.
    triangles: Vec<u32>,
    /// The mesh that the collapses use, if it is not the part's own mesh: it has the same vertices,
    /// with fewer attributes.
    pub(crate) simplified: Option<Mesh>,
    /// Which vertices are locked because parts placed by other nodes touch them; empty if none are.
    locked: Vec<bool>,
    places: Arc<[Place]>,
    /// The transform with the largest scale, and this scale.
    largest: (Place, f64),
    /// The first part of its group, which is simplified as one surface.
    group: usize,
    /// The maximum distance between two sides of a border that are simplified as one surface, in
    /// the coordinates of the part.
    weld_distance: f32,
}

impl<'a> Part<'a> {
    /// Builds the parts of a model from their meshes and triangles. Parts with the same list of
    /// transforms form a group if they share positions, up to a distance. Vertices that touch parts
    /// placed by other nodes are locked. Also returns the number of instances that were not
    /// compared.
    pub(crate) fn of_all(
        parts: Vec<(&'a Mesh, Vec<u32>)>,
        places: &Places,
        weld_distance: Deviation,
    ) -> Result<(Vec<Self>, usize), Error> {
        let compacted = parts.into_iter().zip(&places.of_part).enumerate().map(
            |(group, ((mesh, mut triangles), &list))| {
                let compact = Compact::new(mesh, &triangles)?;
                compact.used.inward(&mut triangles);
                let places = Arc::clone(&places.lists[list]);
                let with_scale = places.iter().map(|place| (*place, place.scale()));
                let largest = with_scale.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Place::IDENTITY, 1.0));
                let (simplified, locked, weld_distance) = (None, Vec::new(), 0.0);
                Ok(Self { compact, triangles, simplified, locked, places, largest, group, weld_distance })
            },
        );
        let mut parts: Vec<Self> = compacted.collect::<Result<_, Error>>()?;
        let weld_distance = weld_distance.units(diagonal(&parts));
        for part in &mut parts {
            let own = part.own_error(weld_distance);
            part.weld_distance = if own.is_finite() { own } else { 0.0 };
        }
        if parts.len() < 2 && places.lists.iter().all(|list| list.len() < 2) {
            return Ok((parts, 0));
        }
        let skipped = compare(&mut parts, places)?;
        Ok((parts, skipped))
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

    /// Returns which vertices are locked; empty if none are.
    pub(super) fn locked(&self) -> &[bool] {
        &self.locked
    }

    /// Returns the first part of its group, which is simplified as one surface.
    pub(super) fn group(&self) -> usize {
        self.group
    }

    /// Returns the maximum distance between two sides of a border that are simplified as one
    /// surface, in the coordinates of the part.
    pub(super) fn weld_distance(&self) -> f32 {
        self.weld_distance
    }

    /// Returns the largest scale of the nodes that place the part.
    pub(super) fn scale(&self) -> f64 {
        self.largest.1
    }

    /// Returns the mesh that the collapses use.
    pub(super) fn seen(&self) -> &Mesh {
        self.simplified.as_ref().unwrap_or(&self.compact.mesh)
    }

    /// Returns a mesh of the part, scaled and rotated by the transform with the largest scale.
    pub(crate) fn shown<'m>(&self, mesh: &'m Mesh) -> Result<Cow<'m, Mesh>, Error> {
        let place = self.largest.0;
        if place.only_moves() {
            return Ok(Cow::Borrowed(mesh));
        }
        let positions: Vec<[f32; 3]> =
            mesh.positions().iter().map(|&p| place.turned(p).map(|x| x as f32)).collect();
        if !positions.as_flattened().iter().all(|x| x.is_finite()) {
            return Ok(Cow::Borrowed(mesh));
        }
        let shown = Mesh::new(positions, Faces::default())?;
        Ok(Cow::Owned(mesh.attributes().iter().cloned().try_fold(shown, Mesh::with_attribute)?))
    }

    /// Returns the maximum error in part coordinates that does not exceed `error` in the scene.
    pub(super) fn own_error(&self, error: f32) -> f32 {
        let scale = self.largest.1;
        if scale > 0.0 { (f64::from(error) / scale) as f32 } else { f32::INFINITY }
    }
}

/// Groups the parts, and locks the vertices that touch parts placed by other nodes. Returns the
/// number of instances that were not compared.
fn compare(parts: &mut [Part<'_>], places: &Places) -> Result<usize, Error> {
    let drawn: Vec<Mesh> = parts
        .iter()
        .map(|part| part.compact.mesh.with_faces(Faces::from_triangles(part.triangles.clone())?))
        .collect::<Result<_, Error>>()?;
    let mut ids = PositionIds::default();
    let mut corners = ids.faces(&drawn.iter().collect::<Vec<_>>())?.corners().to_vec();
    drop(drawn);
    // 1. The distinct positions of each list of transforms. Corners become their indices.
    let id_count = corners.iter().max().map_or(0, |&id| id as usize + 1);
    // For each position: the last list that has it, its index there, and the first part.
    let mut last = vec![(usize::MAX, 0_u32, 0_usize); id_count];
    let mut lists: Vec<PlacedPositions> = places
        .lists
        .iter()
        .map(|places| PlacedPositions { places: Arc::clone(places), positions: Vec::new() })
        .collect();
    let mut groups = UnionFind::new(parts.len());
    let mut starts = Vec::with_capacity(parts.len());
    let mut start = 0;
    for part in &*parts {
        starts.push(start);
        start += part.triangles.len();
    }
    let mut by_list: Vec<usize> = (0..parts.len()).collect();
    by_list.sort_by_key(|&part| places.of_part[part]);
    // The parts of the positions of a list, if it has several parts.
    let mut grid: Option<NearPositions> = None;
    for (i, &part) in by_list.iter().enumerate() {
        let list = places.of_part[part];
        let list_of = |i: usize| by_list.get(i).map(|&part| places.of_part[part]);
        if i.checked_sub(1).and_then(list_of) != Some(list) {
            let has_several = list_of(i + 1) == Some(list);
            grid = has_several.then(|| NearPositions::new(parts[part].weld_distance).ok()).flatten();
        }
        for corner in &mut corners[starts[part]..starts[part] + parts[part].triangles.len()] {
            let known = &mut last[*corner as usize];
            if known.0 == list {
                groups.unite(part as u32, known.2 as u32);
            } else {
                let positions = &mut lists[list].positions;
                *known = (list, positions.len() as u32, part);
                let position = ids.position(*corner).unwrap_or_default();
                positions.push(position);
                if let Some(grid) = &mut grid {
                    grid.near(position).for_each(|(_, other)| groups.unite(part as u32, other));
                    grid.insert(part as u32, position)?;
                }
            }
            *corner = known.1;
        }
    }
    // 2. The groups.
    for (number, part) in (0..).zip(parts.iter_mut()) {
        part.group = groups.find(number) as usize;
    }
    // 3. The vertices that touch other instances.
    let Touching { touches, skipped } = touching(&lists);
    for (part, start) in starts.into_iter().enumerate() {
        let touches = &touches[places.of_part[part]];
        let part = &mut parts[part];
        let own = &corners[start..start + part.triangles.len()];
        if own.iter().any(|&position| touches.get(position as usize) == Some(&true)) {
            part.locked = vec![false; part.compact.mesh.vertex_count()];
            for (&position, &vertex) in own.iter().zip(&part.triangles) {
                part.locked[vertex as usize] |= touches[position as usize];
            }
        }
    }
    Ok(skipped)
}

/// Returns the diagonal of the bounding box of all triangles in the scene.
pub(crate) fn diagonal(parts: &[Part<'_>]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut extend = |p: [f64; 3]| {
        for (axis, x) in p.into_iter().enumerate() {
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
    };
    let mut budget = MAX_PLACED;
    for part in parts {
        let positions = part.compact.mesh.positions();
        let corners = part.triangles.iter().map(|&vertex| positions[vertex as usize]);
        let work = part.triangles.len().saturating_mul(part.places.len());
        if work <= budget {
            budget -= work;
            for place in &*part.places {
                corners.clone().for_each(|p| extend(place.at(p)));
            }
        } else if let Some([low, high]) = bounds(corners) {
            for place in &*part.places {
                box_corners([low, high]).for_each(|p| extend(place.at(p)));
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

    fn up(y: f64) -> Place {
        Place::new([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, 0.0]])
    }

    fn strip_of(length: usize, y: f32) -> (Mesh, Vec<u32>) {
        let positions: Vec<[f32; 3]> =
            (0..2 * length as u32).map(|i| [(i / 2) as f32, y + (i % 2) as f32, 0.0]).collect();
        let triangles = (0..length as u32 - 1)
            .flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3]);
        (Mesh::new(positions, Faces::default()).unwrap(), triangles.collect())
    }

    fn of_all<'a>(parts: Vec<(&'a Mesh, Vec<u32>)>, places: &Places) -> Vec<Part<'a>> {
        Part::of_all(parts, places, Deviation::Units(0.0)).unwrap().0
    }

    #[test]
    fn parts_within_the_weld_distance_are_grouped() {
        let strips = [strip_of(4, 0.0), strip_of(4, 1.125), strip_of(3, 7.0)];
        let groups = |distance: f64, places: &Places| {
            let parts = strips.iter().map(|(mesh, triangles)| (mesh, triangles.clone())).collect();
            let (parts, _) = Part::of_all(parts, places, Deviation::Units(distance)).unwrap();
            parts.iter().map(|part| part.group).collect::<Vec<_>>()
        };
        assert_eq!(groups(0.1, &Places::one(3)), [0, 1, 2]);
        assert_eq!(groups(0.125, &Places::one(3)), [0, 0, 2]);
        assert_eq!(groups(5.0, &Places::one(3)), [0, 0, 0]);
        // The distance is in scene units.
        let half = Place::new([[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]]);
        let places = Places { lists: vec![Arc::from([half])], of_part: vec![0; 3], problem: None };
        assert_eq!(groups(0.0625, &places), [0, 0, 2]);
        // Parts that other nodes place are not grouped.
        let lists = vec![Arc::from([Place::IDENTITY]); 3];
        assert_eq!(groups(5.0, &Places { lists, of_part: vec![0, 1, 2], problem: None }), [0, 1, 2]);
    }

    #[test]
    fn parts_that_share_positions_are_grouped_or_locked() {
        let (lower, upper, far) = (strip_of(4, 0.0), strip_of(4, 1.0), strip_of(3, 7.0));
        let parts = [&lower, &upper, &far].map(|(mesh, triangles)| (mesh, triangles.clone()));
        let together = of_all(parts.to_vec(), &Places::one(3));
        assert_eq!(together.iter().map(Part::locked_count).sum::<usize>(), 0);
        assert_eq!(together.iter().map(|part| part.group).collect::<Vec<_>>(), [0, 0, 2]);
        // Other nodes place the upper and the far part, at the same positions as above.
        let lists = [Place::IDENTITY, up(1.0), up(7.0)].map(|place| Arc::from([place]));
        let places = Places { lists: lists.to_vec(), of_part: vec![0, 1, 2], problem: None };
        let (lower, upper, far) = (strip_of(4, 0.0), strip_of(4, 0.0), strip_of(3, 0.0));
        let parts = [&lower, &upper, &far].map(|(mesh, triangles)| (mesh, triangles.clone()));
        let parts = of_all(parts.to_vec(), &places);
        assert_eq!(parts.iter().map(Part::locked_count).collect::<Vec<_>>(), [4, 4, 0]);
        assert!(parts[0].locked.iter().enumerate().all(|(v, &locked)| locked == (v % 2 == 1)));
        assert!((diagonal(&together) - diagonal(&parts)).abs() < 1e-9);
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
        let parts = of_all(vec![(&mesh, vec![900, 5, 77])], &Places::one(1));
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
