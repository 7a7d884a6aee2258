//! The measurements on a hostile shape: the methods at their default effort, and levels of detail.

use std::sync::Arc;
use std::time::Instant;

use tristrip::lod::{Encoding, ProgressiveStrips};
use tristrip::lod::{Filter, LevelCursor, RESTART, Repair, RepairOptions};
use tristrip::simplify::{self, simplify_triangles};
use tristrip::verify::{verify, verify_drawing};
use tristrip::{CollapseSequence, Faces, Mesh, Method, StripifyOptions, Strips, stripify};

use crate::failure::Failure;

/// The number of levels in the table of the levels of detail.
const LEVELS: usize = 20;
/// The percentage of triangles that the base mesh keeps, which is the default of the command.
const BASE_PERCENT: usize = 5;

/// The task that is run on a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    Strips(Method),
    Levels,
}

/// A method, or levels of detail, with its time limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HostileMethod {
    /// Its name.
    pub name: &'static str,
    /// The maximum time in microseconds per triangle, beyond one second.
    pub microseconds: f64,
    task: Task,
}

/// The methods at their default effort. `fewest` searches for about a second per 100,000 triangles
/// on any model.
pub const METHODS: [HostileMethod; 6] = [
    HostileMethod { name: "best", microseconds: 3.0, task: Task::Strips(Method::Best) },
    HostileMethod { name: "sequential", microseconds: 3.0, task: Task::Strips(Method::Sequential) },
    HostileMethod { name: "cache", microseconds: 3.0, task: Task::Strips(Method::Cache) },
    HostileMethod { name: "fewest", microseconds: 12.0, task: Task::Strips(Method::Fewest) },
    HostileMethod { name: "tunnel", microseconds: 3.0, task: Task::Strips(Method::TUNNEL) },
    HostileMethod { name: "lod", microseconds: 12.0, task: Task::Levels },
];

/// The result of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HostileRun {
    /// The number of triangles of the shape.
    pub triangles: usize,
    /// The time from faces to strips, or from strips to all levels, in seconds.
    pub seconds: f64,
    /// The time to prove the strips, in seconds.
    pub proof_seconds: f64,
    /// The number of strips of the full mesh.
    pub strips: usize,
}

impl HostileMethod {
    /// Returns the method with a name.
    pub fn of_name(name: &str) -> Option<Self> {
        METHODS.into_iter().find(|method| method.name == name)
    }

    /// Runs the method on a mesh, and proves the result.
    ///
    /// # Errors
    /// The result is not proven.
    pub fn run(&self, mesh: &Mesh) -> Result<HostileRun, Failure> {
        let method = if let Task::Strips(method) = self.task { method } else { Method::Sequential };
        let (strips, mut seconds) = timed(|| stripify(mesh, &StripifyOptions::default().with_method(method)));
        let strips = strips?;
        let (proof, proof_seconds) = timed(|| verify(mesh, &strips));
        proof?;
        if self.task == Task::Levels {
            let (done, of_levels) = timed(|| levels(mesh, &strips));
            done?;
            seconds = of_levels;
        }
        let triangles = mesh.faces().triangle_count();
        Ok(HostileRun { triangles, seconds, proof_seconds, strips: strips.len() })
    }
}

fn timed<T>(call: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = call();
    (result, start.elapsed().as_secs_f64())
}

/// Simplifies the triangles of strips, and builds the display strips of several levels with every
/// filter. All are proven.
fn levels(mesh: &Mesh, strips: &Strips) -> Result<(), Failure> {
    let list = strips.to_list();
    let options = simplify::SimplifyOptions::default().with_triangles(list.len() / 3 * BASE_PERCENT / 100);
    let sequence = simplify_triangles(mesh, list, &options)?.sequence;
    for encoding in [Encoding::Naive, Encoding::Offsets] {
        ProgressiveStrips::new(strips, &sequence, encoding)?;
    }
    let map = strips.to_restart(RESTART);
    let sequence = Arc::new(sequence);
    let mut repair = Repair::new(Arc::clone(&sequence), strips, RepairOptions::default())?;
    for step in (0..=LEVELS).rev() {
        let level = sequence.len() * step / LEVELS;
        repair.set_level(level)?;
        prove(&sequence, level, repair.strips())?;
        let renaming = sequence.renaming(level)?;
        let renamed = |&v: &u32| if v == RESTART { RESTART } else { renaming[v as usize] };
        let map: Vec<u32> = map.iter().map(renamed).collect();
        for filter in Filter::ALL {
            let mut display = Strips::default();
            filter.map_to(&map, &mut display);
            prove(&sequence, level, &display)?;
        }
    }
    Ok(())
}

fn prove(sequence: &CollapseSequence, level: usize, display: &Strips) -> Result<(), Failure> {
    let expected = Faces::from_triangles(sequence.drawn(level)?.into_flattened())?;
    verify_drawing(&expected, &display.triangles().collect::<Vec<_>>())?;
    Ok(())
}
