//! The inputs of a subcommand with their outputs: files, directories and the standard streams.

use std::collections::{HashMap, HashSet};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use tristrip::Layout;
use tristrip_io::Format;
use tristrip_pipeline::{Target, format_to_write, layout_to_write, path_of_level};

use crate::args::{GeneralArgs, OutputArgs};

/// An input and its output.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) input: Input,
    pub(crate) output: Option<Output>,
}

/// The source of a mesh.
#[derive(Debug)]
pub(crate) struct Input {
    /// `None` for standard input.
    pub(crate) path: Option<PathBuf>,
    pub(crate) format: Option<Format>,
}

/// The destination of a result, with its format and layout.
#[derive(Debug)]
pub(crate) struct Output {
    /// `None` for standard output.
    pub(crate) path: Option<PathBuf>,
    /// Whether the file is in an output directory. The directory is created if it does not exist.
    pub(crate) in_directory: bool,
    /// The format. It is GLB for a `.gltf` too: a `.gltf` is a GLB split into two files.
    pub(crate) format: Format,
    /// Whether the result is a `.gltf` with its buffer in a separate file.
    pub(crate) separate: bool,
    pub(crate) layout: Layout,
}

impl Input {
    /// Returns the name for messages and reports.
    pub(crate) fn name(&self) -> String {
        display_name(self.path.as_deref())
    }
}

impl Output {
    /// Creates an output for a file, or for standard output if there is no path.
    fn new(path: Option<PathBuf>, in_directory: bool, format: Format, layout: Layout) -> Self {
        let Target { format, separate, .. } = Target::new(None, format);
        Self { path, in_directory, format, separate, layout }
    }

    /// Creates an output in memory instead of a file.
    #[cfg(feature = "serve")]
    pub(crate) fn in_memory(format: Format) -> Self {
        Self { path: None, in_directory: false, format, separate: false, layout: Layout::List }
    }

    /// Returns the name for messages and reports.
    pub(crate) fn name(&self) -> String {
        display_name(self.path.as_deref())
    }

    /// Returns the files of the result.
    pub(crate) fn target(&self) -> Target<'_> {
        let (path, format) = (self.path.as_deref(), self.format);
        Target { path, format, separate: self.separate, creates_folder: self.in_directory }
    }

    /// Returns the output of one level of detail: a file in the same directory, with the level
    /// number in its name.
    pub(crate) fn of_level(&self, level: usize) -> Self {
        let path = self.path.as_deref().map(|path| path_of_level(path, level));
        Self { path, ..*self }
    }
}

/// Returns the name of a file, or `-` for a standard stream.
fn display_name(path: Option<&Path>) -> String {
    path.map_or_else(|| "-".into(), |path| path.display().to_string())
}

/// Returns the inputs of a subcommand that takes a list of inputs.
pub(crate) fn inputs_of(args: GeneralArgs) -> Result<Vec<Input>, String> {
    inputs(args.inputs, args.from.from)
}

/// Returns the jobs of a subcommand that writes files.
pub(crate) fn jobs_of(args: GeneralArgs, output: &OutputArgs) -> Result<Vec<Job>, String> {
    jobs_to(inputs_of(args)?, output, None)
}

/// Returns the jobs of a subcommand that writes several levels: to one GLB, or to one file per
/// level in a directory.
pub(crate) fn jobs_of_levels(
    args: GeneralArgs,
    output: &OutputArgs,
    level_count: usize,
) -> Result<Vec<Job>, String> {
    let jobs = jobs_to(inputs_of(args)?, output, Some(level_count))?;
    for output in jobs.iter().filter_map(|job| job.output.as_ref()).filter(|output| !output.in_directory) {
        if output.format != Format::Glb {
            let (name, format) = (output.name(), output.format.name());
            return Err(format!(
                "{name}: {format} holds one level; use .glb, .gltf, or a directory (one file per level)"
            ));
        }
    }
    Ok(jobs)
}

/// Returns the inputs of some paths. At most one of them can be standard input.
pub(crate) fn inputs(paths: Vec<PathBuf>, format: Option<Format>) -> Result<Vec<Input>, String> {
    if paths.iter().filter(|path| is_dash(path)).count() > 1 {
        return Err("standard input (-) can be read only once".into());
    }
    let input = |path: PathBuf| Input { path: (!is_dash(&path)).then_some(path), format };
    Ok(paths.into_iter().map(input).collect())
}

/// Returns whether any job writes to standard output.
pub(crate) fn write_to_stdout(jobs: &[Job]) -> bool {
    jobs.iter().any(|job| job.output.as_ref().is_some_and(|output| output.path.is_none()))
}

fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Pairs each input with its output. With `level_count`, an output in a directory is that many
/// files.
pub(crate) fn jobs_to(
    inputs: Vec<Input>,
    args: &OutputArgs,
    level_count: Option<usize>,
) -> Result<Vec<Job>, String> {
    let Some(target) = &args.target.output else {
        return Ok(inputs.into_iter().map(|input| Job { input, output: None }).collect());
    };
    if is_dash(target) {
        return jobs_to_stdout(inputs, args);
    }
    let slash =
        target.as_os_str().as_encoded_bytes().last().is_some_and(|&b| std::path::is_separator(b.into()));
    if inputs.len() > 1 || slash || target.is_dir() {
        return jobs_to_directory(inputs, target, args, level_count);
    }
    let format = format_to_write(target, args.target.to)?;
    let layout = layout_to_write(format, args.layout)?;
    let output = |_: &Input| Output::new(Some(target.clone()), false, format, layout);
    Ok(inputs.into_iter().map(|input| Job { output: Some(output(&input)), input }).collect())
}

fn jobs_to_stdout(inputs: Vec<Input>, args: &OutputArgs) -> Result<Vec<Job>, String> {
    let Some(format) = args.target.to else {
        return Err("-o - needs --to, the format to write".into());
    };
    if inputs.len() > 1 {
        let found = inputs.len();
        return Err(format!("-o -: found {found} inputs, expected one; use a directory for several"));
    }
    if format == Format::Gltf {
        return Err("-o - cannot hold the two files of a .gltf; use --to glb".into());
    }
    if format != Format::Obj && std::io::stdout().is_terminal() {
        return Err(format!(
            "standard output is a terminal, but {} is binary; redirect the output",
            format.name()
        ));
    }
    let layout = layout_to_write(format, args.layout)?;
    let output = || Some(Output::new(None, false, format, layout));
    Ok(inputs.into_iter().map(|input| Job { input, output: output() }).collect())
}

fn jobs_to_directory(
    inputs: Vec<Input>,
    directory: &Path,
    args: &OutputArgs,
    level_count: Option<usize>,
) -> Result<Vec<Job>, String> {
    let format = args.target.to.unwrap_or(Format::Glb);
    let layout = layout_to_write(format, args.layout)?;
    // Remove a trailing slash: with it, `exists` returns false for a file.
    let directory: &Path = &directory.components().collect::<PathBuf>();
    if directory.exists() && !directory.is_dir() {
        return Err(format!("{}: several inputs need a directory, but this is a file", directory.display()));
    }
    if !directory.exists() && Format::from_path(directory).is_some() {
        return Err(format!(
            "{}: several inputs need a directory, but this names a file",
            directory.display()
        ));
    }
    let mut first: HashMap<PathBuf, String> = HashMap::new();
    // Links are followed, so an input is found by any of its names.
    let all: HashSet<PathBuf> =
        inputs.iter().filter_map(|input| input.path.as_ref()?.canonicalize().ok()).collect();
    let mut jobs = Vec::with_capacity(inputs.len());
    for input in inputs {
        let stem = input.path.as_ref().and_then(|path| path.file_stem()).unwrap_or("stdin".as_ref());
        let mut file = stem.to_owned();
        file.push(".");
        file.push(format.extension());
        let path = directory.join(file);
        let written = match level_count {
            None => vec![path.clone()],
            Some(count) => (0..count).map(|level| path_of_level(&path, level)).collect(),
        };
        for file in written {
            if file.canonicalize().is_ok_and(|file| all.contains(&file)) {
                let file = file.display();
                return Err(format!("{file}: the output would replace the input; choose another directory"));
            }
            if let Some(other) = first.insert(file.clone(), input.name()) {
                let (file, name) = (file.display(), input.name());
                return Err(format!("{file}: both {other} and {name} would be written to this file"));
            }
        }
        jobs.push(Job { input, output: Some(Output::new(Some(path), true, format, layout)) });
    }
    Ok(jobs)
}
