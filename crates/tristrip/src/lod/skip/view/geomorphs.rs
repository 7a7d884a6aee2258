//! Geomorphs of views: smooth transitions between two states of a view.
//!
//! From one frame to the next, a view splits some vertices and collapses others. Without a geomorph
//! these vertices visibly jump. An intermediate mesh has the collapses of both states applied. Each
//! state has a geomorph to this intermediate mesh:
//!
//! ```text
//! mesh before ── vertices that collapse ──▶ both applied ◀── vertices that split ── mesh after
//!   weight 0               …                  1      1                …                0
//! ```
//! # Algorithm
//! 1. The flags of both states are compared block by block to find the nodes that differ.
//! 2. Each of these nodes moves to its first ancestor that is active in the other state. Ancestors
//!    come before their descendants, so the target of an ancestor that moves too is already known.
//!
//! The intermediate mesh is a valid view: every applied collapse has its dependencies applied, too.
//!
//! # References
//! Hoppe: *View-Dependent Refinement of Progressive Meshes*, 1997, section 5.
//!
//! # Complexity
//! A snapshot takes one byte per vertex. Comparing two states takes O(n) time for n vertices, 64 at
//! a time, plus O(c log c) for c moving vertices.

use std::sync::Arc;

use super::SkipView;
use crate::error::Error;
use crate::lod::level::geomorph::{Geomorph, Transit};
use crate::lod::skip::SkipStrips;
use crate::lod::skip::vertex_tree::VertexTree;

/// The number of flags compared at once.
const BLOCK: usize = 64;

/// A snapshot of the collapsed vertices of a view. A geomorph starts from it; see
/// [`SkipView::geomorphs`].
#[derive(Debug, Clone)]
pub struct ViewSnapshot {
    model: Arc<SkipStrips>,
    done: Vec<bool>,
}

/// The vertices that move between two states of a view.
///
/// The two geomorphs are independent of each other:
///
/// - `split` applies to the mesh after the update, while its weight falls from 1 to 0.
/// - `collapsed` applies to the mesh before the update, while its weight rises from 0 to 1. At
///   weight 1, the renderer can switch to the buffers of the updated mesh without a visible change.
///
/// At weight 1 both geomorphs draw the same surface. If the update only splits, this surface is the
/// mesh before the update. If it only collapses, this surface is the mesh after the update.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ViewGeomorphs {
    /// The vertices that exist only in the mesh before the update. Weight 0 draws that mesh.
    pub collapsed: Geomorph,
    /// The vertices that exist only in the mesh after the update. Weight 0 draws that mesh.
    pub split: Geomorph,
}

impl SkipView {
    /// Returns a snapshot of the collapsed vertices, one byte per vertex of the model.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let view = model.view();
    /// let geomorphs = view.geomorphs(&view.snapshot())?;
    /// assert!(geomorphs.split.transits().is_empty() && geomorphs.collapsed.transits().is_empty());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn snapshot(&self) -> ViewSnapshot {
        ViewSnapshot { model: Arc::clone(&self.model), done: self.state.done().to_vec() }
    }

    /// Finds the vertices that move between a snapshot and the current state of the view. The
    /// snapshot may belong to another view of the same model. It may be any number of updates old.
    ///
    /// # Errors
    /// The snapshot belongs to another model.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut view = model.view();
    /// let before = view.snapshot();
    /// let update = view.update(&Camera::new([4.0, 1.0, 4.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(0.5))?;
    /// let geomorphs = view.geomorphs(&before)?;
    /// // No vertex of this grid is on a seam, so each split adds one vertex.
    /// assert_eq!(geomorphs.split.transits().len(), update.splits);
    /// // A quarter of the way: split vertices are still near their ancestors.
    /// let positions = grid.positions().as_flattened();
    /// let mut drawn = positions.to_vec();
    /// geomorphs.split.blend(0.75, 3, positions, &mut drawn)?;
    /// assert_ne!(drawn, positions);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn geomorphs(&self, from: &ViewSnapshot) -> Result<ViewGeomorphs, Error> {
        if !Arc::ptr_eq(&self.model, &from.model) {
            let found = "a snapshot of another model".into();
            let expected = "a snapshot of this model";
            return Err(Error::Parameter { name: "from", found, expected });
        }
        let (tree, before, after) = (&self.model.tree, &from.done[..], self.state.done());
        // 1. The nodes that differ.
        let (mut collapsed, mut split) = (Vec::new(), Vec::new());
        let blocks = before.chunks(BLOCK).zip(after.chunks(BLOCK)).zip((0..).step_by(BLOCK));
        for ((before, after), first) in blocks.filter(|((before, after), _)| before != after) {
            for (node, (&was_done, &is_collapsed)) in (first..).zip(before.iter().zip(after)) {
                match (was_done, is_collapsed) {
                    (false, true) => collapsed.push(node),
                    (true, false) => split.push(node),
                    _ => (),
                }
            }
        }
        // 2. Their targets.
        let vertex_count = self.model.vertex_count;
        Ok(ViewGeomorphs {
            collapsed: Geomorph::new(transits(&collapsed, after, tree), vertex_count),
            split: Geomorph::new(transits(&split, before, tree), vertex_count),
        })
    }
}

/// Returns the transits of collapsed nodes to their first active ancestors. `nodes` must be in
/// ascending order.
fn transits(nodes: &[u32], done: &[bool], tree: &VertexTree) -> Vec<Transit> {
    let mut targets: Vec<u32> = Vec::with_capacity(nodes.len());
    for &node in nodes {
        let mut at = node;
        while let Some(parent) = tree.parent(at).filter(|_| done[at as usize]) {
            at = parent;
            if let Ok(known) = nodes[..targets.len()].binary_search(&at) {
                at = targets[known];
            }
        }
        targets.push(at);
    }
    let ways = nodes.iter().zip(targets);
    let ways = ways.map(|(&node, target)| Transit { vertex: tree.vertex(node), target: tree.vertex(target) });
    let mut transits: Vec<Transit> = ways.collect();
    transits.sort_unstable_by_key(|transit| transit.vertex);
    transits
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use proptest::prelude::*;

    use crate::lod::samples::{samples, sorted};
    use crate::lod::skip::tests::{camera, criteria, hills, model};
    use crate::lod::{Geomorph, SkipView};
    use crate::mesh::is_degenerate;
    use crate::random::Random;

    /// Returns the triangles of a geomorph that blends vertex ids as values, without degenerate
    /// triangles.
    #[allow(clippy::cast_sign_loss, reason = "numbers of vertices")]
    fn drawn(view: &SkipView, geomorph: &Geomorph, weight: f32) -> Vec<[u32; 3]> {
        let numbers: Vec<f32> = (0..view.model().vertex_count).map(|v| v as f32).collect();
        let mut values = numbers.clone();
        geomorph.blend(weight, 1, &numbers, &mut values).unwrap();
        let moved = view.renamed_triangles().into_iter().map(|t| t.map(|v| values[v as usize] as u32));
        sorted(moved.filter(|&triangle| !is_degenerate(triangle)))
    }

    /// Returns the mesh with every collapse of either view applied.
    fn between(a: &SkipView, b: &SkipView) -> Vec<[u32; 3]> {
        let model = a.model();
        let mut view = model.full_view();
        for collapse_id in model.order.iter().filter_map(|collapse_id| collapse_id.get()) {
            if a.is_collapsed(collapse_id) || b.is_collapsed(collapse_id) {
                assert!(view.state.can_collapse(collapse_id, &model.dependencies));
                view.collapse(collapse_id);
            }
        }
        sorted(view.renamed_triangles())
    }

    proptest! {
        #[test]
        fn both_ends_are_the_meshes(sample in samples(), seed in any::<u64>(), updates in 1..4_usize) {
            let model = model(&sample, seed);
            let mut random = Random::new(seed ^ 8);
            let mut view = model.view();
            for _ in 0..5 {
                let (before, snapshot) = (view.clone(), view.snapshot());
                for _ in 0..updates {
                    view.update(&camera(&mut random), &criteria(&mut random)).unwrap();
                }
                if random.below(3) == 0 {
                    view.set_level(random.below(sample.sequence.len() + 1)).unwrap();
                }
                let geomorphs = view.geomorphs(&snapshot).unwrap();
                let middle = between(&before, &view);
                prop_assert_eq!(drawn(&view, &geomorphs.split, 0.0), sorted(view.renamed_triangles()));
                prop_assert_eq!(&drawn(&view, &geomorphs.split, 1.0), &middle);
                prop_assert_eq!(drawn(&before, &geomorphs.collapsed, 0.0), sorted(before.renamed_triangles()));
                prop_assert_eq!(&drawn(&before, &geomorphs.collapsed, 1.0), &middle);
                // An update that only splits starts at the mesh before it. One that only collapses
                // ends at the mesh after it.
                if geomorphs.collapsed.transits().is_empty() {
                    prop_assert_eq!(&middle, &sorted(before.renamed_triangles()));
                }
                if geomorphs.split.transits().is_empty() {
                    prop_assert_eq!(&middle, &sorted(view.renamed_triangles()));
                }
                let targets = geomorphs.split.transits().iter().map(|transit| transit.target);
                let active = (0..model.tree.len() as u32).filter(|&node| !before.is_collapsed(node));
                let active: HashSet<u32> = active.map(|node| model.tree.vertex(node)).collect();
                prop_assert!(targets.into_iter().all(|target| active.contains(&target)));
            }
        }

        /// From the base mesh to the full mesh and back.
        #[test]
        fn all_levels_are_between_the_base_and_the_full_mesh(sample in samples(), seed in any::<u64>()) {
            let model = model(&sample, seed);
            let (base, full) = (model.view(), model.full_view());
            let levels = Geomorph::between(&sample.sequence, 0, sample.sequence.len()).unwrap();
            prop_assert_eq!(&full.geomorphs(&base.snapshot()).unwrap().split, &levels);
            prop_assert_eq!(&base.geomorphs(&full.snapshot()).unwrap().collapsed, &levels);
        }
    }

    #[test]
    fn a_snapshot_of_another_model_is_refused() {
        let [one, two] = [(); 2].map(|()| hills(3).view());
        assert!(one.geomorphs(&two.snapshot()).is_err() && one.geomorphs(&one.snapshot()).is_ok());
    }
}
