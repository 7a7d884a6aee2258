//! The colours of strips: neighbours differ, and all palette colours are used about equally.

use std::collections::HashMap;

use tristrip::Strips;
use tristrip::strip_triangles;

/// The colour of a mesh without strips, in sRGB.
pub(super) const PLAIN: [u8; 3] = [198, 203, 211];

/// sRGB hues, ordered so that consecutive ones differ strongly. All are light enough to show the
/// shading.
const PALETTE: [[u8; 3]; 14] = [
    [74, 144, 217],
    [243, 156, 72],
    [98, 187, 112],
    [222, 93, 105],
    [164, 126, 210],
    [236, 209, 87],
    [79, 193, 196],
    [236, 140, 188],
    [158, 190, 76],
    [181, 134, 104],
    [129, 159, 240],
    [245, 181, 150],
    [61, 153, 138],
    [200, 96, 178],
];

/// Returns the sRGB colour of each strip.
///
/// Strips choose in descending order of their triangle counts. A strip takes the least used colour
/// that no neighbour has. If its neighbours have all colours, it takes the one with the fewest
/// shared edges.
pub(super) fn of_strips(strips: &Strips) -> Vec<[u8; 3]> {
    let neighbours = neighbours(strips);
    let sizes: Vec<usize> = strips.iter().map(|strip| strip_triangles(strip).count()).collect();
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&strip| std::cmp::Reverse(sizes[strip]));
    let mut chosen: Vec<Option<usize>> = vec![None; sizes.len()];
    let mut used = [0_usize; PALETTE.len()];
    for strip in order {
        let mut around = [0_usize; PALETTE.len()];
        for &(other, edges) in &neighbours[strip] {
            if let Some(colour) = chosen[other as usize] {
                around[colour] += edges;
            }
        }
        let colour = (0..PALETTE.len()).min_by_key(|&colour| (around[colour], used[colour])).unwrap_or(0);
        used[colour] += sizes[strip];
        chosen[strip] = Some(colour);
    }
    chosen.into_iter().map(|colour| PALETTE[colour.unwrap_or(0)]).collect()
}

/// Returns for each strip its neighbours and the number of shared edges.
fn neighbours(strips: &Strips) -> Vec<Vec<(u32, usize)>> {
    let mut first: HashMap<[u32; 2], u32> = HashMap::new();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for (number, strip) in (0..).zip(strips.iter()) {
        for [a, b, c] in strip_triangles(strip) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let edge = [from.min(to), from.max(to)];
                let other = *first.entry(edge).or_insert(number);
                if other != number {
                    pairs.extend([[other, number], [number, other]]);
                }
            }
        }
    }
    pairs.sort_unstable();
    let mut neighbours = vec![Vec::new(); strips.len()];
    for run in pairs.chunk_by(|a, b| a == b) {
        neighbours[run[0][0] as usize].push((run[0][1], run.len()));
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_differ_in_a_fan_of_strips() {
        let mut strips = Strips::default();
        (0..40).for_each(|i| strips.push(&[99, i, i + 1]));
        let colours = of_strips(&strips);
        assert!(colours.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(PALETTE.iter().all(|colour| colours.contains(colour)), "all colours are used");
    }

    #[test]
    fn a_strip_with_more_neighbours_than_colours_gets_one() {
        let ring: Vec<u32> = (0..60).collect();
        let mut strips = Strips::default();
        strips.push(&ring);
        ring.windows(3).for_each(|w| strips.push(&[w[0], w[2], 1000 + w[0]]));
        let colours = of_strips(&strips);
        assert_eq!(colours.len(), strips.len());
        assert!(colours[1..].iter().all(|&colour| colour != colours[0]));
    }
}
