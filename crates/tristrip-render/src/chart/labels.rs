//! Label placement: next to the points, or farther away with a leader line if every label must be
//! shown.
//!
//! ```text
//!      above                   · · · ·
//!  left  ●  right   and then   ·  ●  ·   candidates on squares of growing size
//!      below                   · · · ·
//! ```
//! # Algorithm
//! Labels are placed greedily, in their order. Each label takes its first free candidate position.
//! Positions are integer pixels, so the result does not depend on rounding.

/// Left, top, right and bottom in pixels.
pub(super) type PixelRect = [i32; 4];

/// The distance from a point to a label next to it, in pixels.
const BESIDE: i32 = 7;
/// Half the height of a label.
const HALF_HEIGHT: i32 = 6;
/// The distance between two rings of candidates.
const RING_DISTANCE: i32 = 9;
/// The number of rings around a point.
const RINGS: i32 = 20;
/// Half the side of the square that a symbol covers.
const SYMBOL: i32 = 5;
/// The distance between two candidates of a ring.
const STEP: i32 = 6;

/// A label to place.
#[derive(Debug, Clone)]
pub(super) struct PointLabel {
    /// The labelled point.
    pub(super) at: (i32, i32),
    pub(super) text: String,
    pub(super) width: i32,
}

/// The position of a label.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LabelPosition {
    pub(super) rect: PixelRect,
    /// The leader line from the point, if the label is not next to it.
    pub(super) leader: Option<((i32, i32), (i32, i32))>,
}

/// The symbols and lines that labels must avoid.
#[derive(Debug, Clone, Default)]
pub(super) struct Obstacles {
    symbols: Vec<PixelRect>,
    lines: Vec<PixelRect>,
}

impl Obstacles {
    /// Adds the symbol of a point.
    pub(super) fn add_symbol(&mut self, at: (i32, i32)) {
        self.symbols.push([at.0 - SYMBOL, at.1 - SYMBOL, at.0 + SYMBOL, at.1 + SYMBOL]);
    }

    /// Adds a line through points.
    pub(super) fn add_line(&mut self, points: impl Iterator<Item = (i32, i32)>) {
        let mut last = None;
        for point in points {
            let from = last.replace(point).unwrap_or(point);
            self.lines.extend(line_rects(from, point));
        }
    }
}

/// Returns a position for each label, or `None` if there is no free space. With obstacles, all
/// candidates around a point are tried; without, only the four next to it.
pub(super) fn place_labels(
    labels: &[PointLabel],
    bounds: PixelRect,
    obstacles: Option<Obstacles>,
) -> Vec<Option<LabelPosition>> {
    let with_rings = obstacles.is_some();
    let mut occupied = Occupied { bounds, obstacles: obstacles.unwrap_or_default(), ..Occupied::default() };
    let mut positions = Vec::with_capacity(labels.len());
    for label in labels {
        let position = Clearance::ALL.into_iter().find_map(|clearance| {
            candidates(label, with_rings).find(|position| occupied.is_free(position, label.at, clearance))
        });
        if let Some(position) = &position {
            occupied.labels.push(position.rect);
            occupied.leaders.extend(position.leader.into_iter().flat_map(|(from, to)| line_rects(from, to)));
        }
        positions.push(position);
    }
    positions
}

/// What labels and leader lines must avoid. Weaker levels have more free candidates. No label ever
/// overlaps a label or a symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Clearance {
    /// Nothing else. Needed only if labels surround a point.
    Least,
    /// No label overlaps a leader line, and no leader line crosses a label.
    Labels,
    /// In addition, no leader line crosses another one, or a symbol other than its own.
    Symbols,
    /// In addition, no label overlaps a line of a series.
    Lines,
}

impl Clearance {
    /// All levels, from strictest to weakest.
    const ALL: [Self; 4] = [Self::Lines, Self::Symbols, Self::Labels, Self::Least];
}

/// The occupied space.
#[derive(Debug, Default)]
struct Occupied {
    bounds: PixelRect,
    labels: Vec<PixelRect>,
    leaders: Vec<PixelRect>,
    obstacles: Obstacles,
}

impl Occupied {
    /// Checks whether a label of the point `at` can be placed at a position with the given
    /// clearance.
    fn is_free(&self, position: &LabelPosition, at: (i32, i32), clearance: Clearance) -> bool {
        let Obstacles { symbols, lines } = &self.obstacles;
        let free = |of: &[PixelRect], rect: &PixelRect| of.iter().all(|other| !overlap(rect, other));
        let rect = &position.rect;
        let own = |part: &PixelRect| (part[0] - at.0).abs() <= SYMBOL && (part[1] - at.1).abs() <= SYMBOL;
        let clear = |part: PixelRect| {
            let crosses = !free(symbols, &part) || !free(&self.leaders, &part);
            free(&self.labels, &part) && (clearance < Clearance::Symbols || own(&part) || !crosses)
        };
        inside(rect, &self.bounds)
            && free(&self.labels, rect)
            && free(symbols, rect)
            && (clearance < Clearance::Labels || free(&self.leaders, rect))
            && (clearance < Clearance::Lines || free(lines, rect))
            && (clearance < Clearance::Labels
                || position.leader.is_none_or(|(from, to)| line_rects(from, to).all(clear)))
    }
}

/// Iterates over the candidate positions of a label, from near to far.
fn candidates(label: &PointLabel, with_rings: bool) -> impl Iterator<Item = LabelPosition> + '_ {
    let (x, y) = label.at;
    let rect =
        |(left, middle): (i32, i32)| [left, middle - HALF_HEIGHT, left + label.width, middle + HALF_HEIGHT];
    let half = label.width / 2;
    let near = [(x + BESIDE, y), (x - half, y - 12), (x - BESIDE - label.width, y), (x - half, y + 12)];
    let near = near.map(|at| LabelPosition { rect: rect(at), leader: None });
    let rings = 1..=if with_rings { RINGS } else { 0 };
    let far = rings.flat_map(|ring| square(BESIDE + RING_DISTANCE * ring)).map(move |(dx, dy)| {
        let left = if dx >= 0 { x + dx } else { x + dx - label.width };
        let rect = rect((left, y + dy));
        let end = (x.clamp(rect[0] - 1, rect[2]), y.clamp(rect[1] + 1, rect[3] - 1));
        LabelPosition { rect, leader: Some((label.at, end)) }
    });
    near.into_iter().chain(far)
}

/// Iterates over points on the sides of a square around the origin, from the middle of each side
/// outwards.
fn square(half: i32) -> impl Iterator<Item = (i32, i32)> {
    let along = (0..=half / STEP).flat_map(|i| [i * STEP, -i * STEP]);
    along.flat_map(move |offset| [(half, offset), (-half, offset), (offset, -half), (offset, half)])
}

/// Iterates over small rectangles that cover a line.
fn line_rects(from: (i32, i32), to: (i32, i32)) -> impl Iterator<Item = PixelRect> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let count = (dx.abs().max(dy.abs()) / 3).max(1);
    (0..=count).map(move |i| {
        let (x, y) = (from.0 + dx * i / count, from.1 + dy * i / count);
        [x - 1, y - 1, x + 1, y + 1]
    })
}

fn inside(rect: &PixelRect, bounds: &PixelRect) -> bool {
    rect[0] >= bounds[0] && rect[1] >= bounds[1] && rect[2] <= bounds[2] && rect[3] <= bounds[3]
}

fn overlap(a: &PixelRect, b: &PixelRect) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: PixelRect = [0, 0, 800, 300];

    fn label(at: (i32, i32)) -> PointLabel {
        PointLabel { at, text: "a label".into(), width: 70 }
    }

    #[test]
    fn labels_cover_neither_labels_nor_symbols() {
        let labels: Vec<PointLabel> =
            (0..16).map(|i| label((300 + 11 * (i % 4), 150 + 7 * (i / 4)))).collect();
        let mut obstacles = Obstacles::default();
        labels.iter().for_each(|label| obstacles.add_symbol(label.at));
        let symbols = obstacles.symbols.clone();
        let positions = place_labels(&labels, BOUNDS, Some(obstacles));
        let positions: Vec<LabelPosition> = positions.into_iter().flatten().collect();
        assert!(positions.len() == 16, "{} of 16", positions.len());
        for (index, position) in positions.iter().enumerate() {
            assert!(inside(&position.rect, &BOUNDS));
            assert!(symbols.iter().all(|symbol| !overlap(symbol, &position.rect)));
            for other in positions.iter().take(index) {
                assert!(!overlap(&position.rect, &other.rect));
            }
        }
    }

    #[test]
    fn leader_lines_cross_no_labels_if_there_is_space() {
        let labels: Vec<PointLabel> = (0..5).map(|i| label((300, 100 + 4 * i))).collect();
        let mut obstacles = Obstacles::default();
        labels.iter().for_each(|label| obstacles.add_symbol(label.at));
        let positions = place_labels(&labels, BOUNDS, Some(obstacles));
        let positions: Vec<LabelPosition> = positions.into_iter().flatten().collect();
        assert_eq!(positions.len(), labels.len());
        assert!(positions.iter().any(|position| position.leader.is_some()));
        for position in &positions {
            for other in positions.iter().filter(|other| *other != position) {
                let crossed = |(from, to)| line_rects(from, to).any(|part| overlap(&part, &other.rect));
                assert!(!position.leader.is_some_and(crossed), "{position:?} {other:?}");
            }
        }
    }

    #[test]
    fn without_obstacles_only_four_candidates_are_tried() {
        let same = vec![label((400, 150)); 6];
        let positions = place_labels(&same, BOUNDS, None);
        assert_eq!(positions.iter().filter(|position| position.is_some()).count(), 4);
        assert_eq!(positions[0], Some(LabelPosition { rect: [407, 144, 477, 156], leader: None }));
    }

    #[test]
    fn a_line_is_covered_only_if_no_other_candidate_is_free() {
        let mut level = Obstacles::default();
        level.add_line([(0, 150), (800, 150)].into_iter());
        let positions = place_labels(&[label((400, 150))], BOUNDS, Some(level.clone()));
        assert_eq!(positions[0].as_ref().map(|position| position.rect), Some([365, 132, 435, 144]));
        let narrow = [0, 144, 800, 156];
        assert_eq!(
            place_labels(&[label((400, 150))], narrow, Some(level))[0].as_ref().map(|p| p.rect[0]),
            Some(407)
        );
        assert_eq!(place_labels(&[label((400, 150))], [0, 0, 9, 9], None), [None]);
    }
}
