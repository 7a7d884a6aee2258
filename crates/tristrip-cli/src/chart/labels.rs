//! Where labels stand: beside their points, or, where all have to be shown, further off at the end of a thin line.
//!
//! ```text
//!      above                   · · · ·
//!  left  ●  right   and then   ·  ●  ·   squares of places around the point, each wider than the last, until one is free
//!      below                   · · · ·
//! ```
//! Labels are placed one after the other, the first ones best. Places are whole pixels, so that no machine's rounding decides.

use super::Frame;

/// From a point to the label beside it, in pixels.
const BESIDE: i32 = 7;
/// Half the height of a label.
const HALF: i32 = 6;
/// From one ring of places to the next.
const RING: i32 = 9;
/// Rings around a point.
const RINGS: i32 = 20;
/// Half the side of what a mark covers.
const MARK: i32 = 5;
/// From one place of a ring to the next.
const STEP: i32 = 6;

/// A text that wants a place.
#[derive(Debug, Clone)]
pub(super) struct Label {
    /// The point that it belongs to.
    pub(super) at: (i32, i32),
    pub(super) text: String,
    pub(super) width: i32,
}

/// The place of a label.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Spot {
    pub(super) frame: Frame,
    /// The line from its point, where it stands far off.
    pub(super) leader: Option<((i32, i32), (i32, i32))>,
}

/// What labels keep away from.
#[derive(Debug, Clone, Default)]
pub(super) struct Obstacles {
    marks: Vec<Frame>,
    lines: Vec<Frame>,
}

impl Obstacles {
    /// Adds the mark of a point.
    pub(super) fn mark(&mut self, at: (i32, i32)) {
        self.marks.push([at.0 - MARK, at.1 - MARK, at.0 + MARK, at.1 + MARK]);
    }

    /// Adds a line through points.
    pub(super) fn line(&mut self, points: impl Iterator<Item = (i32, i32)>) {
        let mut last = None;
        for point in points {
            let from = last.replace(point).unwrap_or(point);
            self.lines.extend(beads(from, point));
        }
    }
}

/// Gives each label its place, or none where there is no room. With obstacles all places around a point are tried, else four
/// beside it.
pub(super) fn place(labels: &[Label], bounds: Frame, obstacles: Option<Obstacles>) -> Vec<Option<Spot>> {
    let everywhere = obstacles.is_some();
    let mut taken = Taken { bounds, obstacles: obstacles.unwrap_or_default(), ..Taken::default() };
    let mut spots = Vec::with_capacity(labels.len());
    for label in labels {
        let spot = Care::ALL.into_iter().find_map(|care| {
            candidates(label, everywhere).find(|spot| taken.leaves_room(spot, label.at, care))
        });
        if let Some(spot) = &spot {
            taken.labels.push(spot.frame);
            taken.leaders.extend(spot.leader.into_iter().flat_map(|(from, to)| beads(from, to)));
        }
        spots.push(spot);
    }
    spots
}

/// What labels and their thin lines keep away from: the less, the sooner there is a place. No label ever covers a label or a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Care {
    /// No more than that: only where labels are all around a point.
    Least,
    /// No label covers a thin line, and no thin line crosses a label.
    Labels,
    /// No thin line crosses another either, or a mark but its own.
    Marks,
    /// No label covers a line either.
    Lines,
}

impl Care {
    /// In the order in which they are tried.
    const ALL: [Self; 4] = [Self::Lines, Self::Marks, Self::Labels, Self::Least];
}

/// Where nothing can stand any more.
#[derive(Debug, Default)]
struct Taken {
    bounds: Frame,
    labels: Vec<Frame>,
    leaders: Vec<Frame>,
    obstacles: Obstacles,
}

impl Taken {
    fn leaves_room(&self, spot: &Spot, at: (i32, i32), care: Care) -> bool {
        let Obstacles { marks, lines } = &self.obstacles;
        let free = |of: &[Frame], frame: &Frame| of.iter().all(|other| !overlap(frame, other));
        let frame = &spot.frame;
        let own = |bead: &Frame| (bead[0] - at.0).abs() <= MARK && (bead[1] - at.1).abs() <= MARK;
        let clear = |bead: Frame| {
            let crosses = !free(marks, &bead) || !free(&self.leaders, &bead);
            free(&self.labels, &bead) && (care < Care::Marks || own(&bead) || !crosses)
        };
        inside(frame, &self.bounds)
            && free(&self.labels, frame)
            && free(marks, frame)
            && (care < Care::Labels || free(&self.leaders, frame))
            && (care < Care::Lines || free(lines, frame))
            && (care < Care::Labels || spot.leader.is_none_or(|(from, to)| beads(from, to).all(clear)))
    }
}

/// Lists the places of a label, from near to far.
fn candidates(label: &Label, everywhere: bool) -> impl Iterator<Item = Spot> + '_ {
    let (x, y) = label.at;
    let frame = |(left, middle): (i32, i32)| [left, middle - HALF, left + label.width, middle + HALF];
    let half = label.width / 2;
    let near = [(x + BESIDE, y), (x - half, y - 12), (x - BESIDE - label.width, y), (x - half, y + 12)];
    let near = near.map(|at| Spot { frame: frame(at), leader: None });
    let rings = 1..=if everywhere { RINGS } else { 0 };
    let far = rings.flat_map(|ring| square(BESIDE + RING * ring)).map(move |(dx, dy)| {
        let left = if dx >= 0 { x + dx } else { x + dx - label.width };
        let frame = frame((left, y + dy));
        let end = (x.clamp(frame[0] - 1, frame[2]), y.clamp(frame[1] + 1, frame[3] - 1));
        Spot { frame, leader: Some((label.at, end)) }
    });
    near.into_iter().chain(far)
}

/// Lists places along the sides of a square around 0, the middle of each side first.
fn square(half: i32) -> impl Iterator<Item = (i32, i32)> {
    let along = (0..=half / STEP).flat_map(|i| [i * STEP, -i * STEP]);
    along.flat_map(move |offset| [(half, offset), (-half, offset), (offset, -half), (offset, half)])
}

/// Covers a line with small frames.
fn beads(from: (i32, i32), to: (i32, i32)) -> impl Iterator<Item = Frame> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let count = (dx.abs().max(dy.abs()) / 3).max(1);
    (0..=count).map(move |i| {
        let (x, y) = (from.0 + dx * i / count, from.1 + dy * i / count);
        [x - 1, y - 1, x + 1, y + 1]
    })
}

fn inside(frame: &Frame, bounds: &Frame) -> bool {
    frame[0] >= bounds[0] && frame[1] >= bounds[1] && frame[2] <= bounds[2] && frame[3] <= bounds[3]
}

fn overlap(a: &Frame, b: &Frame) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Frame = [0, 0, 800, 300];

    fn label(at: (i32, i32)) -> Label {
        Label { at, text: "a label".into(), width: 70 }
    }

    #[test]
    fn labels_cover_neither_labels_nor_marks() {
        let labels: Vec<Label> = (0..16).map(|i| label((300 + 11 * (i % 4), 150 + 7 * (i / 4)))).collect();
        let mut obstacles = Obstacles::default();
        labels.iter().for_each(|label| obstacles.mark(label.at));
        let marks = obstacles.marks.clone();
        let spots = place(&labels, BOUNDS, Some(obstacles));
        let spots: Vec<Spot> = spots.into_iter().flatten().collect();
        assert!(spots.len() == 16, "{} of 16", spots.len());
        for (number, spot) in spots.iter().enumerate() {
            assert!(inside(&spot.frame, &BOUNDS));
            assert!(marks.iter().all(|mark| !overlap(mark, &spot.frame)));
            for other in spots.iter().take(number) {
                assert!(!overlap(&spot.frame, &other.frame));
            }
        }
    }

    #[test]
    fn a_thin_line_crosses_no_label_where_there_is_room() {
        let labels: Vec<Label> = (0..5).map(|i| label((300, 100 + 4 * i))).collect();
        let mut obstacles = Obstacles::default();
        labels.iter().for_each(|label| obstacles.mark(label.at));
        let spots = place(&labels, BOUNDS, Some(obstacles));
        let spots: Vec<Spot> = spots.into_iter().flatten().collect();
        assert_eq!(spots.len(), labels.len());
        assert!(spots.iter().any(|spot| spot.leader.is_some()));
        for spot in &spots {
            for other in spots.iter().filter(|other| *other != spot) {
                let crossed = |(from, to)| beads(from, to).any(|bead| overlap(&bead, &other.frame));
                assert!(!spot.leader.is_some_and(crossed), "{spot:?} {other:?}");
            }
        }
    }

    #[test]
    fn without_obstacles_four_places_are_tried() {
        let same = vec![label((400, 150)); 6];
        let spots = place(&same, BOUNDS, None);
        assert_eq!(spots.iter().filter(|spot| spot.is_some()).count(), 4);
        assert_eq!(spots[0], Some(Spot { frame: [407, 144, 477, 156], leader: None }));
    }

    #[test]
    fn a_line_is_covered_only_where_there_is_no_other_place() {
        let mut level = Obstacles::default();
        level.line([(0, 150), (800, 150)].into_iter());
        let spots = place(&[label((400, 150))], BOUNDS, Some(level.clone()));
        assert_eq!(spots[0].as_ref().map(|spot| spot.frame), Some([365, 132, 435, 144]));
        let narrow = [0, 144, 800, 156];
        assert_eq!(
            place(&[label((400, 150))], narrow, Some(level))[0].as_ref().map(|s| s.frame[0]),
            Some(407)
        );
        assert_eq!(place(&[label((400, 150))], [0, 0, 9, 9], None), [None]);
    }
}
