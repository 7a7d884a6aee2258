//! Prices and estimates computed by several threads ahead of a pass, and prices for the levels of a
//! merge tree.
//!
//! A pass visits the points one after the other and prices the points that it may remove. Most of
//! its time is spent on these prices. A price depends only on the triangles of the point, and is
//! valid unless a neighbour was removed earlier in the pass. Prices can therefore be computed
//! before the pass, for any points in any order. The pass produces the same collapses with and
//! without them. The effect of a collapse on the topology may depend on changes elsewhere in the
//! pass. It is determined when the pass reaches the point; if the best collapse is not allowed
//! then, the point is priced again.
//!
//! ```text
//!   ·── 4 ──·── 7 ──·── 9 ──·      points 4, 7 and 9 may be removed
//! ```
//! In the first round, only 4 is priced. If it will be removed, 7 will be skipped, and the next
//! round prices 9. Otherwise the next round prices 7, and the one after it 9.
//!
//! Pricing a point that is skipped would be wasted work. Prices are therefore computed in rounds.
//! Each round prices the points that have no earlier neighbour that is undecided or will be
//! removed.
//!
//! For a level of a merge tree, all points with a changed neighbourhood are priced before the first
//! one is taken. Each price includes the outcome of the collapse at that time, so each thread has
//! its own marks ([`Pricers`]).
//!
//! # References
//! Blelloch, Fineman, Shun: *Greedy Sequential Maximal Independent Set and Matching are Parallel on
//! Average*, 2012: rounds over the points without an undecided earlier neighbour give the
//! sequential result.

use crate::simplify::price::best_collapse::{BestCollapse, PricedCollapse};
use crate::simplify::price::priced_surface::PricedSurface;
use crate::simplify::price::search::PriceSearch;
use crate::simplify::surface::outcome::{CollapseOutcome, Outcomes};

/// Prices are computed ahead of a pass while at least this many points are undecided.
const MIN_POINTS: usize = 1024;
/// The number of points that a thread processes at a time.
#[cfg(feature = "rayon")]
const CHUNK: usize = 128;
/// The maximum number of rounds: the last ones decide few points.
const ROUNDS: usize = 8;
/// The maximum number of threads with outcomes of collapses, which take 4 bytes per point for each
/// thread.
const MAX_PRICERS: usize = 8;
/// The number of points priced at a time, to limit the memory of their prices.
const BLOCK: usize = 1 << 16;

/// What is known about a point before the pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Fate {
    /// Its cost exceeds the limit of the pass.
    #[default]
    Outside,
    Undecided,
    /// It will be removed, unless the topology prevents it.
    Removed,
    /// It is kept: its price exceeds the limit, or a neighbour is removed first.
    Stays,
}

/// The result of a round for an undecided point.
#[derive(Debug, Clone, Copy)]
enum Finding {
    Undecided,
    /// Its last price is still valid.
    Known,
    Priced(Option<PricedCollapse>),
    /// A neighbour is removed first.
    PassedOver,
}

/// The best collapse of a point, if it has one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FoundPrice {
    point: u32,
    pub(crate) best: Option<PricedCollapse>,
}

/// Prices of points, computed ahead of a pass.
#[derive(Debug, Default)]
pub(crate) struct PricesAhead {
    /// The fate of each point; `Outside` between passes.
    fates: Vec<Fate>,
    /// The prices, by ascending point.
    found: Vec<FoundPrice>,
    /// Prices before this index belong to points that the pass has visited.
    next: usize,
}

impl PricesAhead {
    /// Computes prices of ascending points for a pass with a limit. Does nothing if there is one
    /// thread or few points.
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

    /// Prices the points without an undecided earlier neighbour. Afterwards `undecided` has only
    /// the points that are still undecided.
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

    /// Returns the price of a point, if it was computed. Call it with ascending points.
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

/// Returns the smallest estimate of each removable point.
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

/// The state of a thread that prices points with the outcomes of their collapses.
#[derive(Debug)]
struct Pricer {
    search: PriceSearch,
    outcomes: Outcomes,
}

/// Several threads that price points of a surface that does not change meanwhile.
#[derive(Debug)]
pub(crate) struct Pricers(Vec<Pricer>);

impl Pricers {
    /// Creates one pricer per thread of the current pool, at least one and at most eight.
    pub(crate) fn new(point_count: usize) -> Self {
        let pricer = || Pricer { search: PriceSearch::default(), outcomes: Outcomes::new(point_count) };
        Self((0..thread_count().clamp(1, MAX_PRICERS)).map(|_| pricer()).collect())
    }

    /// Finds the best collapses of points, and reports them in the order of the points.
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

    /// Returns the results of the chunks of a block in order, one chunk per thread.
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

    /// Returns a grid with bumps and a hole. Its texture coordinates have a seam at every fortieth
    /// column, and three of its triangles share an edge.
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

    /// Prices computed ahead equal those of a search, and include most of those that the pass
    /// needs.
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
