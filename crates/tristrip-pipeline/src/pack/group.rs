//! Groups the parts of a model that form one mesh of a stream.

use std::collections::HashMap;
use std::mem::discriminant;

use tristrip::stream::{EncodedStream, PART, StreamLimits};
use tristrip::{Attribute, AttributeData, Faces, MAX_COUNT, Mesh};
use tristrip_io::Model;

use crate::error::Error;
use crate::places::{Place, Places};
use crate::simplify::touching::{PlacedPositions, touching};
use crate::simplify::{Compact, UsedVertices};
use crate::stream::drawn_triangles;
use crate::text::counted;

/// A part within a group.
pub(super) struct Member {
    pub(super) part: usize,
    /// The index of its first vertex in the mesh of the group.
    first: u32,
    used: UsedVertices,
}

/// Parts that form one mesh of a stream.
pub(super) struct Group {
    pub(super) parts: Vec<Member>,
    /// The index of the list of instance transforms of the parts.
    pub(super) list: usize,
    /// The maximum scale of these transforms.
    pub(super) scale: f64,
    /// The triangles of all parts over their vertices. If there are several parts, an attribute has
    /// the part of each vertex.
    pub(super) mesh: Mesh,
    /// The bounding box of all parts with the same transforms, if they are in several groups.
    pub(super) bounds: Option<[[f32; 3]; 2]>,
}

/// The properties that are equal within a group: the transforms, and the names and types of the
/// attributes.
type Key<'a> = (usize, Vec<(&'a str, u8, bool, std::mem::Discriminant<AttributeData>)>);

/// Groups the parts of a model. Returns the groups, and the parts that are in none; a note has the
/// reason for those.
pub(super) fn groups(
    model: &Model,
    places: &Places,
    notes: &mut Vec<String>,
) -> Result<(Vec<Group>, Vec<usize>), Error> {
    let is_unread = tristrip_io::gltf::unread_vertex_values(model);
    let (mut unread, mut reserved) = (0, 0);
    let mut whole = Vec::new();
    let mut keys: HashMap<Key<'_>, usize> = HashMap::new();
    let mut members: Vec<(usize, Vec<usize>)> = Vec::new();
    for (part, is_unread) in is_unread.into_iter().enumerate() {
        let mesh = &model.parts[part].mesh;
        if mesh.faces().triangle_count() == 0 {
            continue;
        }
        if is_unread {
            unread += 1;
            whole.push(part);
            continue;
        }
        if mesh.attributes().iter().any(|attribute| attribute.name == PART) {
            reserved += 1;
            whole.push(part);
            continue;
        }
        let attributes = mesh
            .attributes()
            .iter()
            .map(|a| (a.name.as_str(), a.components, a.normalized, discriminant(&a.data)));
        let key = (places.of_part[part], attributes.collect());
        let group = *keys.entry(key).or_insert(members.len());
        if group == members.len() {
            members.push((places.of_part[part], Vec::new()));
        }
        members[group].1.push(part);
    }
    let mut note = |count: usize, why: &str| {
        if count > 0 {
            notes.push(format!("{} not refined: {why}", counted(count, "part")));
        }
    };
    note(unread, "they have morph targets or attributes that are not read");
    note(reserved, "they have an attribute `part`, whose name streams reserve");
    // Keep the largest groups, in their order.
    let mut by_size: Vec<usize> = (0..members.len()).collect();
    let size = |group: &usize| -> usize {
        members[*group].1.iter().map(|&part| model.parts[part].mesh.faces().triangle_count()).sum()
    };
    by_size.sort_by_key(|group| std::cmp::Reverse(size(group)));
    // Readers reject streams with more meshes.
    let smaller = by_size.split_off(by_size.len().min(StreamLimits::default().meshes));
    let more: Vec<usize> = smaller.iter().flat_map(|&group| members[group].1.iter().copied()).collect();
    note(more.len(), "a stream has a limited number of meshes");
    whole.extend(more);
    by_size.sort_unstable();
    let groups =
        by_size.into_iter().map(|group| Group::new(model, places, members[group].0, &members[group].1));
    let mut groups = groups.collect::<Result<Vec<_>, _>>()?;
    share_bounds(&mut groups);
    Ok((groups, whole))
}

/// Gives all groups with the same transforms one common bounding box.
fn share_bounds(groups: &mut [Group]) {
    let mut boxes: HashMap<usize, ([[f32; 3]; 2], usize)> = HashMap::new();
    for group in groups.iter() {
        let (bounds, count) =
            boxes.entry(group.list).or_insert(([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], 0));
        *count += 1;
        for &v in group.mesh.faces().corners() {
            let position = group.mesh.positions()[v as usize];
            for axis in 0..3 {
                bounds[0][axis] = bounds[0][axis].min(position[axis]);
                bounds[1][axis] = bounds[1][axis].max(position[axis]);
            }
        }
    }
    for group in groups {
        group.bounds = boxes.get(&group.list).filter(|(_, count)| *count > 1).map(|&(bounds, _)| bounds);
    }
}

impl Group {
    fn new(model: &Model, places: &Places, list: usize, parts: &[usize]) -> Result<Self, Error> {
        let scale = places.lists[list].iter().map(Place::scale).fold(0.0, f64::max);
        let mut members = Vec::with_capacity(parts.len());
        let (mut positions, mut triangles): (Vec<[f32; 3]>, Vec<u32>) = (Vec::new(), Vec::new());
        let (mut attributes, mut numbers): (Vec<Attribute>, Vec<u32>) = (Vec::new(), Vec::new());
        for (number, &part) in (0..).zip(parts) {
            let mesh = &model.parts[part].mesh;
            let mut own = mesh.faces().fans().into_owned();
            let compact = Compact::new(mesh, &own)?;
            compact.used.inward(&mut own);
            let first = positions.len();
            let found = (first + compact.mesh.vertex_count()).max(triangles.len() + own.len());
            if found > MAX_COUNT {
                let found = format!("{found} vertices or corners of parts with the same nodes");
                return Err(tristrip::Error::Parameter {
                    name: "model",
                    found,
                    expected: "less than 2^32 - 1",
                }
                .into());
            }
            positions.extend_from_slice(compact.mesh.positions());
            triangles.extend(own.iter().map(|&v| v + first as u32));
            numbers.resize(positions.len(), number);
            if attributes.is_empty() {
                attributes = compact.mesh.attributes().to_vec();
            } else {
                for (all, more) in attributes.iter_mut().zip(compact.mesh.attributes()) {
                    all.append(more)?;
                }
            }
            members.push(Member { part, first: first as u32, used: compact.used });
        }
        let mut mesh = Mesh::new(positions, Faces::from_triangles(triangles)?)?;
        for attribute in attributes {
            mesh = mesh.with_attribute(attribute)?;
        }
        if parts.len() > 1 {
            let data = AttributeData::U32(numbers);
            mesh =
                mesh.with_attribute(Attribute { name: PART.into(), components: 1, normalized: false, data })?;
        }
        Ok(Self { parts: members, list, scale, mesh, bounds: None })
    }

    /// Returns the size of a vertex in a GLB, in bytes.
    pub(super) fn vertex_bytes(&self) -> usize {
        let of = |attribute: &Attribute| {
            let size = match attribute.data {
                AttributeData::U8(_) | AttributeData::I8(_) => 1,
                AttributeData::U16(_) | AttributeData::I16(_) => 2,
                AttributeData::U32(_) | AttributeData::I32(_) | AttributeData::F32(_) => 4,
                AttributeData::F64(_) => 8,
            };
            (usize::from(attribute.components) * size).next_multiple_of(4)
        };
        12 + self.mesh.attributes().iter().filter(|attribute| attribute.name != PART).map(of).sum::<usize>()
    }

    /// Splits triangles of the mesh by part.
    fn lists(&self, triangles: &[u32]) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.parts.len()];
        for triangle in triangles.chunks_exact(3) {
            lists[self.parts.partition_point(|member| member.first <= triangle[0]) - 1].extend(triangle);
        }
        lists
    }

    /// Splits triangles of the mesh by part, and converts them to the vertices of each part.
    pub(super) fn split(&self, triangles: &[u32]) -> Vec<(usize, Vec<u32>)> {
        let lists = self.lists(triangles);
        let outward = |(member, mut list): (&Member, Vec<u32>)| {
            list.iter_mut().for_each(|v| *v -= member.first);
            member.used.outward(&mut list);
            (member.part, list)
        };
        self.parts.iter().zip(lists).map(outward).collect()
    }

    /// Returns the mesh that a decoder must produce for each part.
    pub(super) fn expected(&self, stream: &EncodedStream) -> Result<Vec<(usize, Mesh)>, Error> {
        let all = moved(&self.mesh, |position| stream.decoded(position))?;
        let lists = self.lists(all.faces().corners());
        let of = |(member, list): (&Member, Vec<u32>)| {
            Ok((member.part, all.with_faces(Faces::from_triangles(list)?)?))
        };
        self.parts.iter().zip(lists).map(of).collect()
    }
}

/// Returns which vertices of each group touch an unrefined part or another group. The other group
/// has other transforms, or the same transforms and other attributes.
pub(super) fn touching_vertices(
    groups: &[Group],
    (model, whole): (&Model, &[usize]),
    places: &Places,
) -> Vec<Vec<bool>> {
    // The positions of each list of transforms, the first group that has each position, and whether
    // another group has it too.
    let mut lists: Vec<PlacedPositions> = (places.lists.iter())
        .map(|places| PlacedPositions { places: places.clone(), positions: Vec::new() })
        .collect();
    let mut known: Vec<HashMap<[u32; 3], (u32, usize, bool)>> = vec![HashMap::default(); lists.len()];
    let key = |position: [f32; 3]| position.map(|x| (x + 0.0).to_bits());
    let of_groups = groups.iter().enumerate().map(|(number, group)| (number, group.list, &group.mesh));
    let of_whole = whole.iter().map(|&part| (groups.len(), places.of_part[part], &model.parts[part].mesh));
    for (number, list, mesh) in of_groups.chain(of_whole) {
        let (list, known) = (&mut lists[list].positions, &mut known[list]);
        for &v in mesh.faces().corners() {
            let position = mesh.positions()[v as usize];
            let entry = known.entry(key(position)).or_insert_with(|| {
                list.push(position);
                (list.len() as u32 - 1, number, false)
            });
            entry.2 |= entry.1 != number;
        }
    }
    let touches = touching(&lists).touches;
    let of = |group: &Group| {
        let (known, touches) = (&known[group.list], &touches[group.list]);
        let is_locked = |&position: &[f32; 3]| {
            known.get(&key(position)).is_some_and(|&(number, _, is_shared)| {
                is_shared || touches.get(number as usize) == Some(&true)
            })
        };
        group.mesh.positions().iter().map(is_locked).collect()
    };
    groups.iter().map(of).collect()
}

/// Returns the triangles of a mesh that draw something, with mapped positions.
fn moved(mesh: &Mesh, position: impl Fn([f32; 3]) -> [f32; 3]) -> Result<Mesh, Error> {
    let (triangles, _) = drawn_triangles(mesh);
    let positions: Vec<[f32; 3]> = mesh.positions().iter().map(|&p| position(p)).collect();
    Ok(Mesh::new(positions, Faces::from_triangles(triangles)?)?)
}
