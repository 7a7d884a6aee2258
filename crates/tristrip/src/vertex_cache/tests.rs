use super::distances::Distances;
use super::*;
use proptest::prelude::*;
use std::collections::VecDeque;

/// The buffer as a queue of its vertices, searched from end to end; tells the hits.
fn hits_of_a_queue(indices: &[u32], buffer: VertexCache) -> Vec<bool> {
    let mut queue = VecDeque::new();
    let send = |v: &u32| {
        let found = queue.iter().position(|inside| inside == v);
        if buffer.replacement == Replacement::Lru
            && let Some(place) = found
        {
            queue.remove(place);
            queue.push_back(*v);
        }
        if found.is_none() {
            queue.push_back(*v);
        }
        if queue.len() > buffer.entries as usize {
            queue.pop_front();
        }
        found.is_some()
    };
    indices.iter().map(send).collect()
}

fn misses_of_a_queue(strips: &Strips, buffer: VertexCache, between: FlushPolicy) -> usize {
    let runs: Vec<&[u32]> = match between {
        FlushPolicy::Keep => vec![strips.vertices()],
        FlushPolicy::Flush => strips.iter().collect(),
    };
    runs.iter().flat_map(|run| hits_of_a_queue(run, buffer)).filter(|hit| !hit).count()
}

fn any_buffer() -> impl Strategy<Value = VertexCache> {
    (any::<bool>(), 0..50_u32)
        .prop_map(|(fifo, places)| if fifo { VertexCache::fifo(places) } else { VertexCache::lru(places) })
}

fn any_strips() -> impl Strategy<Value = Strips> {
    prop::collection::vec(prop::collection::vec(0..40_u32, 0..30), 0..20).prop_map(|all| {
        let mut strips = Strips::default();
        all.iter().for_each(|strip| strips.push(strip));
        strips
    })
}

/// Strips that turn often, in which no vertex follows itself but the first one.
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

/// The machine with its buffer as a queue, the oldest first, and the vertices at hand as a list.
fn cost_by_a_queue(strips: &Strips, buffer: VertexCache, between: FlushPolicy) -> GeneralizedCost {
    let mut cost = GeneralizedCost { triangles: strips.triangles().count(), ..GeneralizedCost::default() };
    let mut queue: Vec<u32> = Vec::new();
    for strip in strips.iter() {
        if between == FlushPolicy::Flush {
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
                match (buffer.replacement, inside, other) {
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
                    if queue.len() > buffer.entries as usize {
                        queue.remove(0);
                    }
                }
                Some(a) => {
                    cost.references += 1;
                    cost.reference_bits +=
                        (0..32).find(|bits| 1_u64 << bits >= u64::from(buffer.entries)).unwrap();
                    if buffer.replacement == Replacement::Lru {
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
        buffer in any_buffer(),
    ) {
        let mut real = VertexCacheSimulator::new(buffer, 40);
        let hits: Vec<bool> = indices.iter().map(|&v| real.send(v)).collect();
        prop_assert_eq!(&hits, &hits_of_a_queue(&indices, buffer));
        prop_assert_eq!(real.misses(), hits.iter().filter(|hit| !*hit).count());
        let mut at_once = VertexCacheSimulator::new(buffer, 40);
        at_once.send_all(&indices);
        prop_assert_eq!(at_once.misses(), real.misses());
    }

    #[test]
    fn strips_cost_what_a_queue_says(strips in any_strips(), buffer in any_buffer()) {
        for between in BOTH {
            let used = VertexCacheStatistics::of(&strips, buffer, between, 40);
            prop_assert_eq!(used.misses, misses_of_a_queue(&strips, buffer, between));
            prop_assert_eq!(used.triangles, strips.triangles().count());
            prop_assert_eq!(used, VertexCacheStatistics::of(&strips, buffer, between, 400_000));
        }
    }

    #[test]
    fn a_list_costs_what_its_indices_do(
        indices in prop::collection::vec(0..40_u32, 0..100),
        buffer in any_buffer(),
    ) {
        let used = VertexCacheStatistics::of_list(&indices, buffer, 40);
        let hits = hits_of_a_queue(&indices, buffer);
        prop_assert_eq!(used.misses, hits.iter().filter(|hit| !*hit).count());
    }

    #[test]
    fn many_buffers_cost_what_each_does(
        strips in any_strips(),
        buffers in prop::collection::vec(any_buffer(), 0..20),
    ) {
        for between in BOTH {
            let each = VertexCacheStatistics::of_each(&strips, &buffers, between, 40);
            let one_by_one: Vec<_> = buffers.iter().map(|&b| VertexCacheStatistics::of(&strips, b, between, 40)).collect();
            prop_assert_eq!(each, one_by_one);
        }
        let each = VertexCacheStatistics::of_list_each(strips.vertices(), &buffers, 40);
        let one_by_one: Vec<_> = buffers.iter().map(|&b| VertexCacheStatistics::of_list(strips.vertices(), b, 40)).collect();
        prop_assert_eq!(each, one_by_one);
    }

    #[test]
    fn a_profile_has_the_misses_of_every_size(strips in any_strips(), most in 0..50_u32) {
        for between in BOTH {
            let profile = lru_profile(&strips, most, between, 40);
            let expected: Vec<_> =
                (1..=most).map(|places| misses_of_a_queue(&strips, VertexCache::lru(places), between)).collect();
            prop_assert_eq!(profile, expected);
        }
    }

    #[test]
    fn strips_one_by_one_add_up(strips in any_strips(), buffer in any_buffer()) {
        for between in BOTH {
            let each = StripCacheStatistics::of(&strips, buffer, between, 40);
            prop_assert!(each.iter().map(|one| one.length).eq(strips.iter().map(<[u32]>::len)));
            let used = VertexCacheStatistics::of(&strips, buffer, between, 40);
            prop_assert_eq!(each.iter().map(|one| one.misses).sum::<usize>(), used.misses);
            prop_assert_eq!(each.iter().map(|one| one.triangles).sum::<usize>(), used.triangles);
        }
    }

    #[test]
    fn a_generalized_mesh_costs_what_a_queue_says(strips in any_turning_strips(), buffer in any_buffer()) {
        for between in BOTH {
            let cost = GeneralizedCost::of(&strips, buffer, between, 9);
            prop_assert_eq!(cost, cost_by_a_queue(&strips, buffer, between));
        }
    }

    #[test]
    fn two_places_transmit_the_gl_cost(strips in any_turning_strips()) {
        for buffer in [VertexCache::fifo(2), VertexCache::lru(2)] {
            let cost = GeneralizedCost::of(&strips, buffer, FlushPolicy::Flush, 9);
            let metrics = crate::strip::Metrics::of(&strips);
            prop_assert_eq!((cost.transmitted, cost.references), (metrics.gl_cost, 0));
            prop_assert_eq!(cost.triangles, metrics.triangles);
            prop_assert!(cost.swaps <= metrics.swaps);
        }
        let lru: Vec<_> = (2..12)
            .map(|places| GeneralizedCost::of(&strips, VertexCache::lru(places), FlushPolicy::Flush, 9).transmitted)
            .collect();
        prop_assert!(lru.is_sorted_by(|small, large| small >= large), "{:?}", lru);
    }

    #[test]
    fn a_clock_that_runs_over_changes_nothing(
        indices in prop::collection::vec(0..40_u32, 0..300),
        places in 1..50_u32,
        left in 0..100_i32,
        flush in 0..300_usize,
    ) {
        let mut late = Fifo::new([places, 3], 40).with_late_clocks(left + 50);
        let mut usual = Fifo::new([places, 3], 40);
        for (i, &v) in indices.iter().enumerate() {
            if i == flush {
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
fn a_long_run_rewrites_the_log_and_winds_times_back() {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) % 3000
    };
    let indices: Vec<u32> = (0..60_000).map(|_| next()).collect();
    for places in [1, 7, 100, 2000] {
        let expected = hits_of_a_queue(&indices, VertexCache::lru(places));
        for mut buffer in [Lru::new(places, 3000), Lru::new(places, 3000).with_late_times(9000)] {
            let hits: Vec<bool> = indices.iter().map(|&v| buffer.send(v)).collect();
            assert_eq!(hits, expected, "{places} places");
        }
        let misses = expected.iter().filter(|hit| !*hit).count();
        for most in [places, 2500] {
            let usual = Distances::new(most as usize, 3000);
            let late = Distances::new(most as usize, 3000).with_late_times(9000);
            for mut distances in [usual, late] {
                distances.send_all(&indices);
                assert_eq!(distances.misses()[places as usize - 1], misses, "{places} of {most} places");
            }
        }
    }
}

#[test]
fn a_swap_is_a_hit_and_no_triangle() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 1, 3]);
    for buffer in [VertexCache::fifo(3), VertexCache::lru(3)] {
        let used = VertexCacheStatistics::of(&strips, buffer, FlushPolicy::Keep, 9);
        assert_eq!(used, VertexCacheStatistics { misses: 4, triangles: 2, vertices: 4 });
    }
    assert!(
        VertexCacheStatistics::default().acmr() + VertexCacheStatistics::default().atvr() < f64::MIN_POSITIVE
    );
}

#[test]
fn nothing_and_almost_nothing() {
    let mut one = Strips::default();
    one.push(&[]);
    one.push(&[5]);
    for buffer in [
        VertexCache::fifo(0),
        VertexCache::lru(0),
        VertexCache::fifo(1),
        VertexCache::lru(u32::MAX),
        VertexCache::fifo(u32::MAX),
    ] {
        for between in BOTH {
            assert_eq!(
                VertexCacheStatistics::of(&Strips::default(), buffer, between, 0),
                VertexCacheStatistics::default()
            );
            assert_eq!(
                VertexCacheStatistics::of(&one, buffer, between, 6),
                VertexCacheStatistics { misses: 1, triangles: 0, vertices: 1 }
            );
        }
        assert_eq!(VertexCacheStatistics::of_list(&[], buffer, 0), VertexCacheStatistics::default());
    }
}

#[test]
fn buffers_are_read_as_they_are_written() {
    for text in ["fifo:1", "lru:65536", "fifo:16"] {
        assert_eq!(text.parse::<VertexCache>().map(|buffer| buffer.to_string()), Ok(text.to_string()));
    }
    for text in
        ["", "fifo", "fifo:", ":16", "fifo:0", "lru:65537", "lru:+4", "lru: 4", "mru:4", "fifo:4:4", "FIFO:4"]
    {
        let error = text.parse::<VertexCache>().unwrap_err().to_string();
        assert!(error.contains("N from 1 to 65536") && error.contains(text), "{error}");
    }
}
