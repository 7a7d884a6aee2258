//! A view of a model: the level of detail that one camera needs.

mod geomorphs;
mod levels;
mod update;

use std::ops::Range;
use std::sync::Arc;

use super::SkipStrips;
use super::camera::Camera;
use super::criteria::{Criteria, ViewCriteria};
use super::display::Display;
use super::schedule::Schedule;
use super::state::ViewState;
use crate::error::Error;
use crate::ids::OptionalId;
use crate::lod::filter::Filter;
use crate::lod::level::index_map::RESTART;
use crate::mesh::is_degenerate;
use crate::strip::{Strips, strip_triangles};
pub use geomorphs::{ViewGeomorphs, ViewSnapshot};

/// The largest and the smallest factor by which an update lowers the allowed error while the budget
/// has room.
const FALL: f64 = 0.98;
const STEEPEST_FALL: f64 = 0.5;
/// A budget has room while the view uses less than this share of it.
const ROOM: f64 = 0.95;
/// The factor by which the allowed error is raised until the view fits a smaller budget, and the
/// maximum scale of the allowed error.
const RISE: f64 = 1.25;
const MAX_SCALE: f64 = 1e12;

/// What an update did, and its result.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct ViewUpdate {
    /// The number of collapses applied.
    pub collapses: usize,
    /// The number of collapses split, including the dependents of other split collapses.
    pub splits: usize,
    /// The number of collapses evaluated.
    pub looked_at: usize,
    /// The number of strip segments scanned.
    pub segments: usize,
    /// The changed ranges of [`SkipView::indices`]. The buffer may also have grown.
    pub changed: Vec<Range<usize>>,
    /// `true` if all collapses and splits were applied, `false` if the step limit stopped the
    /// update.
    pub is_complete: bool,
}

/// The level of detail of a model for one camera, updated from frame to frame.
///
/// A view starts at the base mesh. Views hold no lock: several threads can update views of the same
/// model at the same time.
///
/// ```
#[doc = include_str!("example.txt")]
/// let mut view = model.view();
/// let near = view.update(&Camera::new([4.0, 1.0, 4.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(0.5))?;
/// assert!(near.splits > 0 && near.is_complete);
/// let fine = view.triangle_count();
/// // From far away one pixel covers the whole grid.
/// view.update(&Camera::new([4.0, 1e5, 4.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(0.5))?;
/// assert!(view.triangle_count() < fine);
/// assert_eq!(view.display_strips().triangles().count(), view.triangle_count());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SkipView {
    model: Arc<SkipStrips>,
    state: ViewState,
    /// The vertex drawn for each node: that of its first active ancestor.
    names: Vec<u32>,
    /// `None` if the view builds no display strips.
    display: Option<Display>,
    triangle_count: usize,
    active_count: usize,
    schedule: Option<Schedule>,
    criteria: Option<Criteria>,
    /// The factor on the allowed error that keeps the view within its budget.
    scale: f64,
    /// The budget for which `scale` was found; `None` if there was no budget.
    scaled_budget: Option<usize>,
    /// Reused buffers: collapses whose schedule entry expired, new candidates, collapses to apply,
    /// and collapses split.
    expired: Vec<u32>,
    new_candidates: Vec<u32>,
    to_collapse: Vec<u32>,
    split: Vec<u32>,
    /// The collapses applied or undone since the display strips were last built.
    moved: Vec<u32>,
}

impl SkipStrips {
    /// Returns a view at the base mesh whose display strips use [`Filter::Dtfs`].
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(model.view().triangle_count(), model.levels().triangle_count(0)?);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn view(self: &Arc<Self>) -> SkipView {
        self.view_by(Filter::Dtfs)
    }

    /// Returns a view at the base mesh whose display strips use the given filter.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let sent = |filter| model.view_by(filter).display_strips().vertices_sent();
    /// assert!(sent(Filter::Dtfs) < sent(Filter::None));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn view_by(self: &Arc<Self>, filter: Filter) -> SkipView {
        SkipView::new(Arc::clone(self), Some(filter), false)
    }

    /// Returns a view at the base mesh that builds no display strips.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut view = model.view_without_strips();
    /// view.update(&Camera::new([4.0, 1.0, 4.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(0.5))?;
    /// assert_eq!((view.indices().len(), view.renamed_triangles().len()), (0, view.triangle_count()));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn view_without_strips(self: &Arc<Self>) -> SkipView {
        SkipView::new(Arc::clone(self), None, false)
    }

    /// Returns a view at the full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(model.full_view().triangle_count(), 128);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn full_view(self: &Arc<Self>) -> SkipView {
        SkipView::new(Arc::clone(self), Some(Filter::Dtfs), true)
    }
}

impl SkipView {
    pub(super) fn new(model: Arc<SkipStrips>, filter: Option<Filter>, is_full: bool) -> Self {
        let tree = &model.tree;
        let state = if is_full { ViewState::full(tree) } else { ViewState::base(tree) };
        let level = if is_full { model.order.len() } else { 0 };
        let mut names: Vec<u32> = Vec::with_capacity(tree.len());
        for node in 0..tree.len() as u32 {
            let parent = tree.parent(node).filter(|_| state.is_collapsed(node));
            names.push(parent.map_or(tree.vertex(node), |parent| names[parent as usize]));
        }
        let mut view = Self {
            display: filter.map(|filter| Display::new(filter, &model.strips)),
            triangle_count: model.levels.triangles_at(level),
            active_count: if is_full { tree.len() } else { model.base_vertex_count() },
            schedule: None,
            criteria: None,
            scale: 1.0,
            scaled_budget: None,
            expired: Vec::new(),
            new_candidates: Vec::new(),
            to_collapse: Vec::new(),
            split: Vec::new(),
            moved: Vec::new(),
            state,
            names,
            model,
        };
        view.rebuild(&mut Vec::new());
        view
    }

    /// Moves the view from its current detail to the detail that a camera needs. The work is
    /// proportional to the number of changes.
    ///
    /// # Errors
    /// The model has no positions, the allowed error is negative or NaN, or the direction to the
    /// light is zero or not finite.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut view = model.view();
    /// let camera = Camera::new([4.0, 2.0, 4.0], [4.0, 0.0, 4.0])?;
    /// view.update(&camera, &ViewCriteria::default().with_pixels(0.5))?;
    /// // The camera did not move, so there is nothing to do.
    /// let again = view.update(&camera, &ViewCriteria::default().with_pixels(0.5))?;
    /// assert_eq!((again.splits, again.collapses, again.looked_at, again.changed.len()), (0, 0, 0, 0));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn update(&mut self, camera: &Camera, criteria: &ViewCriteria) -> Result<ViewUpdate, Error> {
        if self.model.bounds.is_none() {
            let found = "none".into();
            return Err(Error::Parameter { name: "positions", found, expected: "a model with positions" });
        }
        criteria.check()?;
        let mut update = ViewUpdate { is_complete: true, ..ViewUpdate::default() };
        let frame = camera.frame();
        if criteria.budget.is_none() {
            self.scale = 1.0;
        }
        self.work(frame, criteria, &mut update);
        if let Some(budget) = criteria.budget {
            // The budget was lowered, or the base mesh exceeds it.
            while self.triangle_count > budget && self.scale < MAX_SCALE && update.is_complete {
                self.scale *= RISE;
                self.work(frame, criteria, &mut update);
            }
            let has_room = |view: &Self| (view.triangle_count as f64) < ROOM * budget as f64;
            let is_larger = self.scaled_budget.is_some_and(|before| before < budget);
            if is_larger && self.scale > 1.0 && has_room(self) && update.is_complete {
                // A larger budget is filled as in a new view: all splits are considered, largest
                // errors first.
                self.scale = 1.0;
                self.criteria = None;
                self.work(frame, criteria, &mut update);
            }
            if has_room(self) {
                // The triangle count grows about as fast as the allowed error falls, but faster
                // near the eye. The square root makes the step smaller.
                let filled = self.triangle_count as f64 / (ROOM * budget as f64);
                self.scale = (filled.sqrt().clamp(STEEPEST_FALL, FALL) * self.scale).max(1.0);
            }
        }
        if update.is_complete {
            self.scaled_budget = criteria.budget;
        }
        update.segments = self.rebuild(&mut update.changed);
        Ok(update)
    }

    fn collapse(&mut self, collapse_id: u32) {
        self.state.collapse(collapse_id, &self.model.tree);
        self.count_collapse(collapse_id);
    }

    /// Updates the counts for a collapse that the state has applied.
    fn count_collapse(&mut self, collapse_id: u32) {
        self.triangle_count -= self.model.dropped(collapse_id);
        self.active_count -= self.model.tree.members(collapse_id).count();
        self.moved.push(collapse_id);
    }

    /// Splits a collapse, after the collapses that depend on it, unless that would exceed the
    /// budget. Returns whether the collapse was split.
    fn split_within(&mut self, collapse_id: u32, budget: Option<usize>) -> bool {
        let model = &self.model;
        self.split.clear();
        self.state.force_split(collapse_id, (&model.tree, &model.dependencies), &mut self.split);
        let added: usize = self.split.iter().map(|&collapse_id| model.dropped(collapse_id)).sum();
        if budget.is_some_and(|budget| self.triangle_count + added > budget) {
            let undone = self.split.iter().rev();
            undone.for_each(|&collapse_id| self.state.collapse(collapse_id, &model.tree));
            return false;
        }
        self.triangle_count += added;
        self.active_count +=
            self.split.iter().map(|&collapse_id| model.tree.members(collapse_id).count()).sum::<usize>();
        self.moved.extend_from_slice(&self.split);
        true
    }

    /// Rebuilds the display strips that changed. Returns the number of segments scanned.
    fn rebuild(&mut self, changed: &mut Vec<Range<usize>>) -> usize {
        let Self { model, moved, state, display, names, .. } = self;
        let Some(display) = display else { return 0 };
        let nodes = moved.drain(..).flat_map(|collapse_id| model.tree.members(collapse_id));
        let mut nodes: Vec<u32> = nodes.collect();
        nodes.sort_unstable();
        nodes.dedup();
        // Ancestors come before their descendants. A descendant of a moved node is collapsed into
        // it, or was moved too and is processed later.
        let mut flagged = 0;
        for node in nodes {
            let end = model.tree.end(node);
            let drawn = match model.tree.parent(node).filter(|_| state.is_collapsed(node)) {
                Some(parent) => names[parent as usize],
                None => model.tree.vertex(node),
            };
            names[node as usize..end as usize].fill(drawn);
            if node >= flagged {
                display.flag(node..end, &model.strips);
                flagged = end;
            }
        }
        display.rebuild(&model.strips, names, changed)
    }

    /// Returns the collapses applied or undone since the last call, by id, in order of execution.
    /// For views without display strips.
    pub(super) fn take_moved(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.moved)
    }

    /// Returns the model.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert!(Arc::ptr_eq(&model, model.view().model()));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn model(&self) -> &Arc<SkipStrips> {
        &self.model
    }

    /// Returns the index buffer to draw: the display strips, separated by [`RESTART`]. Unused
    /// entries are [`RESTART`], too.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let view = model.view();
    /// let sent = view.indices().iter().filter(|&&index| index != RESTART).count();
    /// assert_eq!(sent, view.display_strips().vertices_sent());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices(&self) -> &[u32] {
        self.display.as_ref().map_or(&[], Display::indices)
    }

    /// Iterates over the ranges of [`SkipView::indices`] that contain strips, in the order of the
    /// strips. Each range contains many strips. All entries between ranges are [`RESTART`].
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let view = model.view();
    /// assert!(view.ranges().all(|range| view.indices()[range.start] != RESTART));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.display.iter().flat_map(Display::ranges)
    }

    /// Returns a copy of the display strips. They use the vertex ids of the full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let view = model.view();
    /// assert_eq!(view.display_strips().triangles().count(), view.triangle_count());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn display_strips(&self) -> Strips {
        self.display.as_ref().map_or_else(Strips::default, Display::to_strips)
    }

    /// Returns the number of triangles of the view.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert!(model.view().triangle_count() < model.full_view().triangle_count());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// Returns the number of active vertices. A vertex is active unless it has collapsed.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(model.full_view().active_vertex_count(), 81);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn active_vertex_count(&self) -> usize {
        self.active_count
    }

    /// Returns the triangles of the view, computed without its display strips. Each vertex of the
    /// full mesh is replaced by its first active ancestor, found by following parent pointers, and
    /// degenerate triangles are removed. Tests compare the display strips with this list.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let view = model.view();
    /// assert_eq!(view.renamed_triangles().len(), view.triangle_count());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn renamed_triangles(&self) -> Vec<[u32; 3]> {
        let tree = &self.model.tree;
        let name = |mut node: u32| {
            while let Some(parent) = tree.parent(node).filter(|_| self.state.is_collapsed(node)) {
                node = parent;
            }
            tree.vertex(node)
        };
        let strips = self.model.strips.all().split(|&node| node == RESTART);
        let renamed = strips.flat_map(|strip| strip_triangles(strip).map(|triangle| triangle.map(name)));
        renamed.filter(|&triangle| !is_degenerate(triangle)).collect()
    }

    /// Returns the applied collapses in ascending order, as positions in the collapse sequence.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(model.view().collapses_done().count(), model.levels().collapse_count());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn collapses_done(&self) -> impl Iterator<Item = usize> {
        let order = self.model.order.iter().enumerate();
        let is_collapsed = |collapse_id: OptionalId| {
            collapse_id.get().is_none_or(|collapse_id| self.state.is_collapsed(collapse_id))
        };
        order.filter(move |&(_, &collapse_id)| is_collapsed(collapse_id)).map(|(number, _)| number)
    }

    /// Returns the simplified strips: the strips of the full mesh with each vertex replaced by its
    /// first active ancestor. This method finds ancestors with the skip pointers. It does not use
    /// the first active ancestors that the view stores.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut view = model.view();
    /// let simplified = view.simplified_strips();
    /// assert_eq!(Filter::Dtfs.strips(&simplified).triangles().count(), view.triangle_count());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn simplified_strips(&mut self) -> Strips {
        let model = Arc::clone(&self.model);
        let mut strips = Strips::default();
        let mut strip = Vec::new();
        for nodes in model.strips.all().split(|&node| node == RESTART).filter(|nodes| !nodes.is_empty()) {
            strip.clear();
            let names = nodes.iter().map(|&node| self.state.representative(node, &model.tree));
            strip.extend(names.map(|node| model.tree.vertex(node)));
            strips.push(&strip);
        }
        strips
    }

    /// Returns the mean number of pointers followed from a strip vertex of the full mesh to its
    /// first active ancestor, for three methods: parent pointers only, skip pointers starting with
    /// the highest, and skip pointers starting with the one used last.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let [parents, skips, used_last] = model.view().mean_hops();
    /// assert!(skips <= parents && used_last <= parents);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn mean_hops(&mut self) -> [f64; 3] {
        let model = Arc::clone(&self.model);
        let (mut sums, mut count) = ([0_u64; 3], 0_u64);
        for &node in model.strips.all().iter().filter(|&&node| node != RESTART) {
            let hops = self.state.hops(node, &model.tree);
            sums = [0, 1, 2].map(|k| sums[k] + u64::from(hops[k]));
            count += 1;
        }
        sums.map(|sum| if count == 0 { 0.0 } else { sum as f64 / count as f64 })
    }

    /// Returns the memory of the view in bytes, excluding the model.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert!(model.view().memory() > 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn memory(&self) -> usize {
        let schedule = self.schedule.as_ref().map_or(0, Schedule::memory);
        let lists =
            [&self.names, &self.expired, &self.new_candidates, &self.to_collapse, &self.split, &self.moved]
                .map(|list| size_of_val(&list[..]));
        self.state.memory()
            + self.display.as_ref().map_or(0, Display::memory)
            + schedule
            + lists.iter().sum::<usize>()
    }

    /// Checks whether a node has collapsed.
    #[cfg(test)]
    pub(super) fn is_collapsed(&self, node: u32) -> bool {
        self.state.is_collapsed(node)
    }

    /// Makes the next update evaluate every collapse.
    #[cfg(test)]
    pub(super) fn forget_schedule(&mut self) {
        self.criteria = None;
    }
}
