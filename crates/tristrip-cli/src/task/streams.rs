//! Tasks of progressive GLB.

use std::path::PathBuf;

use tristrip::Layout;
use tristrip::stream::StreamOptions;
use tristrip_io::Format;
use tristrip_pipeline::{levels::Level, pack, unpack::StreamGoal};

use super::checks::check_chart;
use crate::args::{InspectArgs, OutputArgs, PackArgs, TargetArgs, UnpackArgs};
use crate::job::{Input, Job, inputs, inputs_of, jobs_of, jobs_to};
use crate::values::VectorArg;

#[derive(Debug)]
pub(crate) struct PackTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: pack::Options,
}

#[derive(Debug)]
pub(crate) struct UnpackTask {
    pub(crate) job: Job,
    pub(crate) goal: StreamGoal,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct InspectTask {
    pub(crate) inputs: Vec<Input>,
    /// Whether to print one row per chunk.
    pub(crate) chunks: bool,
    /// The SVG file to write.
    pub(crate) plot: Option<PathBuf>,
}

pub(super) fn pack_task(args: PackArgs) -> Result<PackTask, String> {
    let extension = args.output.extension().unwrap_or_default();
    let is_other = Format::from_path(&args.output).is_some() && !extension.eq_ignore_ascii_case("glb");
    if is_other {
        return Err(format!("{}: pack writes .glb; use this extension", args.output.display()));
    }
    let target = TargetArgs { output: Some(args.output), to: Some(Format::Glb), no_verify: args.no_verify };
    let output = OutputArgs { target, layout: Some(Layout::List) };
    let jobs = jobs_of(args.general, &output)?;
    let mut stream = StreamOptions::default();
    if let Some(bits) = args.position_bits {
        stream = stream.with_position_bits(bits);
    }
    stream.check().map_err(|error| error.to_string())?;
    let options = pack::Options::default().with_stream(stream).with_verify(!args.no_verify);
    let options = options.with_eye(args.eye.map(|VectorArg(eye)| eye));
    Ok(PackTask { jobs, options })
}

pub(super) fn unpack_task(args: UnpackArgs) -> Result<UnpackTask, String> {
    let goal = match (args.level, args.triangles, args.bytes) {
        (Some(level), ..) => StreamGoal::Level(level),
        (_, Some(triangles), _) => StreamGoal::Triangles(triangles),
        (.., Some(bytes)) => StreamGoal::Bytes(bytes),
        _ => StreamGoal::Level(Level::Percent(100.0)),
    };
    let verify = !args.target.no_verify;
    let output = OutputArgs { target: args.target, layout: Some(Layout::List) };
    let jobs = jobs_to(inputs(vec![args.input], None)?, &output, None)?;
    let job = jobs.into_iter().next().ok_or("found no input, expected one")?;
    Ok(UnpackTask { job, goal, verify })
}

pub(super) fn inspect_task(args: InspectArgs) -> Result<InspectTask, String> {
    let inputs = inputs_of(args.general)?;
    if let Some(path) = &args.plot {
        check_chart("--plot", path, inputs.len())?;
    }
    Ok(InspectTask { inputs, chunks: args.chunks, plot: args.plot })
}
