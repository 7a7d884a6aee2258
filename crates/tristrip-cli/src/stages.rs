//! The stages from the meshes of a model to verified strips. Each stage processes all parts in parallel, so that it has one time; the
//! results are in the order of the parts for any number of threads.

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;
use tristrip::strip::{self, verify_models};
use tristrip::stripify::Watch;
use tristrip::{DualGraph, Faces, Mesh, Method, Options, Strips, Surface, stripify};

use crate::failure::Failure;

/// The threads that process parts. With one thread, it is the calling thread.
pub(crate) struct Pool(rayon::ThreadPool);

impl Pool {
    pub(crate) fn new(threads: Option<usize>) -> Result<Self, Failure> {
        let builder = rayon::ThreadPoolBuilder::new();
        let builder = match threads {
            Some(1) => builder.num_threads(1).use_current_thread(),
            Some(n) => builder.num_threads(n),
            None => builder,
        };
        builder.build().map(Self).map_err(|error| Failure::Input(format!("threads: {error}")))
    }

    /// Calls `work` for each item in parallel; the results are in the order of the items.
    pub(crate) fn map<T: Sync, R: Send>(&self, items: &[T], work: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
        self.0.install(|| items.par_iter().map(work).collect())
    }
}

/// Calls `work`, and returns its result and its time in seconds.
pub(crate) fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) load: Option<f64>,
    pub(crate) dual: Option<f64>,
    pub(crate) stripify: Option<f64>,
    pub(crate) verify: Option<f64>,
    pub(crate) write: Option<f64>,
}

/// A part with its prepared faces and its dual graph.
pub(crate) struct Prepared<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) surface: Surface<'a>,
    pub(crate) graph: DualGraph,
}

/// Prepares the faces and builds the dual graph of each mesh.
pub(crate) fn prepare<'a>(pool: &Pool, meshes: &[&'a Mesh], weld: bool) -> Vec<Prepared<'a>> {
    pool.map(meshes, |&mesh| {
        let surface = Surface::new(mesh, weld);
        let graph = DualGraph::new(surface.faces());
        Prepared { mesh, surface, graph }
    })
}

/// The strips of each part, and the method that built them, in the order of the parts.
pub(crate) struct FoundStrips {
    pub(crate) strips: Vec<Strips>,
    pub(crate) chosen: Vec<Method>,
}

/// Builds the strips of each part; searches report their progress to the watch.
pub(crate) fn find_strips(
    pool: &Pool,
    parts: &[Prepared<'_>],
    options: &Options,
    watch: &dyn Watch,
) -> Result<FoundStrips, Failure> {
    let found = pool.map(parts, |part| {
        let (method, plan) = stripify::choose_watched(&part.surface, &part.graph, options, watch)?;
        Ok((plan.strips(), method))
    });
    let (strips, chosen) = found.into_iter().collect::<Result<Vec<_>, Failure>>()?.into_iter().unzip();
    Ok(FoundStrips { strips, chosen })
}

/// Proves that the strips of each part draw its mesh.
///
/// # Errors
/// [`Failure::Unproven`], with the number of the part if there are several.
pub(crate) fn prove(
    pool: &Pool,
    parts: &[Prepared<'_>],
    strips: &[Strips],
    options: &Options,
) -> Result<(), Failure> {
    let pairs: Vec<_> = parts.iter().zip(strips).collect();
    let proofs = pool.map(&pairs, |(part, strips)| prove_part(part, strips, options.weld()));
    for (number, proof) in proofs.into_iter().enumerate() {
        proof.map_err(|why| match parts.len() {
            1 => Failure::Unproven(why),
            _ => Failure::Unproven(format!("part {number}: {why}")),
        })?;
    }
    Ok(())
}

fn prove_part(part: &Prepared<'_>, strips: &Strips, weld: bool) -> Result<(), String> {
    if !weld {
        return strip::verify(part.mesh, strips).map(drop).map_err(|why| why.to_string());
    }
    // A welded vertex has the index of the first of its vertices, which has the same position.
    let drawn = Faces::from_triangles(strips.to_list())
        .and_then(|faces| part.mesh.with_faces(faces))
        .and_then(|drawn| verify_models(&[part.mesh], &[&drawn]));
    match drawn {
        Ok(Ok(_)) => Ok(()),
        Ok(Err(difference)) => Err(difference.to_string()),
        Err(error) => Err(error.to_string()),
    }
}
