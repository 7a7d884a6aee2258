//! Groups of flags that several subcommands share.

use std::path::PathBuf;

use clap::Args;
use tristrip::Layout;
use tristrip_io::Format;

use crate::values::{WRITTEN_FORMATS, format_parser, layout_help, named};

/// The flags of every subcommand that takes a list of inputs.
#[derive(Debug, Args)]
pub(crate) struct GeneralArgs {
    /// Mesh files, or - for standard input
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) from: FromArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "General")]
pub(crate) struct FromArgs {
    /// The format of standard input, or of files with a misleading extension
    ///
    /// By default the file name extension decides, or the content if the extension is unknown.
    #[arg(long, value_name = "FORMAT", value_parser = format_parser(&Format::ALL))]
    pub(crate) from: Option<Format>,
}

/// The flags of all subcommands, which may also stand before the subcommand.
#[derive(Debug, Args)]
#[command(next_help_heading = "General")]
pub(crate) struct SharedArgs {
    /// Print the results as JSON on standard output
    ///
    /// One object for one input, an array for several. FORMAT.md describes the keys.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print only errors and requested results: JSON, a table, a report without -o
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// The number of threads [default: one per core]
    ///
    /// The result does not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    #[command(flatten)]
    pub(crate) target: TargetArgs,
    /// The layout of strips in the index buffer [default: degenerate for GLB, restart for PLY, list for OBJ]
    ///
    /// By default, `strip` writes a part as a triangle list where that takes fewer indices than strips. A GLB in layout restart needs the
    /// draft extension for primitive restart: viewers that ignore it, such as three.js, draw it wrong.
    #[arg(long, value_parser = named(Layout::ALL, Layout::name, layout_help), value_name = "LAYOUT", requires = "output")]
    pub(crate) layout: Option<Layout>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct TargetArgs {
    /// The file to write, a directory for several inputs, or - for standard output
    ///
    /// The extension selects the format: .glb, .gltf, .ply or .obj. A .gltf has its buffer beside it, in a file of the same name with the
    /// extension .bin. A file is written under a temporary name and then renamed; one that exists is replaced. In a directory, each output has the name of its input, with the extension of --to.
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: Option<PathBuf>,
    /// The format to write [default: by the extension; glb in a directory]
    #[arg(long, value_name = "FORMAT", requires = "output", value_parser = format_parser(&WRITTEN_FORMATS))]
    pub(crate) to: Option<Format>,
    /// Skip verification
    #[arg(long)]
    pub(crate) no_verify: bool,
}
