//! Measures how work grows with the size of an input, in CPU time of the thread, which excludes
//! waiting and other programs.

use rustix::time::{ClockId, clock_gettime};

/// The size ratio of the two inputs. Quadratic work would grow by its square, 64.
const LARGER: usize = 8;

/// The maximum growth that counts as linear, because memory beyond a cache also costs time.
const MAX_GROWTH: f64 = 28.0;

/// Checks that the work of `run` is proportional to the size of the input that `build` makes.
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

/// Returns the CPU time of this thread in seconds.
fn processor_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
