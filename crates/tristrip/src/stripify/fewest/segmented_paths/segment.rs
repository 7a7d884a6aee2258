//! Positions on numbered paths, ranges of them, and paths as lists of ranges.

/// The position of a triangle at the last numbering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PathPosition {
    pub(super) path: u32,
    pub(super) position: u32,
}

/// Positions `low` to `high` of a numbered path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub(super) path: u32,
    pub(super) low: u32,
    pub(super) high: u32,
    pub(super) reversed: bool,
}

impl Segment {
    pub(super) fn reverse(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }

    #[inline]
    pub(super) fn contains(&self, at: PathPosition) -> bool {
        self.path == at.path && self.low <= at.position && at.position <= self.high
    }

    /// Returns the last position in the segment's own direction.
    pub(super) fn last(&self) -> u32 {
        if self.reversed { self.low } else { self.high }
    }

    /// Splits the segment after a position, in its own direction. The second part is `None` if the
    /// position is the last one.
    pub(super) fn split_after(self, position: u32) -> (Self, Option<Self>) {
        if position == self.last() {
            (self, None)
        } else if self.reversed {
            (Self { low: position, ..self }, Some(Self { high: position - 1, ..self }))
        } else {
            (Self { high: position, ..self }, Some(Self { low: position + 1, ..self }))
        }
    }

    pub(super) fn len(&self) -> usize {
        (self.high - self.low) as usize + 1
    }
}

/// A current path, from its head to its tail. A path that was joined to another path has no
/// segments.
#[derive(Debug, Clone, Default)]
pub(super) struct SegmentedPath {
    pub(super) segments: Vec<Segment>,
    pub(super) head: u32,
    pub(super) tail: u32,
}

impl SegmentedPath {
    /// Copies another path into this one, reusing the allocation.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.segments.clone_from(&other.segments);
        (self.head, self.tail) = (other.head, other.tail);
    }

    pub(super) fn reverse(&mut self) {
        reverse_segments(&mut self.segments);
        std::mem::swap(&mut self.head, &mut self.tail);
    }
}

/// Reverses the direction of a sequence of segments.
pub(super) fn reverse_segments(segments: &mut [Segment]) {
    segments.reverse();
    segments.iter_mut().for_each(|segment| *segment = segment.reverse());
}
