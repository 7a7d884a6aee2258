//! Groups of flags shared by several subcommands.

use std::path::PathBuf;

use clap::Args;
use tristrip::Layout;
use tristrip::simplify::{AttributeWeights, Price};
use tristrip_io::Format;
use tristrip_pipeline::{Deviation, WRITTEN_FORMATS, simplify::CollapseRules};

use crate::values::{format_parser, layout_help, named};

/// The flags of subcommands that take a list of inputs.
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
    /// Read the input as this format [default: by extension or content]
    #[arg(long, value_name = "FORMAT", value_parser = format_parser(&Format::ALL), hide_short_help = true)]
    pub(crate) from: Option<Format>,
}

/// The flags of all subcommands. They can also precede the subcommand.
#[derive(Debug, Args)]
#[command(next_help_heading = "General")]
pub(crate) struct SharedArgs {
    /// Print results as JSON on standard output
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print only errors, warnings and requested results (JSON, tables, reports without -o)
    #[arg(short, long, global = true, hide_short_help = true)]
    pub(crate) quiet: bool,
    /// Use this many threads; results do not depend on it [default: one per core]
    #[arg(long, global = true, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    #[command(flatten)]
    pub(crate) target: TargetArgs,
    /// Store strips as degenerate, restart, separate or list [default: by format]
    #[arg(long, value_parser = named(Layout::ALL, Layout::name, layout_help), value_name = "LAYOUT", requires = "output", hide_possible_values = true)]
    pub(crate) layout: Option<Layout>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct TargetArgs {
    /// Write to a file, a directory for several inputs, or - for standard output
    ///
    /// The extension selects the format: .glb, .gltf, .ply or .obj. `tristrip help files` describes
    /// formats and layouts.
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: Option<PathBuf>,
    /// Write this format [default: by extension; glb in a directory]
    #[arg(long, hide_short_help = true, value_name = "FORMAT", requires = "output", value_parser = format_parser(&WRITTEN_FORMATS))]
    pub(crate) to: Option<Format>,
    /// Skip verification
    #[arg(long, hide_short_help = true)]
    pub(crate) no_verify: bool,
}

/// The rules and costs of collapses.
#[derive(Debug, Args)]
pub(crate) struct CollapseArgs {
    /// Limit the error, in mesh units or in % of the bounding-box diagonal [default: 1%]
    ///
    /// 0.01 is in mesh units, 0.1% is relative to the diagonal, and 100% allows any error.
    /// Simplification stops with a warning before it exceeds the limit.
    #[arg(long, value_name = "ERROR", allow_negative_numbers = true)]
    pub(crate) error: Option<Deviation>,
    /// Weight attributes: normal=1,uv=1,colour=1,tangent=1,skin=1 [default: 1 each]
    ///
    /// Attribute changes add to the cost of a collapse. A weight of 0 ignores the attribute.
    #[arg(long, value_name = "WEIGHTS", hide_short_help = true)]
    pub(crate) weight: Option<AttributeWeights>,
    /// Set the cost of a collapse: distance, planes or quadric
    #[arg(long, value_name = "PRICE", value_parser = named(Price::ALL, Price::name, Price::summary), default_value_t = Price::default(), hide_possible_values = true, hide_short_help = true)]
    pub(crate) price: Price,
    /// Let holes close, handles disappear and textures shift at seams, for very small results
    #[arg(long, hide_short_help = true)]
    pub(crate) permissive: bool,
    /// Keep all vertices on open borders, such as those between terrain tiles
    #[arg(long, hide_short_help = true)]
    pub(crate) lock_borders: bool,
    /// Join open borders within this distance, in mesh units or in % of the diagonal [default:
    /// 0.0001%]
    ///
    /// Joined borders collapse together, so no crack opens between them. Positions do not change. 0
    /// joins equal positions only.
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, hide_short_help = true)]
    pub(crate) weld_distance: Option<Deviation>,
}

impl CollapseArgs {
    /// Returns the collapse rules.
    pub(crate) fn rules(&self) -> CollapseRules {
        let usual = CollapseRules::default();
        CollapseRules {
            weights: self.weight.unwrap_or(usual.weights),
            price: self.price,
            permissive: self.permissive,
            lock_borders: self.lock_borders,
            weld_distance: self.weld_distance.unwrap_or(usual.weld_distance),
        }
    }
}
