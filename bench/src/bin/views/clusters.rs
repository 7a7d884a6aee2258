//! A cluster hierarchy, the current approach to view-dependent detail, as the alternative to Skip
//! Strips. It is built by meshoptimizer's clusterlod.
//!
//! ```text
//! full mesh ─▶ clusters of about 128 triangles ─▶ groups of about 16 neighbours ─┐
//!                 ▲                                                              ▼
//!                 └─ split into clusters ◀─ each simplified to half, its border locked
//! ```
//! Each group has a sphere and the error of its simplified triangles. Both bound those of the
//! groups that its clusters come from. A *cut* therefore covers the surface exactly once: a cluster
//! is drawn if the error of its own group exceeds the limit, and the error of the group that it
//! comes from does not. Clusters never change. A frame is a list of ranges of one index buffer;
//! here it contains strips that `best` builds once per cluster.
//!
//! # References
//! Arseny Kapoulkine: *meshoptimizer*, `demo/clusterlod.h`. Karis, Stubbe, Wihlidal: *A Deep Dive
//! into Nanite Virtualized Geometry*, 2021. Cignoni, Ganovelli, Gobbetti, Marton, Ponchio,
//! Scopigno: *Batched Multi Triangulation*, 2005.
//!
//! # Complexity
//! A cut takes one step per group (about two per thousand triangles), and one per cluster of the
//! groups that are not simplified.

use std::ops::Range;

use meshopt::{ClodConfig, ClodMesh};
use tristrip::lod::RESTART;
use tristrip::{Faces, Mesh, Method, StripifyOptions, Strips, strip_triangles, stripify};
use tristrip_bench::failure::Failure;
use tristrip_bench::meshoptimizer::adapter;

/// The maximum number of triangles and of vertices of a cluster, as in meshoptimizer's demo.
pub(super) const CLUSTER_TRIANGLES: usize = 128;

/// A sphere in mesh units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sphere {
    pub(super) center: [f32; 3],
    pub(super) radius: f32,
}

/// Triangles that are drawn together or not at all.
#[derive(Debug, Clone, PartialEq)]
struct Cluster {
    /// The culling sphere.
    sphere: Sphere,
    /// The group that was simplified to it; `None` for a cluster of the full mesh.
    refined: Option<u32>,
    /// The range of its strips.
    strips: Range<u32>,
    triangle_count: u32,
    vertex_count: u32,
}

/// Clusters that are simplified together.
#[derive(Debug, Clone, PartialEq)]
struct Group {
    sphere: Sphere,
    /// The error of its simplified triangles; the largest number if there are none.
    error: f32,
    clusters: Range<u32>,
}

/// The clusters of all levels of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ClusterHierarchy {
    clusters: Vec<Cluster>,
    groups: Vec<Group>,
    /// The strips of all clusters, with [`RESTART`] between the strips of one cluster.
    strips: Vec<u32>,
}

/// The clusters that a frame draws.
#[derive(Debug, Clone, Default)]
pub(super) struct Cut {
    clusters: Vec<u32>,
    is_allowed: Vec<bool>,
}

impl ClusterHierarchy {
    /// Builds the hierarchy with meshoptimizer's default configuration for rasterization, except
    /// for the settings below.
    pub(super) fn build(mesh: &Mesh) -> Result<Self, Failure> {
        let indices = mesh.faces().as_triangles().ok_or("meshoptimizer accepts only triangles")?;
        let vertices = adapter(mesh.positions())?;
        // Clusters are culled by their own spheres, not by those of their groups. Without
        // attributes there are no seams that a permissive simplification would have to cross. On
        // the dragon, it leaves points 4 pixels away at a stated error of 0.1; this configuration
        // leaves them 0.14 pixels away.
        let config = ClodConfig {
            optimize_bounds: true,
            simplify_permissive: false,
            ..meshopt::clod_default_config(CLUSTER_TRIANGLES)
        };
        let mut hierarchy = Self { clusters: Vec::new(), groups: Vec::new(), strips: Vec::new() };
        let mut lists = Vec::new();
        meshopt::clod_build(config, &ClodMesh::new(indices, &vertices), |group, clusters| {
            // There are fewer groups than triangles. -1 would mean that the clusters are those of
            // the full mesh.
            let id = i32::try_from(hierarchy.groups.len()).unwrap_or(-1);
            let first = hierarchy.clusters.len() as u32;
            let sphere =
                |bounds: &meshopt::ClodBounds| Sphere { center: bounds.center, radius: bounds.radius };
            for cluster in clusters {
                lists.push(cluster.indices.to_vec());
                hierarchy.clusters.push(Cluster {
                    sphere: sphere(&cluster.bounds),
                    refined: u32::try_from(cluster.refined).ok(),
                    strips: 0..0,
                    triangle_count: (cluster.indices.len() / 3) as u32,
                    vertex_count: cluster.vertex_count as u32,
                });
            }
            hierarchy.groups.push(Group {
                sphere: sphere(&group.simplified),
                error: group.simplified.error,
                clusters: first..hierarchy.clusters.len() as u32,
            });
            id
        });
        for (cluster, list) in hierarchy.clusters.iter_mut().zip(&lists) {
            let first = hierarchy.strips.len() as u32;
            append_strips(mesh, list, &mut hierarchy.strips)?;
            cluster.strips = first..hierarchy.strips.len() as u32;
        }
        Ok(hierarchy)
    }

    /// Chooses the clusters of a frame. `allows` returns whether an error within a sphere is
    /// allowed, and `sees` whether a sphere is in the image. The cut covers the surface if `allows`
    /// is monotonic: an allowed error must also be allowed for every sphere inside, and for every
    /// smaller error.
    pub(super) fn choose(
        &self,
        allows: impl Fn(Sphere, f32) -> bool,
        sees: impl Fn(Sphere) -> bool,
        cut: &mut Cut,
    ) {
        cut.is_allowed.clear();
        cut.is_allowed.extend(self.groups.iter().map(|group| allows(group.sphere, group.error)));
        cut.clusters.clear();
        for (group, &is_allowed) in self.groups.iter().zip(&cut.is_allowed) {
            if is_allowed {
                continue;
            }
            cut.clusters.extend(group.clusters.clone().filter(|&id| {
                let cluster = &self.clusters[id as usize];
                cluster.refined.is_none_or(|group| cut.is_allowed[group as usize]) && sees(cluster.sphere)
            }));
        }
    }

    /// Returns the strips of a cut.
    pub(super) fn strips(&self, cut: &Cut) -> Strips {
        let mut strips = Strips::default();
        for cluster in cut.clusters.iter().map(|&id| &self.clusters[id as usize]) {
            let entries = &self.strips[cluster.strips.start as usize..cluster.strips.end as usize];
            entries.split(|&entry| entry == RESTART).for_each(|strip| strips.push(strip));
        }
        strips
    }

    /// Counts the triangles of a cut.
    pub(super) fn triangle_count(&self, cut: &Cut) -> usize {
        cut.clusters.iter().map(|&id| self.clusters[id as usize].triangle_count as usize).sum()
    }

    /// Counts the vertices of the clusters of a cut, once per cluster, as mesh shaders transform
    /// them.
    pub(super) fn vertex_count(&self, cut: &Cut) -> usize {
        cut.clusters.iter().map(|&id| self.clusters[id as usize].vertex_count as usize).sum()
    }

    /// Returns the size of the hierarchy in bytes, without the vertices.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.clusters[..]) + size_of_val(&self.groups[..]) + size_of_val(&self.strips[..])
    }
}

impl Cut {
    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.clusters[..]) + size_of_val(&self.is_allowed[..])
    }
}

/// Appends the strips of a cluster, over the vertices of the mesh.
fn append_strips(mesh: &Mesh, list: &[u32], out: &mut Vec<u32>) -> Result<(), Failure> {
    // Strips over the local vertices of the cluster use no memory per vertex of the mesh.
    let (vertices, local) = meshopt::clod_local_indices(list);
    let positions: Vec<_> = vertices.iter().map(|&vertex| mesh.positions()[vertex as usize]).collect();
    let local = Mesh::new(positions, Faces::from_triangles(local.into_iter().map(u32::from).collect())?)?;
    let strips = stripify(&local, &StripifyOptions::default().with_method(Method::Best))?;
    let drawn: usize = strips.iter().map(|strip| strip_triangles(strip).count()).sum();
    if 3 * drawn != list.len() {
        return Err(format!("the strips of a cluster draw {drawn} of {} triangles", list.len() / 3).into());
    }
    for (number, strip) in strips.iter().enumerate() {
        if number > 0 {
            out.push(RESTART);
        }
        out.extend(strip.iter().map(|&vertex| vertices[vertex as usize]));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proof::{Borders, sorted};

    const SIDE: u32 = 80;

    /// Returns a bumpy surface over a grid: a torus, or a sheet with a border.
    fn surface(is_torus: bool) -> Mesh {
        let columns = if is_torus { SIDE } else { SIDE + 1 };
        let turn = |i: u32| f64::from(i) * std::f64::consts::TAU / f64::from(SIDE);
        let position = |i: u32| {
            let (u, v) = (turn(i % columns), turn(i / columns));
            let bump = 0.05 * (7.0 * u).sin() * (5.0 * v).cos();
            let ring = 2.0 + (0.7 + bump) * v.cos();
            let point = if is_torus {
                [ring * u.cos(), ring * u.sin(), (0.7 + bump) * v.sin()]
            } else {
                [u, v, 3.0 * bump]
            };
            point.map(|x| x as f32)
        };
        let at = |x: u32, y: u32| (y % columns) * columns + x % columns;
        let quad =
            |x, y| [at(x, y), at(x + 1, y), at(x, y + 1), at(x, y + 1), at(x + 1, y), at(x + 1, y + 1)];
        let indices = (0..SIDE).flat_map(|y| (0..SIDE).flat_map(move |x| quad(x, y))).collect();
        let positions: Vec<_> = (0..columns * columns).map(position).collect();
        Mesh::new(positions, Faces::from_triangles(indices).unwrap()).unwrap()
    }

    fn triangles_of(hierarchy: &ClusterHierarchy, cut: &Cut) -> Vec<[u32; 3]> {
        hierarchy.strips(cut).triangles().collect()
    }

    #[test]
    fn without_an_error_the_cut_is_the_full_mesh() {
        for mesh in [surface(true), surface(false)] {
            let (hierarchy, mut cut) = (ClusterHierarchy::build(&mesh).unwrap(), Cut::default());
            hierarchy.choose(|_, error| error < 0.0, |_| true, &mut cut);
            let (full, _) = mesh.faces().as_triangles().unwrap().as_chunks::<3>();
            assert_eq!(sorted(triangles_of(&hierarchy, &cut)), sorted(full.iter().copied()));
        }
    }

    #[test]
    fn cuts_of_one_error_have_no_cracks() {
        for mesh in [surface(true), surface(false)] {
            let (hierarchy, mut cut) = (ClusterHierarchy::build(&mesh).unwrap(), Cut::default());
            let borders = Borders::of(&mesh).unwrap();
            let mut counts = Vec::new();
            for allowed in [0.0001, 0.001, 0.005, 0.02, 0.1, 1.0] {
                hierarchy.choose(|_, error| error <= allowed, |_| true, &mut cut);
                let triangles = triangles_of(&hierarchy, &cut);
                assert_eq!(borders.cracks(&triangles), 0, "{allowed}");
                counts.push(triangles.len());
            }
            assert!(counts.is_sorted_by(|a, b| a >= b), "{counts:?}");
            assert!(counts[0] > 4 * counts[5] && counts[5] > 0, "{counts:?}");
        }
    }

    /// Seen from a point on the surface, errors may grow with the distance.
    #[test]
    fn cuts_of_a_view_have_no_cracks_and_several_levels() {
        for mesh in [surface(true), surface(false)] {
            let (hierarchy, mut cut) = (ClusterHierarchy::build(&mesh).unwrap(), Cut::default());
            let borders = Borders::of(&mesh).unwrap();
            let eye = mesh.positions()[0];
            for slope in [0.003, 0.01, 0.03] {
                let allows = |sphere: Sphere, error: f32| {
                    let away = [0, 1, 2].map(|k| sphere.center[k] - eye[k]);
                    let distance = away.iter().map(|x| x * x).sum::<f32>().sqrt();
                    error <= slope * (distance - sphere.radius).max(0.0)
                };
                hierarchy.choose(allows, |_| true, &mut cut);
                let triangles = triangles_of(&hierarchy, &cut);
                assert_eq!(borders.cracks(&triangles), 0, "{slope}");
                assert!(triangles.len() < mesh.faces().face_count());
                let of_full = |&&id: &&u32| hierarchy.clusters[id as usize].refined.is_none();
                let full = cut.clusters.iter().filter(of_full).count();
                assert!((1..cut.clusters.len()).contains(&full), "{full} of {}", cut.clusters.len());
            }
        }
    }

    #[test]
    fn a_missing_cluster_is_a_crack() {
        for mesh in [surface(true), surface(false)] {
            let (hierarchy, mut cut) = (ClusterHierarchy::build(&mesh).unwrap(), Cut::default());
            hierarchy.choose(|_, error| error <= 0.001, |_| true, &mut cut);
            let borders = Borders::of(&mesh).unwrap();
            let missing = cut.clusters.len() / 2;
            cut.clusters.remove(missing);
            assert!(borders.cracks(&triangles_of(&hierarchy, &cut)) > 0);
        }
    }

    #[test]
    fn clusters_that_are_not_seen_are_left_out() {
        let mesh = surface(true);
        let (hierarchy, mut cut) = (ClusterHierarchy::build(&mesh).unwrap(), Cut::default());
        hierarchy.choose(|_, error| error < 0.0, |sphere| sphere.center[0] + sphere.radius >= 0.0, &mut cut);
        let drawn = sorted(triangles_of(&hierarchy, &cut));
        let (full, _) = mesh.faces().as_triangles().unwrap().as_chunks::<3>();
        assert!(drawn.len() < full.len());
        let is_right = |triangle: &[u32; 3]| triangle.iter().any(|&v| mesh.positions()[v as usize][0] >= 0.0);
        let right = sorted(full.iter().copied().filter(is_right));
        assert!(right.iter().all(|triangle| drawn.binary_search(triangle).is_ok()));
    }
}
