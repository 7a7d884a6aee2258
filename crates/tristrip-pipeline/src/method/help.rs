//! The help of methods and their parameters, built from the same table as the parser.

use tristrip::{Method, StripifyOptions};

use super::parameters::{AcceptedValues, PARAMETERS, Parameter, parameters_of};

/// The width of the text.
const WIDTH: usize = 100;
/// The column at which descriptions begin.
const INDENT: usize = 18;

/// Returns the help of all methods and their parameters, wrapped at 100 columns.
///
/// ```
/// let help = tristrip_pipeline::method_help();
/// assert!(help.contains("stripe-global") && help.contains("patches=rows"));
/// ```
pub fn method_help() -> String {
    let mut text = String::from("Methods:\n");
    for method in Method::ALL {
        let options = StripifyOptions::default().with_method(*method);
        let is_default = options == StripifyOptions::default();
        let default = if is_default { " The default." } else { "" };
        let alias = if *method == Method::STRIPE {
            " With its defaults it is STRIPE as its authors recommend it: `stripe` is another name for it."
        } else {
            ""
        };
        entry(&mut text, 2, method.name(), &format!("{}.{default}{alias}", method.summary()));
        let parameters = parameters_of(&options).into_iter();
        let parameters: Vec<String> =
            parameters.map(|(parameter, value)| format!("{}={value}", parameter.name)).collect();
        let parameters =
            if parameters.is_empty() { "No parameters.".to_owned() } else { parameters.join(", ") };
        entry(&mut text, 2, "", &parameters);
    }
    text.push_str("\nParameters:\n");
    for parameter in &PARAMETERS {
        let of = Method::ALL
            .iter()
            .filter(|method| (parameter.get)(&StripifyOptions::default().with_method(**method)).is_some());
        let of: Vec<&str> = of.map(|method| method.name()).collect();
        entry(&mut text, 2, parameter.name, &format!("{} Used by {}.", parameter.help, of.join(", ")));
        match parameter.values {
            AcceptedValues::Named(values) => {
                for (name, summary) in values() {
                    entry(&mut text, 4, name, summary);
                }
            }
            AcceptedValues::Other(values) => entry(&mut text, 2, "", &format!("VALUE: {values}.")),
        }
    }
    text
}

/// Appends a name with a wrapped description next to it.
fn entry(text: &mut String, indent: usize, name: &str, words: &str) {
    let mut line = format!("{:indent$}{name}", "");
    let mut column = INDENT.max(line.chars().count() + 1);
    for word in words.split_whitespace() {
        if column + word.chars().count() > WIDTH {
            text.push_str(line.trim_end());
            text.push('\n');
            line.clear();
            column = INDENT;
        }
        line = format!("{line:column$}{word}");
        column = line.chars().count() + 1;
    }
    text.push_str(line.trim_end());
    text.push('\n');
}

impl Parameter {
    /// Returns the names of the values, or nothing if the values have no names.
    #[cfg(test)]
    pub(crate) fn value_names(&self) -> Vec<&'static str> {
        match self.values {
            AcceptedValues::Named(values) => values().into_iter().map(|(name, _)| name).collect(),
            AcceptedValues::Other(_) => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_names_all_methods_parameters_and_values_in_short_lines() {
        let text = method_help();
        for line in text.lines() {
            assert!(line.chars().count() <= WIDTH && line.trim_end() == line, "{line}");
        }
        let has = |name: &str| text.lines().any(|line| line.split_whitespace().next() == Some(name));
        assert!(Method::ALL.iter().all(|method| has(method.name())));
        for parameter in &PARAMETERS {
            assert!(has(parameter.name), "{}", parameter.name);
            assert!(parameter.value_names().into_iter().all(has), "{}", parameter.name);
        }
    }
}
