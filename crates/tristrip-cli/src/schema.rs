//! The JSON Schemas of the reports. The tables of `docs/reports.md` are generated from them.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, json_schema};
use serde_json::Value;
use tristrip_pipeline::{Stage, bound as bounds, compare as comparison};

use crate::clock::{STRIP_SECONDS, SecondsKeys};
use crate::report::Report;
use crate::{
    analyze, bound, build_lod, chain, compare, convert, inspect, level, pack, simplify, strip, unpack, verify,
};

/// Returns the name of each subcommand with the JSON Schema of its report. `serve` and `view` need
/// the feature `serve`.
///
/// ```
/// let schemas = tristrip_cli::report_schemas();
/// let (name, schema) = &schemas[0];
/// assert_eq!((*name, &schema["properties"]["triangles"]["type"]), ("strip", &"integer".into()));
/// ```
pub fn report_schemas() -> Vec<(&'static str, Value)> {
    vec![
        ("strip", of_report::<strip::Stripped>(STRIP_SECONDS)),
        ("simplify", of_report::<simplify::Simplified>(simplify::SECONDS)),
        ("convert", of_report::<convert::Converted>(STRIP_SECONDS)),
        ("chain", of_report::<chain::Chained>(chain::SECONDS)),
        ("level", of_report::<level::Leveled>(level::SECONDS)),
        ("camera-level", of_report::<level::Leveled>(level::SECONDS)),
        ("build-lod", of_report::<build_lod::Built>(build_lod::SECONDS)),
        ("pack", of_report::<pack::Packed>(pack::SECONDS)),
        ("unpack", of_report::<unpack::Unpacked>(unpack::SECONDS)),
        #[cfg(feature = "serve")]
        ("serve", of_report::<crate::serve::Listening>(&[])),
        #[cfg(feature = "serve")]
        ("view", of_report::<crate::view::Shown>(&[])),
        ("analyze", of_report::<analyze::Analyzed>(analyze::SECONDS)),
        ("compare", of_report::<comparison::Outcome>(compare::SECONDS)),
        ("bound", of_report::<bounds::Outcome>(bound::SECONDS)),
        ("inspect", of_report::<inspect::Inspected>(inspect::SECONDS)),
        ("verify", of::<verify::Verified>(verify::SECONDS)),
    ]
}

/// Returns the schema of the report of an input.
fn of_report<O: JsonSchema>(seconds: SecondsKeys) -> Value {
    of::<Report<O>>(seconds)
}

/// Returns the schema of a report with these keys of `seconds`, without references.
fn of<T: JsonSchema>(seconds: SecondsKeys) -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let generator = settings.with(|settings| settings.inline_subschemas = true).into_generator();
    let mut schema = Value::from(generator.into_root_schema_for::<T>());
    if seconds.is_empty() {
        schema["properties"].as_object_mut().and_then(|keys| keys.shift_remove("seconds"));
    } else if let Some(required) = schema["required"].as_array_mut() {
        required.push("seconds".into());
        schema["properties"]["seconds"]["required"] = seconds.iter().map(|(key, _)| *key).collect();
    }
    for (key, stages) in seconds {
        let times: Vec<&str> = stages.iter().copied().map(time_of).collect();
        let (last, others) = times.split_last().map_or(("", &times[..]), |(last, others)| (*last, others));
        let and = if others.is_empty() { "" } else { " and " };
        let description = format!("The time to {}{and}{last}.", others.join(", "));
        let time = json_schema!({ "type": ["number", "null"], "description": description });
        schema["properties"]["seconds"]["properties"][key] = time.into();
    }
    schema
}

/// Returns what is done in a stage.
fn time_of(stage: Stage) -> &'static str {
    match stage {
        Stage::Load => "read the input",
        Stage::Decode => "decode the stream",
        Stage::Analyze => "count indices and simulate vertex caches",
        Stage::Prepare => "prepare the faces and build the dual graph",
        Stage::Stripify => "build the strips",
        Stage::Bound => "compute the lower bounds",
        Stage::Prove => "verify the result",
        Stage::ReadBack => "check the written file",
        Stage::Simplify => "collapse half-edges",
        Stage::Rebuild => "remove unused vertices",
        Stage::Fit => "move vertices closer to the original surface",
        Stage::Compare => "measure the distance to the original",
        Stage::Filter => "build the display strips",
        Stage::Reorder => "reorder vertices",
        Stage::Encode => "encode the model",
        Stage::Write => "write the file",
        _ => "run other stages",
    }
}
