//! Parses methods with their parameters, and names them in reports, tables, charts and help.

mod help;
mod parameters;
#[cfg(feature = "schema")]
mod schema;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use tristrip::{Method, StripifyOptions};

pub use help::method_help;
use parameters::{Value, parameters_of};
pub use parameters::{parse_method, with_method_parameter};

/// A method and its parameters. The JSON report contains the method, and one key per parameter.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MethodDescription {
    method: &'static str,
    parameters: Vec<ReportedParameter>,
}

#[derive(Debug, Clone, PartialEq)]
struct ReportedParameter {
    name: &'static str,
    value: Value,
    is_default: bool,
}

impl Serialize for MethodDescription {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1 + self.parameters.len()))?;
        map.serialize_entry("method", self.method)?;
        for parameter in &self.parameters {
            map.serialize_entry(&parameter.name.replace('-', "_"), &parameter.value)?;
        }
        map.end()
    }
}

impl MethodDescription {
    /// Describes a method and the options that it uses.
    pub fn of(options: &StripifyOptions) -> Self {
        let method = options.method;
        let default = StripifyOptions::default().with_method(default_of(method));
        let parameters = parameters_of(options).into_iter().map(|(parameter, value)| ReportedParameter {
            name: parameter.name,
            is_default: (parameter.get)(&default).as_ref() == Some(&value),
            value,
        });
        Self { method: method.name(), parameters: parameters.collect() }
    }

    /// Returns the name of the method.
    pub fn method(&self) -> &str {
        self.method
    }

    /// Returns the objective of `cache`; `None` for other methods.
    pub fn objective(&self) -> Option<&str> {
        match self.value("objective") {
            Some(Value::Word(objective)) => Some(objective),
            _ => None,
        }
    }

    /// Returns the effort; `None` for methods that do not search.
    pub fn effort(&self) -> Option<u8> {
        match self.value("effort") {
            Some(Value::Number(effort)) => u8::try_from(*effort).ok(),
            _ => None,
        }
    }

    fn value(&self, name: &str) -> Option<&Value> {
        self.parameters.iter().find(|parameter| parameter.name == name).map(|parameter| &parameter.value)
    }

    /// Returns the method and the parameters that differ from its defaults, in the syntax of
    /// [`parse_method`].
    ///
    /// ```
    /// use tristrip_pipeline::{MethodDescription, parse_method};
    /// let options = parse_method("best:cost=gl,effort=2")?; // 2 is the default
    /// assert_eq!(MethodDescription::of(&options).label(), "best:cost=gl");
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn label(&self) -> String {
        let set = self.parameters.iter().filter(|parameter| !parameter.is_default);
        let set: Vec<String> =
            set.map(|parameter| format!("{}={}", parameter.name, parameter.value)).collect();
        if set.is_empty() { self.method.into() } else { format!("{}:{}", self.method, set.join(",")) }
    }

    /// Describes the method and its parameters without the seed:
    /// `method best, cost restart, effort 2`.
    pub fn description(&self) -> String {
        let parameters = self.parameters.iter().filter(|parameter| parameter.name != "seed");
        let parameters =
            parameters.map(|parameter| format!(", {} {}", parameter.name.replace('-', " "), parameter.value));
        format!("method {}{}", self.method, parameters.collect::<String>())
    }
}

/// Returns the method of the same name with the default values of its parameters.
fn default_of(method: Method) -> Method {
    Method::ALL.iter().copied().find(|other| other.name() == method.name()).unwrap_or(method)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_names_the_parameters() {
        let best = MethodDescription::of(&StripifyOptions::default());
        assert_eq!(best.description(), "method best, cost restart, effort 2");
        let stripe = StripifyOptions::default().with_method(Method::STRIPE);
        let description = "method stripe-global, ties sequential, patches rows, cutoff 5";
        assert_eq!(MethodDescription::of(&stripe).description(), description);
    }

    /// Every parameter value of every method is the same in its text, its label and its report.
    #[test]
    fn labels_and_reports_have_the_values_that_were_parsed() {
        for method in Method::ALL {
            let default = StripifyOptions::default().with_method(*method);
            assert_eq!(parse_method(method.name()), Ok(default));
            for (parameter, _) in parameters_of(&default) {
                let names = parameter.value_names();
                let values = if names.is_empty() { vec!["7", "lru:24"] } else { names };
                for value in values {
                    let text = format!("{method}:{}={value}", parameter.name);
                    let Ok(options) = parse_method(&text) else {
                        assert_eq!(value == "7", parameter.name == "vertex-cache", "{text}");
                        continue;
                    };
                    assert_eq!((parameter.get)(&options).unwrap().to_string(), value, "{text}");
                    let report = MethodDescription::of(&options);
                    assert_eq!(parse_method(&report.label()), Ok(options), "{text}");
                    let json = serde_json::to_value(&report).unwrap();
                    let found = json[parameter.name.replace('-', "_")].to_string();
                    assert_eq!(found.trim_matches('"'), value, "{text}");
                    let others = |options| {
                        let all = parameters_of(&options).into_iter();
                        all.filter(|(other, _)| other.name != parameter.name)
                            .map(|(other, value)| (other.name, value))
                            .collect::<Vec<_>>()
                    };
                    assert_eq!(others(options), others(default), "{text} changes only its parameter");
                }
            }
        }
        assert_eq!(
            parse_method("stripe"),
            parse_method("stripe-global:patches=rows,cutoff=5,ties=sequential")
        );
    }

    #[test]
    fn errors_name_the_method_the_parameter_and_the_values() {
        for (text, message) in [
            ("magic", "parameter `method`: found `magic`, expected best, sequential"),
            ("sgi:start=input", "found `start` in `sgi:start=input`, expected the parameter last-tie"),
            ("input:seed=1", "found `seed` in `input:seed=1`, expected no parameters for input"),
            (
                "stripe:colour=red",
                "found `colour` in `stripe:colour=red`, expected one of the parameters ties, patches, cutoff and seed",
            ),
            (
                "stripe:patches=some",
                "parameter `patches`: found `some` in `stripe:patches=some`, expected one of: rows, full",
            ),
            ("stripe:cutoff=0", "found `0` in `stripe:cutoff=0`, expected an integer of at least 1"),
            ("best:effort=10", "found `10` in `best:effort=10`, expected an integer from 0 to 9"),
            ("best:seed=-1", "expected an integer of at least 0"),
            ("cache:vertex-cache=fifo:0", "`fifo:N` or `lru:N`, N from 1 to 65536"),
            ("best:effort", "found `effort` in `best:effort`, expected PARAMETER=VALUE"),
            ("best:", "found `` in `best:`, expected PARAMETER=VALUE"),
            ("best:seed=1,seed=2", "found `seed` twice in `best:seed=1,seed=2`"),
        ] {
            let error = parse_method(text).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
