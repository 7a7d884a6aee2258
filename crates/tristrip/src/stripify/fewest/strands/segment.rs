//! Places, segments and strands: what the paths are made of between two numberings.

/// Where a triangle stood when the paths were numbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
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
    pub(super) fn turned(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }

    #[inline]
    pub(super) fn holds(&self, place: Place) -> bool {
        self.path == place.path && self.low <= place.position && place.position <= self.high
    }

    pub(super) fn last(&self) -> u32 {
        if self.reversed { self.low } else { self.high }
    }

    /// Splits the segment behind a position, in its own direction; the second part is `None` behind its last position.
    pub(super) fn split_behind(self, position: u32) -> (Self, Option<Self>) {
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

/// A path as it is now, from its head to its tail. No segments: it was joined to another.
#[derive(Debug, Clone, Default)]
pub(super) struct Strand {
    pub(super) segments: Vec<Segment>,
    pub(super) head: u32,
    pub(super) tail: u32,
}

impl Strand {
    /// Becomes the same as another; its buffer is kept.
    pub(super) fn copy(&mut self, other: &Self) {
        self.segments.clone_from(&other.segments);
        (self.head, self.tail) = (other.head, other.tail);
    }

    pub(super) fn turn(&mut self) {
        self.segments.reverse();
        self.segments.iter_mut().for_each(|s| *s = s.turned());
        std::mem::swap(&mut self.head, &mut self.tail);
    }
}
