use proptest::prelude::*;

use super::*;
use crate::entropy::range_coder::RangeDecoder;
use crate::stream::base::code_triangles;

impl StreamSurface {
    /// Checks that opposite corners share an edge, that each corner is in the ring of its fan, and
    /// that open fans start at their first corner.
    pub(in super::super) fn check(&self) -> Result<(), String> {
        for corner in self.corners() {
            let opposite = self.opposite(corner);
            if opposite == NONE {
                continue;
            }
            if opposite == corner
                || opposite & 7 > 2
                || triangle_of(opposite) as usize >= self.triangle_count()
            {
                return Err(format!("corner {corner} has corner {opposite} opposite"));
            }
            let ends = |corner: u32| [self.fan(next(corner)), self.fan(previous(corner))];
            let [from, to] = ends(opposite);
            if self.opposite(opposite) != corner || ends(corner) != [to, from] {
                return Err(format!("corners {corner} and {opposite} are not opposite to each other"));
            }
        }
        let mut is_found = vec![false; self.cells.len()];
        for (fan, &first) in (0..).zip(&self.first) {
            let mut at = (first != NONE).then_some(first);
            if at.is_some_and(|first| self.before(first).is_some()) != (at.is_some() && !self.is_open(fan)) {
                return Err(format!("fan {fan}: whether it is open"));
            }
            while let Some(corner) = at {
                if self.fan(corner) != fan || std::mem::replace(&mut is_found[corner as usize], true) {
                    return Err(format!("fan {fan}: corner {corner} of fan {}", self.fan(corner)));
                }
                at = self.after(corner).filter(|&corner| corner != first);
                // A fan that is not closed has no corner before its first one.
                if at.is_none() && self.after(corner).is_some() != self.before(first).is_some() {
                    return Err(format!("fan {fan} starts at corner {first}"));
                }
            }
        }
        match self.corners().find(|&corner| !is_found[corner as usize]) {
            Some(corner) => Err(format!("corner {corner} is in no fan")),
            None => Ok(()),
        }
    }
}

/// Generates a surface by joining triangles according to random bytes.
fn surface() -> impl Strategy<Value = StreamSurface> {
    (1..40_usize, prop::collection::vec(any::<u8>(), 0..60)).prop_filter_map(
        "edges twice",
        |(count, bytes)| {
            let mut coder = RangeDecoder::new(&bytes);
            let (opposite, _) = code_triangles(&mut coder, count, &[]).ok()?;
            Some(StreamSurface::new(&opposite)).filter(StreamSurface::has_distinct_fans)
        },
    )
}

/// Returns a split of a fan that the models could code.
fn split_of(ring: &[u32], is_open: bool, [start, count, adds]: [u16; 3]) -> Split {
    let n = ring.len();
    if is_open && adds & 4 == 0 {
        let at_start = adds & 1 == 0;
        return Split { start: if at_start { 0 } else { n }, count: 0, is_open, adds: [!at_start, at_start] };
    }
    let start = usize::from(start) % n;
    let most = if is_open { n - start } else { n - 1 };
    let count = 1 + usize::from(count) % most;
    let [may_start, may_end] = [is_open && start == 0, is_open && start + count == n];
    let adds_start = !may_start || adds & 1 == 0;
    let adds_end = !may_end || !adds_start || adds & 2 == 0;
    Split { start, count, is_open, adds: [adds_start, adds_end] }
}

proptest! {
    #[test]
    fn splits_keep_the_table((mut surface, splits) in (surface(), prop::collection::vec(any::<[u16; 4]>(), 0..60))) {
        surface.check().map_err(TestCaseError::fail)?;
        let mut ring = Ring::new();
        for [fan, choices @ ..] in splits {
            let fan = u32::from(fan) % surface.first.len() as u32;
            surface.ring(fan, NONE, &mut ring);
            let (corners, is_open) = (ring.corners().to_vec(), ring.is_open);
            if corners.len() < if is_open { 1 } else { 2 } {
                continue;
            }
            let split = split_of(&corners, is_open, choices);
            let before = surface.triangle_count();
            ring.repeat(split);
            let added = surface.split(fan, &ring, split, 0);
            prop_assert!(surface.has_distinct_fans());
            surface.check().map_err(|fault| TestCaseError::fail(format!("{fault} after {split:?} of {corners:?}")))?;
            prop_assert_eq!(surface.triangle_count() - before, split.adds.iter().filter(|&&adds| adds).count());
            let new = surface.first.len() as u32 - 1;
            for corner in added.into_iter().filter(|&corner| corner != NONE) {
                prop_assert_eq!(surface.fan(corner), fan);
                prop_assert!([next(corner), previous(corner)].iter().any(|&corner| surface.fan(corner) == new));
            }
            surface.ring(new, NONE, &mut ring);
            // A fan with added triangles on both sides is closed.
            prop_assert_eq!(ring.is_open, split.adds != [true; 2]);
            prop_assert_eq!(ring.corners().len(), split.count + added.iter().filter(|&&corner| corner != NONE).count());
        }
    }
}

#[test]
fn a_fan_on_the_border_is_split_at_its_end() {
    // One triangle. Add a triangle at the end of the fan of corner 0, then one before its start.
    let mut surface = StreamSurface::new(&[NONE; 3]);
    let mut ring = Ring::new();
    surface.ring(0, NONE, &mut ring);
    surface.split(0, &ring, Split { start: 0, count: 0, is_open: true, adds: [false, true] }, 0);
    surface.check().unwrap();
    surface.ring(0, NONE, &mut ring);
    assert_eq!((surface.triangle_count(), ring.corners(), ring.is_open), (2, &[8, 0][..], true));
    surface.split(0, &ring, Split { start: 2, count: 0, is_open: true, adds: [true, false] }, 0);
    surface.check().unwrap();
    surface.ring(0, NONE, &mut ring);
    assert_eq!((surface.triangle_count(), ring.corners(), ring.is_open), (3, &[8, 0, 16][..], true));
}
