//! Prices and estimates that several threads find ahead of a pass, and prices for the levels of a merge tree.
//!
//! A pass visits the points one after the other, and prices those that it may remove. Most of its time goes into these prices, each of which
//! depends on the triangles of the point alone, and holds unless a neighbour was removed before in the pass. So prices can be found before
//! the pass begins, for any points and in any order: the pass gives the same collapses with and without them. What a collapse does to the
//! topology may depend on what happens elsewhere in the pass; that is found when it comes to the point, and if the best collapse is not
//! allowed then, the point is priced again.
//!
//! ```text
//!   ·── 4 ──·── 7 ──·── 9 ──·      Points 4, 7 and 9 may be removed. In the first round only 4 is priced. If it will be removed, 7 will be
//!                                  passed over, and in the next round 9 is priced; otherwise 7 is, and then 9.
//! ```
//! The price of a point that is passed over would be wasted work. So prices are found in rounds: in each those of the points for which no
//! earlier neighbour is undecided, or will be removed.
//!
//! The levels of a merge tree price all points around which something changed before they take one. Each price is found with the outcomes of the collapses
//! then, so that each thread has marks of its own ([`Pricers`]).
//!
//! # References
//! Blelloch, Fineman, Shun: *Greedy Sequential Maximal Independent Set and Matching are Parallel on Average*, 2012: rounds over the
//! points without an undecided earlier neighbour give what one after the other gives.

use crate::simplify::price::best_collapse::{BestCollapse, PricedCollapse};
use crate::simplify::price::priced_surface::PricedSurface;
use crate::simplify::price::search::PriceSearch;
use crate::simplify::surface::outcome::{CollapseOutcome, Outcomes};

/// Prices are found ahead of a pass while at least so many points are undecided.
const MIN_POINTS: usize = 1024;
/// Points that a thread takes at a time.
#[cfg(feature = "rayon")]
const CHUNK: usize = 128;
/// Rounds at most: the last ones decide few points.
const ROUNDS: usize = 8;
/// Threads at most that know the outcomes of collapses, which takes 4 bytes per point for each.
const MAX_PRICERS: usize = 8;
/// Points that are priced at a time, so that their prices take little memory.
const BLOCK: usize = 1 << 16;

/// What is known of a point before the pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Fate {
    /// It costs too much for the pass.
    #[default]
    Outside,
    Undecided,
    /// It will be removed, unless the topology forbids it then.
    Removed,
    /// It stays: its price is above the limit, or a neighbour is removed before.
    Stays,
}

/// What a round finds for an undecided point.
#[derive(Debug, Clone, Copy)]
enum Finding {
    Undecided,
    /// Its price, with which it waited already.
    Known,
    Priced(Option<PricedCollapse>),
    /// A neighbour is removed before.
    PassedOver,
}

/// The best collapse of a point, if it has one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FoundPrice {
    point: u32,
    pub(crate) best: Option<PricedCollapse>,
}

/// Prices of points, found ahead of a pass.
#[derive(Debug, Default)]
pub(crate) struct PricesAhead {
    /// For each point; all are `Outside` between passes.
    fates: Vec<Fate>,
    /// The prices by ascending point.
    found: Vec<FoundPrice>,
    /// The prices before this one are those of points that the pass has visited.
    next: usize,
}

impl PricesAhead {
    /// Finds prices of points, which ascend, for a pass up to a limit; none if there is only one thread, or few points.
    pub(crate) fn find(
        &mut self,
        surface: &PricedSurface,
        best_collapses: &[BestCollapse],
        points: &[u32],
        limit: f32,
    ) {
        self.found.clear();
        self.next = 0;
        // A permissive collapse depends on the triangles of both points.
        if thread_count() == 1 || points.len() < MIN_POINTS || surface.is_permissive {
            return;
        }
        let below: Vec<u32> =
            points.iter().copied().filter(|&point| best_collapses[point as usize].cost <= limit).collect();
        self.fates.resize(best_collapses.len(), Fate::Outside);
        below.iter().for_each(|&point| self.fates[point as usize] = Fate::Undecided);
        let mut undecided = below.clone();
        for _ in 0..ROUNDS {
            if undecided.len() < MIN_POINTS {
                break;
            }
            self.round(surface, best_collapses, &mut undecided, limit);
        }
        below.iter().for_each(|&point| self.fates[point as usize] = Fate::Outside);
        self.found.sort_unstable_by_key(|found| found.point);
    }

    /// Prices the points without an undecided earlier neighbour, and leaves those that are undecided after it.
    fn round(
        &mut self,
        surface: &PricedSurface,
        best_collapses: &[BestCollapse],
        undecided: &mut Vec<u32>,
        limit: f32,
    ) {
        let fates = &self.fates;
        let finding = |search: &mut PriceSearch, point: u32| {
            let edges = surface.topology.opposite(point);
            let earlier = || edges.iter().flatten().filter(|&&p| p < point).map(|&p| fates[p as usize]);
            if earlier().any(|fate| fate == Fate::Removed) {
                Finding::PassedOver
            } else if earlier().any(|fate| fate == Fate::Undecided) {
                Finding::Undecided
            } else if best_collapses[point as usize].target.get().is_some() {
                Finding::Known
            } else {
                Finding::Priced(search.best(surface, point, |_| CollapseOutcome::Keeps))
            }
        };
        let findings = in_chunks(undecided, finding);
        let mut findings = findings.into_iter();
        undecided.retain(|&point| {
            let fate = &mut self.fates[point as usize];
            *fate = match findings.next() {
                None | Some(Finding::Undecided) => return true,
                Some(Finding::Known) => Fate::Removed,
                Some(Finding::PassedOver) => Fate::Stays,
                Some(Finding::Priced(best)) => {
                    self.found.push(FoundPrice { point, best });
                    match best {
                        Some(collapse) if collapse.cost <= limit => Fate::Removed,
                        _ => Fate::Stays,
                    }
                }
            };
            false
        });
    }

    /// Returns the price of a point, if it was found. Each point comes after those asked for before.
    pub(crate) fn of(&mut self, point: u32) -> Option<FoundPrice> {
        while let Some(&found) = self.found.get(self.next).filter(|found| found.point <= point) {
            self.next += 1;
            if found.point == point {
                return Some(found);
            }
        }
        None
    }
}

/// Returns the least estimate of each point that may be removed.
pub(crate) fn least_estimates(
    surface: &PricedSurface,
    is_removable: impl Fn(u32) -> bool + Sync,
) -> Vec<Option<f64>> {
    let points: Vec<u32> = (0..surface.topology.point_count() as u32).collect();
    in_chunks(
        &points,
        |search, point| {
            if is_removable(point) { search.least_estimate(surface, point) } else { None }
        },
    )
}

/// Returns the results for all points, in their order.
fn in_chunks<T: Send>(points: &[u32], find: impl Fn(&mut PriceSearch, u32) -> T + Sync) -> Vec<T> {
    let of_chunk = |search: &mut PriceSearch, chunk: &[u32]| -> Vec<T> {
        chunk.iter().map(|&point| find(search, point)).collect()
    };
    #[cfg(feature = "rayon")]
    if points.len() >= MIN_POINTS && thread_count() > 1 {
        use rayon::prelude::*;
        let chunks = points.par_chunks(CHUNK).map_init(PriceSearch::default, of_chunk);
        return chunks.collect::<Vec<_>>().into_iter().flatten().collect();
    }
    of_chunk(&mut PriceSearch::default(), points)
}

/// What a thread knows while it prices points with the outcomes of their collapses.
#[derive(Debug)]
struct Pricer {
    search: PriceSearch,
    outcomes: Outcomes,
}

/// Several threads that price points of a surface that stays as it is meanwhile.
#[derive(Debug)]
pub(crate) struct Pricers(Vec<Pricer>);

impl Pricers {
    /// One for each thread of the current pool, up to eight; at least one.
    pub(crate) fn new(point_count: usize) -> Self {
        let pricer = || Pricer { search: PriceSearch::default(), outcomes: Outcomes::new(point_count) };
        Self((0..thread_count().clamp(1, MAX_PRICERS)).map(|_| pricer()).collect())
    }

    /// Finds the best collapses of points, and tells them in the order of the points.
    pub(crate) fn price(
        &mut self,
        points: &[u32],
        best: impl Fn(&mut PriceSearch, &mut Outcomes, u32) -> Option<PricedCollapse> + Sync,
        mut tell: impl FnMut(u32, Option<PricedCollapse>),
    ) {
        let of_chunk = |pricer: &mut Pricer, chunk: &[u32]| -> Vec<Option<PricedCollapse>> {
            chunk.iter().map(|&point| best(&mut pricer.search, &mut pricer.outcomes, point)).collect()
        };
        for block in points.chunks(BLOCK) {
            let found = self.in_chunks(block, of_chunk);
            block.iter().zip(found.into_iter().flatten()).for_each(|(&point, best)| tell(point, best));
        }
    }

    /// Returns the results of the chunks of a block, one for each thread, in their order.
    fn in_chunks<T: Send>(
        &mut self,
        block: &[u32],
        of_chunk: impl Fn(&mut Pricer, &[u32]) -> T + Sync,
    ) -> Vec<T> {
        #[cfg(feature = "rayon")]
        if block.len() >= MIN_POINTS && self.0.len() > 1 {
            use rayon::prelude::*;
            let chunks = block.par_chunks(block.len().div_ceil(self.0.len()));
            return self
                .0
                .par_iter_mut()
                .zip(chunks)
                .map(|(pricer, chunk)| of_chunk(pricer, chunk))
                .collect();
        }
        self.0.first_mut().map(|pricer| of_chunk(pricer, block)).into_iter().collect()
    }
}

/// Returns the number of threads.
fn thread_count() -> usize {
    #[cfg(feature = "rayon")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "rayon"))]
    1
}

#[cfg(test)]
#[cfg(feature = "rayon")]
mod tests {
    use super::*;
    use crate::mesh::{Attribute, AttributeData, Faces, Mesh};
    use crate::simplify::surface::topology::Topology;
    use crate::simplify::tests::grid;
    use crate::simplify::{MergeOrder, Price, SimplifyOptions, merge_tree, simplify_triangles};

    const THREADS: [usize; 3] = [1, 2, 5];

    fn on_threads<T: Send>(count: usize, task: impl FnOnce() -> T + Send) -> T {
        rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap().install(task)
    }

    /// A grid with bumps and a hole, whose texture coordinates have a seam at every fortieth column; three of its triangles meet at one edge.
    fn mesh() -> Mesh {
        let (mut positions, mut triangles) = grid(140, 140, [true, false]);
        triangles.drain(6000..6060);
        let columns = 140;
        let mut copies = std::collections::HashMap::new();
        for triangle in triangles.as_chunks_mut::<3>().0 {
            let is_right = triangle.iter().any(|v| v % columns % 40 == 1);
            for v in triangle.iter_mut().filter(|v| is_right && **v % columns % 40 == 0) {
                let position = positions[*v as usize];
                *v = *copies.entry(*v).or_insert_with(|| {
                    positions.push(position);
                    positions.len() as u32 - 1
                });
            }
        }
        let tip = positions.len() as u32;
        positions.push([9.0, 9.0, 70.0]);
        triangles.extend([9000, 9001, tip]);
        let uv = (0..positions.len()).flat_map(|v| [v as f32 / 1e3, (v % 140) as f32 / 140.0]).collect();
        let uv = Attribute {
            name: "TEXCOORD_0".into(),
            components: 2,
            normalized: false,
            data: AttributeData::F32(uv),
        };
        let faces = Faces::from_triangles(triangles).unwrap();
        Mesh::new(positions, faces).unwrap().with_attribute(uv).unwrap()
    }

    #[test]
    fn any_number_of_threads_gives_the_same_collapses() {
        let mesh = mesh();
        let triangles = mesh.faces().as_triangles().unwrap();
        let goal = SimplifyOptions::default().with_triangles(400);
        let vanishing = vec![0.5; mesh.vertex_count()];
        for options in [
            goal.clone(),
            goal.clone().with_error(0.3),
            goal.clone().with_price(Price::Planes),
            goal.clone().with_vanishing(vanishing),
            goal.with_permissive(true),
        ] {
            let [one, two, five] = THREADS.map(|threads| {
                on_threads(threads, || simplify_triangles(&mesh, triangles.to_vec(), &options).unwrap())
            });
            assert!(one.sequence.len() > 4000 && one == two && one == five, "{options:?}");
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_merge_tree() {
        let mesh = mesh();
        let triangles = mesh.faces().as_triangles().unwrap();
        let options = SimplifyOptions::default();
        for order in [MergeOrder::Quadric, MergeOrder::ShortestEdge] {
            let [one, two, five] = THREADS.map(|threads| {
                on_threads(threads, || merge_tree(&mesh, triangles.to_vec(), order, &options).unwrap())
            });
            assert!(one.sequence.len() > 4000 && one == two && one == five, "{order}");
        }
    }

    /// What is found ahead is what a search finds, and most of what the pass needs.
    #[test]
    fn prices_found_ahead_are_those_of_a_search() {
        let mesh = mesh();
        let triangles = mesh.faces().as_triangles().unwrap();
        let topology = Topology::new(mesh.positions(), |v| v.to_le_bytes().to_vec(), triangles, false, 0.0);
        let options = SimplifyOptions::default();
        let surface = PricedSurface::new(topology, mesh.positions(), |_| None, &options);
        let points: Vec<u32> = (0..surface.topology.point_count() as u32).collect();
        let [one, more] = [1, 3].map(|threads| on_threads(threads, || least_estimates(&surface, |p| p != 5)));
        assert!(one == more && one[5].is_none() && one.iter().flatten().count() > 15_000);
        let estimates = one.iter().map(|estimate| estimate.map_or(f32::INFINITY, |x| x as f32));
        let best_collapses: Vec<BestCollapse> =
            estimates.map(|cost| BestCollapse { cost, ..BestCollapse::NONE }).collect();
        let mut costs: Vec<f32> = best_collapses.iter().map(|known| known.cost).collect();
        costs.sort_unstable_by(f32::total_cmp);
        let limit = costs[costs.len() / 3];

        let mut ahead = PricesAhead::default();
        on_threads(1, || ahead.find(&surface, &best_collapses, &points, limit));
        assert!(ahead.found.is_empty());
        on_threads(3, || ahead.find(&surface, &best_collapses, &points, limit));
        assert!(ahead.fates.iter().all(|&fate| fate == Fate::Outside));
        let (mut search, mut removed, mut found) = (PriceSearch::default(), vec![false; points.len()], 0);
        let mut missing = 0;
        for &point in points.iter().filter(|&&point| best_collapses[point as usize].cost <= limit) {
            if surface.topology.opposite(point).iter().flatten().any(|&p| p < point && removed[p as usize]) {
                continue;
            }
            let best = search.best(&surface, point, |_| CollapseOutcome::Keeps);
            removed[point as usize] = best.is_some_and(|best| best.cost <= limit);
            match ahead.of(point) {
                None => missing += 1,
                Some(FoundPrice { best: other, .. }) => {
                    found += 1;
                    let parts = |best: Option<PricedCollapse>| {
                        best.map(|best| (best.to, best.cost.to_bits(), best.error.to_bits()))
                    };
                    assert_eq!(parts(best), parts(other), "{point}");
                }
            }
        }
        assert_eq!(found, ahead.found.len(), "no price is unused");
        assert!(found > 1000 && missing < MIN_POINTS, "{found} {missing}");
    }
}
