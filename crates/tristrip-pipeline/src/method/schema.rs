//! The JSON Schema of a method in a report, built from the same table as the parser.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use tristrip::{Method, StripifyOptions};

use super::MethodDescription;
use super::parameters::{AcceptedValues, PARAMETERS, Parameter, Value};

impl JsonSchema for MethodDescription {
    fn schema_name() -> Cow<'static, str> {
        "MethodDescription".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names: Vec<&str> = Method::ALL.iter().map(|method| method.name()).collect();
        let method = json_schema!({
            "type": "string",
            "enum": names,
            "description": "The method that builds the strips.",
        });
        let mut schema = json_schema!({ "type": "object", "properties": {}, "required": ["method"] });
        if let Some(properties) = schema.pointer_mut("/properties").and_then(|value| value.as_object_mut()) {
            properties.insert("method".into(), method.into());
            for parameter in &PARAMETERS {
                properties.insert(parameter.name.replace('-', "_"), of_parameter(parameter).into());
            }
        }
        schema
    }
}

/// Builds the schema of a parameter: the first sentence of its help, its values, and the methods
/// that have it.
fn of_parameter(parameter: &Parameter) -> Schema {
    let value_of = |method: &Method| (parameter.get)(&StripifyOptions::default().with_method(*method));
    let methods = Method::ALL.iter().filter(|method| value_of(method).is_some());
    let methods: Vec<String> = methods.map(|method| format!("`{method}`")).collect();
    let methods = match methods.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => methods.concat(),
    };
    let help = parameter.help.split(['.', ';']).next().unwrap_or_default();
    match parameter.values {
        AcceptedValues::Named(values) => {
            let names: Vec<&str> = values().into_iter().map(|(name, _)| name).collect();
            let description = format!("{help}. Only for {methods}.");
            json_schema!({ "type": "string", "enum": names, "description": description })
        }
        AcceptedValues::Other(values) => {
            let is_number = matches!(Method::ALL.iter().find_map(value_of), Some(Value::Number(_)));
            let description = format!("{help}: {values}. Only for {methods}.");
            json_schema!({ "type": if is_number { "integer" } else { "string" }, "description": description })
        }
    }
}
