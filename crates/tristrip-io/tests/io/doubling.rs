//! Growth of work with the size of an input. It is measured in processor time of the thread, which neither waiting nor other
//! programs on the machine add to.

use rustix::time::{ClockId, clock_gettime};

/// How much larger the second input is. Quadratic work would grow by its square, 64.
const LARGER: usize = 8;

/// The growth that is still linear: memory that no longer fits a cache costs time, too.
const MAX_GROWTH: f64 = 28.0;

/// Checks that a run does work in proportion to the size of its input, which `build` makes.
pub(crate) fn check_linear<T>(size: usize, build: impl Fn(usize) -> T, run: impl Fn(&T)) {
    let seconds = |size: usize| {
        let input = build(size);
        let times = (0..3).map(|_| {
            let start = processor_seconds();
            run(&input);
            processor_seconds() - start
        });
        times.fold(f64::INFINITY, f64::min)
    };
    let growth = seconds(LARGER * size) / seconds(size);
    assert!(growth < MAX_GROWTH, "{LARGER} times the size takes {growth:.1} times the work");
}

/// Returns the seconds that a processor has spent in this thread.
fn processor_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
