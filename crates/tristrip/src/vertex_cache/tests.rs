use super::distances::Distances;
use super::fifo::Fifo;
use super::lru::Lru;
use super::*;
use crate::random::Random;
use crate::strip::Strips;
use proptest::prelude::*;
use std::collections::VecDeque;

/// Simulates a cache as a queue of vertices with linear search. Returns the hits.
fn hits_of_a_queue(indices: &[u32], cache: VertexCache) -> Vec<bool> {
    let mut queue = VecDeque::new();
    let send = |v: &u32| {
        let found = queue.iter().position(|inside| inside == v);
        if cache.replacement == Replacement::Lru
            && let Some(at) = found
        {
            queue.remove(at);
            queue.push_back(*v);
        }
        if found.is_none() {
            queue.push_back(*v);
        }
        if queue.len() > cache.entries as usize {
            queue.pop_front();
        }
        found.is_some()
    };
    indices.iter().map(send).collect()
}

fn misses_of_a_queue(strips: &Strips, cache: VertexCache, flush: FlushPolicy) -> usize {
    let runs: Vec<&[u32]> = match flush {
        FlushPolicy::Keep => vec![strips.vertices()],
        FlushPolicy::Flush => strips.iter().collect(),
    };
    runs.iter().flat_map(|run| hits_of_a_queue(run, cache)).filter(|hit| !hit).count()
}

fn any_cache() -> impl Strategy<Value = VertexCache> {
    (any::<bool>(), 0..50_u32)
        .prop_map(|(fifo, entries)| if fifo { VertexCache::fifo(entries) } else { VertexCache::lru(entries) })
}

fn any_strips() -> impl Strategy<Value = Strips> {
    prop::collection::vec(prop::collection::vec(0..40_u32, 0..30), 0..20).prop_map(|all| {
        let mut strips = Strips::default();
        all.iter().for_each(|strip| strips.push(strip));
        strips
    })
}

/// Strips with many swaps in which no vertex except the first is repeated immediately.
fn any_turning_strips() -> impl Strategy<Value = Strips> {
    prop::collection::vec((any::<bool>(), prop::collection::vec(0..9_u32, 2..30)), 0..20).prop_map(|all| {
        let mut strips = Strips::default();
        for (repeat, mut strip) in all {
            strip.dedup();
            if repeat && strip.len() > 1 {
                strip.insert(0, strip[0]);
            }
            if strip.len() > 1 {
                strips.push(&strip);
            }
        }
        strips
    })
}

/// Simulates the machine with its cache as a queue, oldest first, and the vertices at hand as a
/// list.
fn cost_by_a_queue(strips: &Strips, cache: VertexCache, flush: FlushPolicy) -> GeneralizedCost {
    let mut cost = GeneralizedCost { triangles: strips.triangles().count(), ..GeneralizedCost::default() };
    let mut queue: Vec<u32> = Vec::new();
    for strip in strips.iter() {
        if flush == FlushPolicy::Flush {
            queue.clear();
        }
        let mut hand: Vec<u32> = Vec::new();
        for &v in strip {
            let inside = queue.iter().position(|&u| u == v);
            if hand.last() == Some(&v) {
                continue;
            }
            if hand.contains(&v) {
                cost.swaps += 1;
                let other = queue.iter().position(|u| hand.last() == Some(u));
                match (cache.replacement, inside, other) {
                    (Replacement::Fifo, Some(a), Some(b)) => queue.swap(a, b),
                    (Replacement::Lru, Some(a), _) => queue[a..].rotate_left(1),
                    _ => {}
                }
                hand.reverse();
                continue;
            }
            match inside {
                None => {
                    cost.transmitted += 1;
                    queue.push(v);
                    if queue.len() > cache.entries as usize {
                        queue.remove(0);
                    }
                }
                Some(a) => {
                    cost.references += 1;
                    cost.reference_bits +=
                        (0..32).find(|bits| 1_u64 << bits >= u64::from(cache.entries)).unwrap();
                    if cache.replacement == Replacement::Lru {
                        queue[a..].rotate_left(1);
                    }
                }
            }
            hand.push(v);
            if hand.len() > 2 {
                hand.remove(0);
            }
        }
    }
    cost
}

const BOTH: [FlushPolicy; 2] = [FlushPolicy::Keep, FlushPolicy::Flush];

proptest! {
    #[test]
    fn hits_are_those_of_a_queue(
        indices in prop::collection::vec(0..40_u32, 0..300),
        cache in any_cache(),
    ) {
        let mut simulator = VertexCacheSimulator::new(cache, 40).unwrap();
        let hits: Vec<bool> = indices.iter().map(|&v| simulator.send(v).unwrap()).collect();
        prop_assert_eq!(&hits, &hits_of_a_queue(&indices, cache));
        prop_assert_eq!(simulator.misses(), hits.iter().filter(|hit| !*hit).count());
        let mut together = VertexCacheSimulator::new(cache, 40).unwrap();
        together.send_all(&indices).unwrap();
        prop_assert_eq!(together.misses(), simulator.misses());
    }

    #[test]
    fn strips_cost_the_same_as_with_a_queue(strips in any_strips(), cache in any_cache()) {
        for flush in BOTH {
            let used = VertexCacheStatistics::of(&strips, cache, flush);
            prop_assert_eq!(used.misses, misses_of_a_queue(&strips, cache, flush));
            prop_assert_eq!(used.triangles, strips.triangles().count());
            // Sparse vertices are renumbered.
            let mut far = Strips::default();
            strips.iter().for_each(|strip| far.push(&strip.iter().map(|v| 100_000_000 * v).collect::<Vec<_>>()));
            prop_assert_eq!(used, VertexCacheStatistics::of(&far, cache, flush));
        }
    }

    #[test]
    fn a_list_costs_the_same_as_its_indices(
        triangles in prop::collection::vec([0..40_u32, 0..40, 0..40], 0..33),
        cache in any_cache(),
    ) {
        let used = VertexCacheStatistics::of_list(&triangles, cache);
        let hits = hits_of_a_queue(triangles.as_flattened(), cache);
        prop_assert_eq!(used.misses, hits.iter().filter(|hit| !*hit).count());
    }

    #[test]
    fn many_caches_cost_the_same_as_each(
        strips in any_strips(),
        caches in prop::collection::vec(any_cache(), 0..20),
    ) {
        for flush in BOTH {
            let each = VertexCacheStatistics::of_each(&strips, &caches, flush);
            let one_by_one: Vec<_> = caches.iter().map(|&b| VertexCacheStatistics::of(&strips, b, flush)).collect();
            prop_assert_eq!(each, one_by_one);
        }
        let list: Vec<[u32; 3]> = strips.triangles().collect();
        let each = VertexCacheStatistics::of_list_each(&list, &caches);
        let one_by_one: Vec<_> = caches.iter().map(|&b| VertexCacheStatistics::of_list(&list, b)).collect();
        prop_assert_eq!(each, one_by_one);
    }

    #[test]
    fn a_profile_has_the_misses_of_every_size(strips in any_strips(), largest in 0..50_u32) {
        for flush in BOTH {
            let profile = lru_profile(&strips, largest, flush).unwrap();
            let expected: Vec<_> =
                (1..=largest).map(|entries| misses_of_a_queue(&strips, VertexCache::lru(entries), flush)).collect();
            prop_assert_eq!(profile, expected);
        }
    }

    #[test]
    fn a_generalized_mesh_costs_the_same_as_with_a_queue(strips in any_turning_strips(), cache in any_cache()) {
        for flush in BOTH {
            let cost = GeneralizedCost::of(&strips, cache, flush);
            prop_assert_eq!(cost, cost_by_a_queue(&strips, cache, flush));
        }
    }

    #[test]
    fn two_entries_transmit_the_gl_cost(strips in any_turning_strips()) {
        for cache in [VertexCache::fifo(2), VertexCache::lru(2)] {
            let cost = GeneralizedCost::of(&strips, cache, FlushPolicy::Flush);
            let metrics = crate::strip::Metrics::of(&strips);
            prop_assert_eq!((cost.transmitted, cost.references), (metrics.gl_cost, 0));
            prop_assert_eq!(cost.triangles, metrics.triangles);
            prop_assert!(cost.swaps <= metrics.swaps);
        }
        let lru: Vec<_> = (2..12)
            .map(|entries| GeneralizedCost::of(&strips, VertexCache::lru(entries), FlushPolicy::Flush).transmitted)
            .collect();
        prop_assert!(lru.is_sorted_by(|small, large| small >= large), "{:?}", lru);
    }

    #[test]
    fn a_clock_overflow_changes_nothing(
        indices in prop::collection::vec(0..40_u32, 0..300),
        entries in 1..50_u32,
        left in 0..100_i32,
        flush_at in 0..300_usize,
    ) {
        let mut late = Fifo::new([entries, 3], 40).with_late_clocks(left + 50);
        let mut usual = Fifo::new([entries, 3], 40);
        for (i, &v) in indices.iter().enumerate() {
            if i == flush_at {
                late.flush();
                usual.flush();
            }
            late.send_all(&[v]);
            usual.send_all(&[v]);
            prop_assert_eq!(late.misses(), usual.misses(), "index {}", i);
        }
    }
}

#[test]
fn a_long_run_rewrites_the_log_and_rewinds_times() {
    let mut random = Random::new(1);
    let indices: Vec<u32> = (0..60_000).map(|_| random.below(3000) as u32).collect();
    for entries in [1, 7, 100, 2000] {
        let expected = hits_of_a_queue(&indices, VertexCache::lru(entries));
        for mut cache in [Lru::new(entries, 3000), Lru::new(entries, 3000).with_late_times(9000)] {
            let hits: Vec<bool> = indices.iter().map(|&v| cache.send(v)).collect();
            assert_eq!(hits, expected, "{entries} entries");
        }
        let misses = expected.iter().filter(|hit| !*hit).count();
        for largest in [entries, 2500] {
            let usual = Distances::new(largest as usize, 3000);
            let late = Distances::new(largest as usize, 3000).with_late_times(9000);
            for mut distances in [usual, late] {
                distances.send_all(&indices);
                assert_eq!(
                    distances.misses()[entries as usize - 1],
                    misses,
                    "{entries} of {largest} entries"
                );
            }
        }
    }
}

#[test]
fn a_swap_is_a_hit_and_no_triangle() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 1, 3]);
    for cache in [VertexCache::fifo(3), VertexCache::lru(3)] {
        let used = VertexCacheStatistics::of(&strips, cache, FlushPolicy::Keep);
        assert_eq!(used, VertexCacheStatistics { misses: 4, triangles: 2, vertices: 4 });
    }
    assert!(
        VertexCacheStatistics::default().acmr() + VertexCacheStatistics::default().atvr() < f64::MIN_POSITIVE
    );
}

#[test]
fn empty_and_single_vertex_strips() {
    let mut one = Strips::default();
    one.push(&[]);
    one.push(&[5]);
    for cache in [
        VertexCache::fifo(0),
        VertexCache::lru(0),
        VertexCache::fifo(1),
        VertexCache::lru(u32::MAX),
        VertexCache::fifo(u32::MAX),
    ] {
        for flush in BOTH {
            assert_eq!(
                VertexCacheStatistics::of(&Strips::default(), cache, flush),
                VertexCacheStatistics::default()
            );
            assert_eq!(
                VertexCacheStatistics::of(&one, cache, flush),
                VertexCacheStatistics { misses: 1, triangles: 0, vertices: 1 }
            );
        }
        assert_eq!(VertexCacheStatistics::of_list(&[], cache), VertexCacheStatistics::default());
    }
}

#[test]
fn caches_are_parsed_as_they_are_written() {
    for text in ["fifo:1", "lru:65536", "fifo:16"] {
        assert_eq!(text.parse::<VertexCache>().map(|cache| cache.to_string()), Ok(text.to_string()));
    }
    for text in
        ["", "fifo", "fifo:", ":16", "fifo:0", "lru:65537", "lru:+4", "lru: 4", "mru:4", "fifo:4:4", "FIFO:4"]
    {
        let error = text.parse::<VertexCache>().unwrap_err().to_string();
        assert!(error.contains("N from 1 to 65536") && error.contains(text), "{error}");
    }
}

#[test]
fn any_vertex_is_simulated_and_wrong_arguments_are_refused() {
    let mut strips = Strips::default();
    strips.push(&[0, u32::MAX, 7, u32::MAX - 1, 7]);
    for cache in [0, 1, 3, u32::MAX].into_iter().flat_map(|n| [VertexCache::fifo(n), VertexCache::lru(n)]) {
        for flush in BOTH {
            let used = VertexCacheStatistics::of(&strips, cache, flush);
            assert_eq!(
                (used.vertices, used.triangles, used.misses),
                (4, 2, if cache.entries < 2 { 5 } else { 4 })
            );
            assert_eq!(VertexCacheStatistics::of_each(&strips, &[cache; 9], flush), [used; 9]);
            assert_eq!(GeneralizedCost::of(&strips, cache, flush).triangles, 2);
        }
        assert_eq!(VertexCacheStatistics::of_list(&[[u32::MAX, 0, 7]], cache).vertices, 3);
        assert!(VertexCacheSimulator::new(cache, usize::MAX).is_err());

        let mut simulator = VertexCacheSimulator::new(cache, 3).unwrap();
        let message = "parameter `indices`: found index 3 at 1, over 3 vertices, expected less than the number of vertices";
        assert_eq!(simulator.send_all(&[2, 3]).unwrap_err().to_string(), message);
        assert!(simulator.send(u32::MAX).is_err() && simulator.misses() == 0);
        assert!(VertexCacheSimulator::new(cache, 0).unwrap().send(0).is_err());
    }
    assert!(lru_profile(&strips, u32::MAX, FlushPolicy::Keep).is_err());
    assert_eq!(lru_profile(&strips, 0, FlushPolicy::Keep), Ok(Vec::new()));
    assert_eq!(lru_profile(&strips, 3, FlushPolicy::Keep).unwrap(), [5, 4, 4]);
}
