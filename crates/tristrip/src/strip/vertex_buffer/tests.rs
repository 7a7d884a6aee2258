use super::*;
use proptest::prelude::*;
use std::collections::VecDeque;

/// The buffer as a queue of its vertices, searched from end to end; tells the hits.
fn hits_of_a_queue(indices: &[u32], buffer: Buffer) -> Vec<bool> {
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
        if queue.len() > buffer.places as usize {
            queue.pop_front();
        }
        found.is_some()
    };
    indices.iter().map(send).collect()
}

fn misses_of_a_queue(strips: &Strips, buffer: Buffer, between: Between) -> usize {
    let runs: Vec<&[u32]> = match between {
        Between::Keep => vec![strips.vertices()],
        Between::Flush => strips.iter().collect(),
    };
    runs.iter().flat_map(|run| hits_of_a_queue(run, buffer)).filter(|hit| !hit).count()
}

fn any_buffer() -> impl Strategy<Value = Buffer> {
    (any::<bool>(), 0..50_u32)
        .prop_map(|(fifo, places)| if fifo { Buffer::fifo(places) } else { Buffer::lru(places) })
}

fn any_strips() -> impl Strategy<Value = Strips> {
    prop::collection::vec(prop::collection::vec(0..40_u32, 0..30), 0..20).prop_map(|all| {
        let mut strips = Strips::default();
        all.iter().for_each(|strip| strips.push(strip));
        strips
    })
}

const BOTH: [Between; 2] = [Between::Keep, Between::Flush];

proptest! {
    #[test]
    fn hits_are_those_of_a_queue(
        indices in prop::collection::vec(0..40_u32, 0..300),
        buffer in any_buffer(),
    ) {
        let mut real = VertexBuffer::new(buffer, 40);
        let hits: Vec<bool> = indices.iter().map(|&v| real.send(v)).collect();
        prop_assert_eq!(&hits, &hits_of_a_queue(&indices, buffer));
        prop_assert_eq!(real.misses(), hits.iter().filter(|hit| !*hit).count());
        let mut at_once = VertexBuffer::new(buffer, 40);
        at_once.send_all(&indices);
        prop_assert_eq!(at_once.misses(), real.misses());
    }

    #[test]
    fn strips_cost_what_a_queue_says(strips in any_strips(), buffer in any_buffer()) {
        for between in BOTH {
            let used = BufferUse::of(&strips, buffer, between, 40);
            prop_assert_eq!(used.misses, misses_of_a_queue(&strips, buffer, between));
            prop_assert_eq!(used.triangles, strips.triangles().count());
            prop_assert_eq!(used, BufferUse::of(&strips, buffer, between, 400_000));
        }
    }

    #[test]
    fn a_list_costs_what_its_indices_do(
        indices in prop::collection::vec(0..40_u32, 0..100),
        buffer in any_buffer(),
    ) {
        let used = BufferUse::of_list(&indices, buffer, 40);
        let hits = hits_of_a_queue(&indices, buffer);
        prop_assert_eq!(used.misses, hits.iter().filter(|hit| !*hit).count());
    }

    #[test]
    fn a_clock_that_runs_over_changes_nothing(
        indices in prop::collection::vec(0..40_u32, 0..300),
        places in 1..50_u32,
        left in 0..100_u32,
        flush in 0..300_usize,
    ) {
        let mut late = Fifo::new(places, 40).with_late_clock(left + 1);
        let mut usual = Fifo::new(places, 40);
        for (i, &v) in indices.iter().enumerate() {
            if i == flush {
                late.flush();
                usual.flush();
            }
            prop_assert_eq!(late.send(v), usual.send(v), "index {}", i);
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
        let expected = hits_of_a_queue(&indices, Buffer::lru(places));
        for mut buffer in [Lru::new(places, 3000), Lru::new(places, 3000).with_late_times(9000)] {
            let hits: Vec<bool> = indices.iter().map(|&v| buffer.send(v)).collect();
            assert_eq!(hits, expected, "{places} places");
        }
    }
}

#[test]
fn a_swap_is_a_hit_and_no_triangle() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 1, 3]);
    for buffer in [Buffer::fifo(3), Buffer::lru(3)] {
        let used = BufferUse::of(&strips, buffer, Between::Keep, 9);
        assert_eq!(used, BufferUse { misses: 4, triangles: 2, vertices: 4 });
    }
    assert!(BufferUse::default().acmr() + BufferUse::default().atvr() < f64::MIN_POSITIVE);
}

#[test]
fn nothing_and_almost_nothing() {
    let mut one = Strips::default();
    one.push(&[]);
    one.push(&[5]);
    for buffer in
        [Buffer::fifo(0), Buffer::lru(0), Buffer::fifo(1), Buffer::lru(u32::MAX), Buffer::fifo(u32::MAX)]
    {
        for between in BOTH {
            assert_eq!(BufferUse::of(&Strips::default(), buffer, between, 0), BufferUse::default());
            assert_eq!(
                BufferUse::of(&one, buffer, between, 6),
                BufferUse { misses: 1, triangles: 0, vertices: 1 }
            );
        }
        assert_eq!(BufferUse::of_list(&[], buffer, 0), BufferUse::default());
    }
}

#[test]
fn buffers_are_read_as_they_are_written() {
    for text in ["fifo:1", "lru:65536", "fifo:16"] {
        assert_eq!(text.parse::<Buffer>().map(|buffer| buffer.to_string()), Ok(text.to_string()));
    }
    for text in
        ["", "fifo", "fifo:", ":16", "fifo:0", "lru:65537", "lru:+4", "lru: 4", "mru:4", "fifo:4:4", "FIFO:4"]
    {
        let error = text.parse::<Buffer>().unwrap_err().to_string();
        assert!(error.contains("N from 1 to 65536") && error.contains(text), "{error}");
    }
}
