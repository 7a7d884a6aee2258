//! Growth of time with the size of an input, which does not depend on how fast the machine is.

use std::time::Instant;

/// How much larger the second input is. Quadratic time would grow by its square, 64.
const LARGER: usize = 8;

/// The growth that is still linear: memory that no longer fits a cache, and other programs on the machine, cost time too.
const MAX_GROWTH: f64 = 28.0;

/// Checks that a run takes time in proportion to the size of its input, which `build` makes.
pub(crate) fn check_linear<T>(size: usize, build: impl Fn(usize) -> T, run: impl Fn(&T)) {
    let seconds = |size: usize| {
        let input = build(size);
        let times = (0..3).map(|_| {
            let start = Instant::now();
            run(&input);
            start.elapsed().as_secs_f64()
        });
        times.fold(f64::INFINITY, f64::min)
    };
    let growth = seconds(LARGER * size) / seconds(size);
    assert!(growth < MAX_GROWTH, "{LARGER} times the size takes {growth:.1} times as long");
}
