//! The flags that choose how strips are built.

use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::error::ErrorKind;
use tristrip::Effort;
use tristrip::{Method, StripifyOptions};
use tristrip_pipeline::parse_method;

use crate::values::effort_parser;

#[derive(Debug, Args)]
pub(crate) struct WeldArgs {
    /// Merge vertices whose position and attributes are bit-identical
    ///
    /// Strips can then cross the seams between these vertices. Welding saves indices, not vertices:
    /// the vertex buffer is written unchanged.
    #[arg(long, hide_short_help = true)]
    pub(crate) weld: bool,
}

/// The flags that choose the method and its options.
#[derive(Debug, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodArgs {
    /// Use this method: NAME or NAME:PARAMETER=VALUE,... [default: best]
    ///
    /// The default is never worse than the input. Most other methods are published algorithms.
    /// `tristrip help methods` describes all methods and parameters; `tristrip compare` measures
    /// them on your model.
    #[arg(short, long, value_parser = MethodParser, value_name = "METHOD", hide_possible_values = true)]
    method: Option<NamedMethod>,
    /// Set the search effort of the method, from 0 to 9 [default: 2; for fewest 5]
    ///
    /// A higher effort of best, fewest or cache gives fewer indices and takes longer. `tristrip
    /// help methods` lists typical times.
    #[arg(long, value_name = "LEVEL", value_parser = effort_parser())]
    effort: Option<Effort>,
    /// Stop each search after this time, such as 5s or 500ms, and keep its best result
    ///
    /// Results with a budget can differ between runs; results with --effort do not. The budget
    /// applies to each input. The methods best, fewest, cache, tunnel, eta and guided-tunnels
    /// support it.
    #[arg(long, hide_short_help = true, value_name = "TIME", value_parser = humantime::parse_duration)]
    budget: Option<Duration>,
    #[command(flatten)]
    weld: WeldArgs,
}

/// A method with parameters as typed.
#[derive(Debug, Clone, Copy, Default)]
struct NamedMethod {
    options: StripifyOptions,
    /// Whether `effort` is one of the parameters.
    has_effort: bool,
}

/// Parses a method with parameters. Shells complete the method names.
#[derive(Debug, Clone)]
struct MethodParser;

impl TypedValueParser for MethodParser {
    type Value = NamedMethod;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<NamedMethod, clap::Error> {
        let text = StringValueParser::new().parse_ref(command, argument, value)?;
        match parse_method(&text) {
            Ok(options) => Ok(NamedMethod { options, has_effort: text.contains("effort=") }),
            Err(error) => {
                let flag = argument.map(ToString::to_string).unwrap_or_default();
                let hint = "`tristrip help methods` describes all methods and parameters";
                let message = format!("invalid value for '{flag}': {error}\n{hint}");
                Err(command.clone().error(ErrorKind::ValueValidation, message))
            }
        }
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let names = Method::ALL.iter().map(|method| PossibleValue::new(method.name()).help(method.summary()));
        let stripe = PossibleValue::new("stripe").help("STRIPE as its authors recommend it");
        Some(Box::new(names.chain([stripe])))
    }
}

impl MethodArgs {
    /// Selects the method `cache` unless another one is named. Strips save nothing in triangle
    /// lists, but the order of the triangles matters.
    pub(crate) fn for_lists(self) -> Self {
        let cache = StripifyOptions::default().with_method(Method::Cache);
        let cache = NamedMethod { options: cache, has_effort: false };
        Self { method: self.method.or(Some(cache)), ..self }
    }

    /// Builds the options.
    ///
    /// # Errors
    /// A flag does not apply to the method.
    pub(crate) fn validate(&self) -> Result<StripifyOptions, String> {
        let named = self.method.unwrap_or_default();
        let method = named.options.method;
        let searches = matches!(method, Method::Best | Method::Fewest | Method::Cache);
        let tunnels = matches!(method, Method::Tunnel { .. } | Method::Eta { .. } | Method::GuidedTunnels(_));
        if self.effort.is_some() && !searches {
            return Err(format!("--effort applies to the methods best, fewest and cache, not to {method}"));
        }
        if self.effort.is_some() && named.has_effort {
            return Err("--effort cannot be used with the parameter effort of --method".into());
        }
        if self.budget.is_some() && !searches && !tunnels {
            let methods = "best, fewest, cache, tunnel, eta and guided-tunnels";
            return Err(format!("--budget applies to the methods {methods}, not to {method}"));
        }
        let options = named.options.with_weld(self.weld.weld);
        Ok(self.effort.map_or(options, |effort| options.with_effort(effort)))
    }

    /// Returns the time limit of a search.
    pub(crate) fn budget(&self) -> Option<Duration> {
        self.budget
    }
}
