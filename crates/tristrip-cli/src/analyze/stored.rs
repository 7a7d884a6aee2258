//! What a part of a file makes a graphics processor do, as it stands there.
//!
//! Strips are what stands between restarts; where a vertex follows itself inside, degenerate triangles join two strips, which
//! are taken apart to be counted, and stay joined as they are sent. Polygons are drawn as fans of triangles.

use std::borrow::Cow;
use std::collections::HashMap;

use serde::Serialize;
use tristrip::strip::layout::pieces;
use tristrip::strip::{Between, Buffer, BufferUse, Metrics};
use tristrip::{Mesh, Strips};
use tristrip_io::Part;

/// How a part is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Drawn {
    List,
    Strips,
    Fans,
    /// Parts differ.
    Mixed,
}

impl Drawn {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::List => "list",
            Self::Strips => "strips",
            Self::Fans => "fans",
            Self::Mixed => "mixed",
        }
    }
}

/// The figures of a part, or the sum over all; the keys are those of the JSON report. What only strips have is `None` where there
/// are none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Figures {
    pub(super) drawn: Drawn,
    /// Real triangles.
    pub(super) triangles: usize,
    /// Vertices in use.
    pub(super) vertices: usize,
    /// As stored, restarts included.
    pub(super) indices: usize,
    pub(super) restarts: usize,
    /// Triangles with a repeated vertex that the indices draw.
    pub(super) degenerate: usize,
    pub(super) strips: Option<usize>,
    pub(super) isolated: Option<usize>,
    pub(super) swaps: Option<usize>,
    pub(super) vertices_sent: Option<usize>,
}

/// Strips of 2ᵏ to 2ᵏ⁺¹ − 1 triangles, for k = 0, 1, 2 …
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Lengths(Vec<Bin>);

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub(super) struct Bin {
    /// Triangles of the shortest strips.
    pub(super) from: usize,
    /// Triangles of the longest strips.
    pub(super) to: usize,
    pub(super) strips: usize,
    pub(super) triangles: usize,
}

impl Lengths {
    fn of(strips: &Strips) -> Self {
        let mut lengths = Self::default();
        for strip in strips.iter() {
            lengths.add(tristrip::strip::strip_triangles(strip).count(), 1);
        }
        lengths
    }

    /// Adds strips that have so many triangles together, those of one bin.
    fn add(&mut self, triangles: usize, strips: usize) {
        let Some(k) = (triangles / strips.max(1)).checked_ilog2() else { return };
        while self.0.len() <= k as usize {
            let from = 1 << self.0.len();
            self.0.push(Bin { from, to: 2 * from - 1, ..Bin::default() });
        }
        let bin = &mut self.0[k as usize];
        bin.strips += strips;
        bin.triangles += triangles;
    }

    pub(super) fn bins(&self) -> &[Bin] {
        &self.0
    }
}

impl Bin {
    /// Writes the range of lengths.
    pub(super) fn name(&self) -> String {
        if self.from == self.to { self.from.to_string() } else { format!("{}–{}", self.from, self.to) }
    }
}

/// A part, looked at once.
#[derive(Debug)]
pub(super) struct Stored<'a> {
    part: &'a Part,
    /// The indices of a list.
    list: Cow<'a, [u32]>,
    /// Strips, joins taken apart.
    strips: Strips,
    pub(super) figures: Figures,
    pub(super) lengths: Lengths,
}

impl<'a> Stored<'a> {
    pub(super) fn of(part: &'a Part) -> Self {
        let mut strips = Strips::default();
        let mut list = Cow::default();
        let vertex_count = part.mesh.vertex_count();
        let mut figures = Figures {
            drawn: Drawn::List,
            triangles: 0,
            vertices: 0,
            indices: 0,
            restarts: 0,
            degenerate: 0,
            strips: None,
            isolated: None,
            swaps: None,
            vertices_sent: None,
        };
        if let Some(stored) = &part.stored {
            figures.indices = stored.indices();
            figures.restarts = stored.restarts;
            figures.triangles = part.mesh.faces().face_count();
            figures.vertices = BufferUse::of(&stored.runs, NONE, Between::Keep, vertex_count).vertices;
            let drawn: usize = stored.runs.iter().map(|run| run.len().saturating_sub(2)).sum();
            figures.degenerate = drawn.saturating_sub(figures.triangles);
            figures.drawn = if stored.fans { Drawn::Fans } else { Drawn::Strips };
            if !stored.fans {
                stored.runs.iter().flat_map(pieces).for_each(|strip| strips.push(strip));
                let metrics = Metrics::of(&strips);
                figures.strips = Some(metrics.strips);
                figures.isolated = Some(metrics.isolated);
                figures.swaps = Some(metrics.swaps);
                figures.vertices_sent = Some(metrics.vertices_sent);
            }
        } else {
            list = triangle_list(&part.mesh);
            figures.indices = list.len();
            let used = BufferUse::of_list(&list, NONE, vertex_count);
            (figures.triangles, figures.vertices) = (used.triangles, used.vertices);
            figures.degenerate = list.len() / 3 - figures.triangles;
        }
        let lengths = Lengths::of(&strips);
        Self { part, list, strips, figures, lengths }
    }

    /// Gives the vertices of the indices, in their order.
    fn sent(&self) -> &[u32] {
        self.part.stored.as_ref().map_or(&*self.list, |stored| stored.runs.vertices())
    }

    /// Draws the part with each buffer; flushed buffers are so between strips, whose joins are then not sent.
    pub(super) fn with_each(&self, buffers: &[Buffer], between: Between) -> Vec<BufferUse> {
        let count = self.part.mesh.vertex_count();
        let mut each = match &self.part.stored {
            None => BufferUse::of_list_each(&self.list, buffers, count),
            Some(stored) if stored.fans || between == Between::Keep => {
                BufferUse::of_each(&stored.runs, buffers, between, count)
            }
            Some(_) => BufferUse::of_each(&self.strips, buffers, between, count),
        };
        // What a fan draws is not what a strip of its vertices would.
        each.iter_mut().for_each(|used| used.triangles = self.figures.triangles);
        each
    }
}

/// Counts the vertices that parts use; those that several of them share once.
pub(super) fn vertices_of(parts: &[Stored<'_>]) -> usize {
    let mut used: HashMap<*const [f32; 3], Vec<bool>> = HashMap::new();
    for part in parts {
        let positions = part.part.mesh.positions();
        let used = used.entry(positions.as_ptr()).or_insert_with(|| vec![false; positions.len()]);
        part.sent().iter().for_each(|&vertex| used[vertex as usize] = true);
    }
    used.values().map(|used| used.iter().filter(|&&used| used).count()).sum()
}

/// Sums over parts; their vertices may be the same ones, see [`vertices_of`].
impl std::iter::Sum for Figures {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        let add = |a: Option<usize>, b: Option<usize>| a.map_or(b, |a| Some(a + b.unwrap_or(0)));
        let both = |a: Self, b: Self| Self {
            drawn: if a.drawn == b.drawn { a.drawn } else { Drawn::Mixed },
            triangles: a.triangles + b.triangles,
            vertices: a.vertices + b.vertices,
            indices: a.indices + b.indices,
            restarts: a.restarts + b.restarts,
            degenerate: a.degenerate + b.degenerate,
            strips: add(a.strips, b.strips),
            isolated: add(a.isolated, b.isolated),
            swaps: add(a.swaps, b.swaps),
            vertices_sent: add(a.vertices_sent, b.vertices_sent),
        };
        parts.reduce(both).unwrap_or_else(|| Stored::of(&Part::default()).figures)
    }
}

/// Sums over parts.
impl std::iter::Sum for Lengths {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        let mut sum = Self::default();
        for bin in parts.flat_map(|part| part.0) {
            sum.add(bin.triangles, bin.strips);
        }
        sum
    }
}

/// A buffer that is asked only for what does not depend on it.
const NONE: Buffer = Buffer::fifo(1);

/// Gives a mesh as a triangle list, polygons as fans around their first corner.
fn triangle_list(mesh: &Mesh) -> Cow<'_, [u32]> {
    match mesh.faces().as_triangles() {
        Some(corners) => Cow::Borrowed(corners),
        None => mesh
            .faces()
            .iter()
            .flat_map(|face| (2..face.len()).flat_map(|i| [face[0], face[i - 1], face[i]]))
            .collect(),
    }
}
