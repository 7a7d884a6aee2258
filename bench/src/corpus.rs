//! Checks of one real model: every method is proven and gives the same bytes with any number of
//! threads. Also writes files for a checker that shares no code with the library.

use std::collections::HashSet;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use tristrip::verify::verify;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Layout, StripifyOptions, Strips, stripify};
use tristrip_io::{Drawing, Format, Model, read_path, write};

use crate::failure::Failure;
use crate::levels;
use crate::methods::{NOT_LOCALIZED, NamedMethod, all_methods, main_methods};
use crate::models::Source;

/// The numbers of threads that must give the same bytes.
pub const THREADS: [usize; 3] = [1, 2, 7];
/// Models with more triangles are checked with only one method per family.
pub const LARGE: usize = 300_000;
/// Models with more triangles are written with only one method per family, unless all files are
/// requested.
pub const MEDIUM: usize = 8_000;
/// Models with at most this number of triangles are written in every kind of file.
pub const SMALL: usize = 4_000;

/// The maximum number of reported problems per part.
const MAX_PROBLEMS: usize = 3;

/// A kind of file: format, layout, and file name suffix.
type FileKind = (Format, Layout, &'static str);
const FILE_KINDS: [FileKind; 5] = [
    (Format::Glb, Layout::Degenerate, "degenerate.glb"),
    (Format::Glb, Layout::Restart, "restart.glb"),
    (Format::Ply, Layout::Restart, "restart.ply"),
    (Format::Glb, Layout::List, "list.glb"),
    (Format::Glb, Layout::Separate, "separate.glb"),
];
/// The kinds that larger models alternate between. They exclude one primitive per strip, which
/// makes documents of megabytes.
const COMPACT_KINDS: usize = 4;

/// The result of checking a model.
#[derive(Debug, Default)]
pub struct CheckedModel {
    /// The number of results that `verify` has proven, one per method.
    pub proven: usize,
    /// The number of results with the same bytes for all numbers of threads.
    pub identical: usize,
    /// The number of levels of detail whose drawn triangles matched the oracle.
    pub levels: usize,
    /// Files for the checker.
    pub files: Vec<PathBuf>,
    /// One line per result: model, method or part, aspect, and a hash; empty unless requested.
    pub hashes: Vec<String>,
    /// Descriptions of the problems found.
    pub problems: Vec<String>,
}

/// One thread pool per number in [`THREADS`], reused for all models.
pub struct ThreadPools(Vec<rayon::ThreadPool>);

impl ThreadPools {
    /// Starts the threads.
    ///
    /// # Errors
    /// The system cannot start more threads.
    pub fn new() -> Result<Self, Failure> {
        let pool = |count| rayon::ThreadPoolBuilder::new().num_threads(count).build();
        Ok(Self(THREADS.into_iter().map(pool).collect::<Result<_, _>>()?))
    }
}

/// Optional steps of a check.
#[derive(Debug, Clone, Copy, Default)]
pub struct CheckOptions {
    /// Whether to write one file per method, regardless of the size of the model.
    pub all_files: bool,
    /// Whether to hash every index buffer, file and level of detail, for comparing two versions of
    /// the program.
    pub hashes: bool,
}

/// Returns the hash of a value. It is the same for every build with one version of Rust.
pub fn hash_of(value: impl Hash) -> String {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// Checks a model with every method, and writes files to a directory.
///
/// # Errors
/// The model cannot be read, or a file cannot be written.
pub fn check(
    source: &Source,
    pools: &ThreadPools,
    folder: &Path,
    extra: CheckOptions,
) -> Result<CheckedModel, Failure> {
    let model = read_path(&source.path).map_err(|error| format!("{}: {error}", source.path.display()))?;
    let triangles: usize = model.parts.iter().map(|part| part.mesh.faces().triangle_count()).sum();
    let mut methods = if triangles > LARGE { main_methods() } else { all_methods() };
    // Without localization, the time of a step depends on the length of the strips that it changes.
    methods.retain(|method| triangles <= MEDIUM || !method.name.ends_with(NOT_LOCALIZED));
    let families: HashSet<String> = main_methods().into_iter().map(|m| m.name).collect();
    let mut checked = CheckedModel::default();
    for (turn, NamedMethod { name, options }) in methods.iter().enumerate() {
        let say = |what: &str| format!("{}, {name}: {what}", source.name);
        let is_main = families.contains(name);
        let kinds: Vec<FileKind> = match triangles {
            0..=SMALL if is_main => FILE_KINDS.to_vec(),
            0..=MEDIUM => vec![FILE_KINDS[turn % COMPACT_KINDS]],
            _ if is_main || extra.all_files => vec![FILE_KINDS[turn % COMPACT_KINDS]],
            _ => Vec::new(),
        };
        // For larger models, variants of methods run with 1 thread and, in turn, one of the other
        // numbers.
        let is_sampled = !is_main && triangles > MEDIUM;
        let left_out = is_sampled.then_some(1 + turn % 2);
        let pools = pools.0.iter().enumerate().filter(|(number, _)| Some(*number) != left_out);
        let results = pools.map(|(_, pool)| {
            let strips = pool.install(|| strip(&model, options))?;
            let bytes = files(&model, &strips, &kinds)?;
            Ok((strips, bytes))
        });
        let mut results = results.collect::<Result<Vec<_>, Failure>>()?;
        match prove(&model, &results[0].0) {
            Ok(()) => checked.proven += 1,
            Err(error) => checked.problems.push(say(&error)),
        }
        if results.iter().all(|result| *result == results[0]) {
            checked.identical += 1;
        } else {
            checked.problems.push(say(&format!("different bytes with {THREADS:?} threads")));
        }
        let (strips, written) = results.swap_remove(0);
        if extra.hashes {
            let line = |(what, hash): (&str, String)| format!("{}\t{name}\t{what}\t{hash}", source.name);
            checked.hashes.extend(index_buffers(&strips).into_iter().map(line));
            let files = kinds.iter().zip(&written).map(|((_, _, kind), bytes)| line((kind, hash_of(bytes))));
            checked.hashes.extend(files);
        }
        for ((_, _, kind), bytes) in kinds.iter().zip(written) {
            let path = folder.join(format!("{}.{}.{kind}", source.name, name.replace(' ', "_")));
            fs::write(&path, bytes)?;
            checked.files.push(path);
        }
    }
    for (number, part) in model.parts.iter().enumerate() {
        let of_part = levels::check(&part.mesh, extra.hashes)?;
        let line = |hash| format!("{}\tpart {number}\t{hash}", source.name);
        checked.hashes.extend(of_part.hashes.into_iter().map(line));
        checked.levels += of_part.levels;
        let say = |problem| format!("{}, part {number}: {problem}", source.name);
        checked.problems.extend(of_part.problems.into_iter().take(MAX_PROBLEMS).map(say));
    }
    Ok(checked)
}

/// Hashes the strips of all parts in each layout, and their misses in simulated vertex caches.
fn index_buffers(strips: &[Strips]) -> [(&'static str, String); 5] {
    let of = |layout: fn(&Strips) -> Vec<u32>| hash_of(strips.iter().map(layout).collect::<Vec<_>>());
    let misses = |strips: &Strips| {
        [VertexCache::fifo(16), VertexCache::lru(16)]
            .map(|b| VertexCacheStatistics::of(strips, b, FlushPolicy::default()).misses)
    };
    [
        ("restart", of(|strips| strips.to_restart(u32::MAX))),
        ("degenerate", of(Strips::to_degenerate)),
        ("list", of(Strips::to_list)),
        ("lengths", of(|strips| strips.iter().map(|strip| strip.len() as u32).collect())),
        ("misses", hash_of(strips.iter().map(misses).collect::<Vec<_>>())),
    ]
}

/// Finds the strips of every part, in parallel and in order, as the command does.
fn strip(model: &Model, options: &StripifyOptions) -> Result<Vec<Strips>, tristrip::Error> {
    model.parts.par_iter().map(|part| stripify(&part.mesh, options)).collect()
}

fn prove(model: &Model, strips: &[Strips]) -> Result<(), String> {
    for (number, (part, strips)) in model.parts.iter().zip(strips).enumerate() {
        verify(&part.mesh, strips).map_err(|error| format!("not proven: part {number}: {error}"))?;
    }
    Ok(())
}

fn files(model: &Model, strips: &[Strips], kinds: &[FileKind]) -> Result<Vec<Vec<u8>>, tristrip_io::Error> {
    let drawings: Vec<Drawing<'_>> = strips.iter().map(Drawing::Strips).collect();
    kinds.iter().map(|&(format, layout, _)| write(model, &drawings, format, layout)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::all_methods;

    #[test]
    fn a_small_model_passes_with_every_method() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models/fish_control.ply");
        let folder = std::env::temp_dir().join(format!("tristrip-corpus-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let source = Source { name: "fish_control".into(), path };
        let checked = check(&source, &ThreadPools::new().unwrap(), &folder, CheckOptions::default()).unwrap();
        assert_eq!(checked.problems, Vec::<String>::new());
        assert_eq!((checked.proven, checked.identical), (all_methods().len(), all_methods().len()));
        let mains = main_methods().len();
        assert_eq!(checked.files.len(), mains * FILE_KINDS.len() + all_methods().len() - mains);
        fs::remove_dir_all(folder).unwrap();
    }
}
