//! The strips of an `eta` search: the links and the identifier of each triangle. Identifiers are
//! rewritten node by node.
//!
//! ```text
//!   ┄┄ v ━━ b        the step to b cuts v–b, and writes the tip's identifier on v and beyond
//!      ┃
//! ```
//! # Complexity
//! 20 bytes per triangle. The time of a step is linear in the length of the strip part that the
//! step writes to.

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};
use crate::stripify::tunnel::path_tags::{PathTags, TunnelStep};

/// What a side of a triangle is linked to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TagLink {
    /// Nothing: the triangle is the end of a strip.
    Free,
    /// The rest of the strip, which ends outside the star.
    Outside,
    /// The triangle across a half-edge.
    Black(u32),
    /// A triangle at which the strip returns into the star.
    Temporary(u32),
}

/// The links and identifiers of triangles.
#[derive(Debug)]
pub(super) struct TaggedStrips {
    links: Vec<[TagLink; 2]>,
    tags: Vec<u32>,
    /// Triangles accessed by writing identifiers and by following strips, since the last call of
    /// [`Self::take_accesses`].
    accesses: u64,
}

/// The data to undo a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct UndoStep {
    step: TunnelStep,
    /// The old identifier of the part that the step linked to the tip.
    tag: u32,
}

impl TaggedStrips {
    /// Creates the strips of a cover. The identifier of a strip is the number of its path.
    pub(super) fn new(cover: &PathCover, tags: &PathTags) -> Self {
        let triangles = 0..cover.len() as u32;
        let link = |edge: Option<HalfEdge>| edge.map_or(TagLink::Free, |h| TagLink::Black(h.0));
        Self {
            links: triangles.clone().map(|t| cover.edges(FaceId(t)).map(link)).collect(),
            tags: triangles.map(|t| tags.path(t)).collect(),
            accesses: 0,
        }
    }

    /// Replaces one link of a triangle by another.
    pub(super) fn replace(&mut self, triangle: u32, old: TagLink, new: TagLink) {
        let links = &mut self.links[triangle as usize];
        if let Some(link) = links.iter_mut().find(|link| **link == old) {
            *link = new;
        }
    }

    /// Returns the links of a triangle.
    #[inline]
    pub(super) fn links(&self, triangle: u32) -> [TagLink; 2] {
        self.links[triangle as usize]
    }

    /// Returns whether a tunnel may end with a red edge from `tip` to `x`: whether `x` is the end
    /// of another strip.
    #[inline]
    pub(super) fn may_end(&self, tip: u32, x: u32) -> bool {
        self.links(x).contains(&TagLink::Free) && self.tags[x as usize] != self.tags[tip as usize]
    }

    /// Returns the number of triangles accessed since the last call.
    pub(super) fn take_accesses(&mut self) -> u64 {
        std::mem::take(&mut self.accesses)
    }

    /// Cuts `v` from its neighbour `b`, links it to the tip, and writes identifiers. Returns `None`
    /// and changes nothing if that would close a loop.
    pub(super) fn step(&mut self, graph: &DualGraph, step: TunnelStep) -> Option<UndoStep> {
        let (tip, v) = (step.red / 3, graph.twin_of(step.red)? / 3);
        let black = step.black.get()?;
        let (tag, tip_tag) = (self.tags[v as usize], self.tags[tip as usize]);
        self.cut(graph, black);
        if tag == tip_tag {
            // Both are on one strip: there is no loop if the cut separates them.
            if self.leads_to(graph, v, tip) {
                self.link(graph, black);
                return None;
            }
        } else {
            self.write(graph, v, tip_tag);
        }
        self.link(graph, step.red);
        Some(UndoStep { step, tag })
    }

    /// Undoes a step.
    pub(super) fn undo(&mut self, graph: &DualGraph, UndoStep { step, tag }: UndoStep) {
        let (Some(twin), Some(black)) = (graph.twin_of(step.red), step.black.get()) else { return };
        self.cut(graph, step.red);
        if self.tags[twin as usize / 3] != tag {
            self.write(graph, twin / 3, tag);
        }
        self.link(graph, black);
    }

    /// Links the tip to the end of another strip, and writes the tip's identifier to that strip.
    pub(super) fn end(&mut self, graph: &DualGraph, red: u32) {
        let Some(twin) = graph.twin_of(red) else { return };
        self.write(graph, twin / 3, self.tags[red as usize / 3]);
        self.link(graph, red);
    }

    /// Writes the identifiers of the strips that a tunnel has changed, from end to end.
    pub(super) fn write_changed(&mut self, graph: &DualGraph, tags: &PathTags, tunnel: &[TunnelStep]) {
        let mut paths: Vec<u32> = tunnel.iter().map(|step| tags.path(step.red / 3)).collect();
        paths.sort_unstable();
        paths.dedup();
        for path in paths {
            if let Some(first) = tags.first(path) {
                self.write(graph, first, path);
            }
        }
    }

    fn cut(&mut self, graph: &DualGraph, half_edge: u32) {
        let Some(twin) = graph.twin_of(half_edge) else { return };
        for h in [half_edge, twin] {
            self.replace(h / 3, TagLink::Black(h), TagLink::Free);
        }
    }

    fn link(&mut self, graph: &DualGraph, half_edge: u32) {
        let Some(twin) = graph.twin_of(half_edge) else { return };
        for h in [half_edge, twin] {
            self.replace(h / 3, TagLink::Free, TagLink::Black(h));
        }
    }

    /// Writes an identifier to every triangle of a strip, starting at one of its ends.
    fn write(&mut self, graph: &DualGraph, end: u32, tag: u32) {
        let mut at = StripPosition::at_end(end);
        loop {
            self.tags[at.triangle as usize] = tag;
            self.accesses += 1;
            match self.next(graph, at) {
                Some(next) => at = next,
                None => return,
            }
        }
    }

    /// Returns whether a triangle is on the strip with this end.
    fn leads_to(&mut self, graph: &DualGraph, end: u32, triangle: u32) -> bool {
        let mut at = StripPosition::at_end(end);
        loop {
            self.accesses += 1;
            if at.triangle == triangle {
                return true;
            }
            match self.next(graph, at) {
                Some(next) => at = next,
                None => return false,
            }
        }
    }

    /// Returns the next position on a strip, or `None` at the end of the strip or of its part
    /// within the star.
    #[inline]
    fn next(&self, graph: &DualGraph, at: StripPosition) -> Option<StripPosition> {
        let [first, second] = self.links(at.triangle);
        match if first == at.back { second } else { first } {
            TagLink::Black(h) => {
                let twin = graph.twin_of(h)?;
                Some(StripPosition { triangle: twin / 3, back: TagLink::Black(twin) })
            }
            TagLink::Temporary(next) => {
                Some(StripPosition { triangle: next, back: TagLink::Temporary(at.triangle) })
            }
            TagLink::Free | TagLink::Outside => None,
        }
    }
}

/// A position on a strip: a triangle, and the link over which it was reached.
#[derive(Debug, Clone, Copy)]
struct StripPosition {
    triangle: u32,
    back: TagLink,
}

impl StripPosition {
    /// Returns the position at an end of a strip. An end has at most one link.
    fn at_end(triangle: u32) -> Self {
        Self { triangle, back: TagLink::Free }
    }
}
