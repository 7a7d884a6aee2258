//! The checks of one real model: every method proven, the same bytes with any number of threads, and files for a checker that
//! shares no code with the library.

use std::collections::HashSet;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use tristrip::verify::verify;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Layout, StripifyOptions, Strips, stripify};
use tristrip_io::{Drawing, Format, Model, Part, read_path, write};

use crate::methods::{Named, all_methods, main_methods};
use crate::models::Source;
use crate::{Failure, levels};

/// Thread counts that must give the same bytes.
pub const THREADS: [usize; 3] = [1, 2, 7];
/// Models of more triangles are checked with one method of each family only.
pub const LARGE: usize = 300_000;
/// Models of more triangles are written with one method of each family only, unless all files are asked for.
pub const MEDIUM: usize = 16_000;
/// Models of at most so many triangles are written in every kind of file.
pub const SMALL: usize = 8_000;

/// Faults of a part's levels that are told.
const MOST_FAULTS: usize = 3;

/// A kind of file: format, layout, and its part of the file name.
type Kind = (Format, Layout, &'static str);
const KINDS: [Kind; 5] = [
    (Format::Glb, Layout::Degenerate, "degenerate.glb"),
    (Format::Glb, Layout::Restart, "restart.glb"),
    (Format::Ply, Layout::Restart, "restart.ply"),
    (Format::Glb, Layout::List, "list.glb"),
    (Format::Glb, Layout::Separate, "separate.glb"),
];
/// The kinds that larger models take turns in: not a primitive a strip, which makes documents of megabytes.
const COMPACT_KINDS: usize = 4;

/// What was checked of a model.
#[derive(Debug, Default)]
pub struct Checked {
    /// Results that `verify` has proven, one a method.
    pub proven: usize,
    /// Results of which all thread counts gave the same bytes.
    pub identical: usize,
    /// Levels of detail at which all drawings were the oracle's.
    pub levels: usize,
    /// Files for the checker.
    pub files: Vec<PathBuf>,
    /// One line per result: model, method or part, what of it, and a hash; empty unless asked for.
    pub hashes: Vec<String>,
    /// What went wrong, in words.
    pub faults: Vec<String>,
}

/// Pools of as many threads as [`THREADS`] says, made once.
pub struct Pools(Vec<rayon::ThreadPool>);

impl Pools {
    /// Starts the threads.
    ///
    /// # Errors
    /// The system has none left.
    pub fn new() -> Result<Self, Failure> {
        let pool = |count| rayon::ThreadPoolBuilder::new().num_threads(count).build();
        Ok(Self(THREADS.into_iter().map(pool).collect::<Result<_, _>>()?))
    }
}

/// What a check does beyond proving the results.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extra {
    /// Writes one file per method, whatever the model's size.
    pub all_files: bool,
    /// Hashes every index buffer, file and level of detail, so that two versions of the program can be compared.
    pub hashes: bool,
}

/// Returns the hash of a value; the same for every build with one version of Rust.
pub fn hash_of(value: impl Hash) -> String {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// Checks a model with every method, and writes files into a folder.
///
/// # Errors
/// The model cannot be read, or a file not be written.
pub fn check(source: &Source, pools: &Pools, folder: &Path, extra: Extra) -> Result<Checked, Failure> {
    let model = read_path(&source.path).map_err(|error| format!("{}: {error}", source.path.display()))?;
    let triangles: usize = model.parts.iter().map(|part| part.mesh.faces().triangle_count()).sum();
    let methods = if triangles > LARGE { main_methods() } else { all_methods() };
    let families: HashSet<String> = main_methods().into_iter().map(|m| m.name).collect();
    let mut checked = Checked::default();
    for (turn, Named { name, options }) in methods.iter().enumerate() {
        let say = |what: &str| format!("{}, {name}: {what}", source.name);
        let is_main = families.contains(name);
        let kinds: Vec<Kind> = match triangles {
            0..=SMALL if is_main => KINDS.to_vec(),
            0..=MEDIUM => vec![KINDS[turn % COMPACT_KINDS]],
            _ if is_main || extra.all_files => vec![KINDS[turn % COMPACT_KINDS]],
            _ => Vec::new(),
        };
        let results = pools.0.iter().map(|pool| {
            let strips = pool.install(|| strip(&model, options))?;
            let bytes = files(&model, &strips, &kinds)?;
            Ok((strips, bytes))
        });
        let mut results = results.collect::<Result<Vec<_>, Failure>>()?;
        match prove(&model, &results[0].0) {
            Ok(()) => checked.proven += 1,
            Err(error) => checked.faults.push(say(&error)),
        }
        if results.iter().all(|result| *result == results[0]) {
            checked.identical += 1;
        } else {
            checked.faults.push(say(&format!("not the same with {THREADS:?} threads")));
        }
        let (strips, written) = results.swap_remove(0);
        if extra.hashes {
            let line = |(what, hash): (&str, String)| format!("{}\t{name}\t{what}\t{hash}", source.name);
            checked.hashes.extend(index_buffers(&model, &strips).into_iter().map(line));
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
        let say = |fault| format!("{}, part {number}: {fault}", source.name);
        checked.faults.extend(of_part.faults.into_iter().take(MOST_FAULTS).map(say));
    }
    Ok(checked)
}

/// Hashes what all parts' strips come to in each layout, and in simulated vertex caches.
fn index_buffers(model: &Model, strips: &[Strips]) -> [(&'static str, String); 5] {
    let of = |layout: fn(&Strips) -> Vec<u32>| hash_of(strips.iter().map(layout).collect::<Vec<_>>());
    let misses = |(part, strips): (&Part, &Strips)| {
        let count = part.mesh.vertex_count();
        [VertexCache::fifo(16), VertexCache::lru(16)]
            .map(|b| VertexCacheStatistics::of(strips, b, FlushPolicy::default(), count).misses)
    };
    [
        ("restart", of(|strips| strips.to_restart(u32::MAX))),
        ("degenerate", of(Strips::to_degenerate)),
        ("list", of(Strips::to_list)),
        ("lengths", of(|strips| strips.iter().map(|strip| strip.len() as u32).collect())),
        ("misses", hash_of(model.parts.iter().zip(strips).map(misses).collect::<Vec<_>>())),
    ]
}

/// Strips every part, the parts in parallel and in order, as the command does.
fn strip(model: &Model, options: &StripifyOptions) -> Result<Vec<Strips>, tristrip::Error> {
    model.parts.par_iter().map(|part| stripify(&part.mesh, options)).collect()
}

fn prove(model: &Model, strips: &[Strips]) -> Result<(), String> {
    for (number, (part, strips)) in model.parts.iter().zip(strips).enumerate() {
        verify(&part.mesh, strips).map_err(|error| format!("not proven: part {number}: {error}"))?;
    }
    Ok(())
}

fn files(model: &Model, strips: &[Strips], kinds: &[Kind]) -> Result<Vec<Vec<u8>>, tristrip_io::Error> {
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
        let checked = check(&source, &Pools::new().unwrap(), &folder, Extra::default()).unwrap();
        assert_eq!(checked.faults, Vec::<String>::new());
        assert_eq!((checked.proven, checked.identical), (all_methods().len(), all_methods().len()));
        let mains = main_methods().len();
        assert_eq!(checked.files.len(), mains * KINDS.len() + all_methods().len() - mains);
        fs::remove_dir_all(folder).unwrap();
    }
}
