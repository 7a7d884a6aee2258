//! The names of methods and their options: what reports, tables and charts call them.

use std::str::FromStr;

use serde::Serialize;
use tristrip::Effort;
use tristrip::simplify::Price;
use tristrip::stripify::{Acceptance, Localization, TunnelOptions};
use tristrip::stripify::{LastTie, Ties};
use tristrip::{Error, Method, StripifyOptions};

/// A method and its options in the words of the command line; the keys are those of the JSON report.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct MethodReport {
    method: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangulation: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ties: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    last_tie: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    patches: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cutoff: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cost: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertex_cache: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    objective: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    effort: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tunnel_length: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    threshold: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    acceptance: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    localization: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
}

impl MethodReport {
    /// Names a method and those of its options that apply to it.
    ///
    /// ```
    /// use tristrip_pipeline::MethodReport;
    /// assert_eq!(MethodReport::of(&tristrip::StripifyOptions::default()).label(), "best restart 2");
    /// ```
    pub fn of(options: &StripifyOptions) -> Self {
        let plain = Self { method: options.method.to_string(), ..Self::default() };
        let seeded = Self { seed: Some(options.seed), ..plain.clone() };
        let search = Self { effort: Some(options.effort_or_default().level()), ..seeded.clone() };
        match options.method {
            Method::StripeLocal { triangulation, ties } => Self {
                triangulation: Some(triangulation.to_string()),
                ties: Some(ties.to_string()),
                ..seeded
            },
            Method::StripeGlobal { patches, cutoff, ties } => Self {
                patches: Some(patches.to_string()),
                cutoff: Some(cutoff),
                ties: Some(ties.to_string()),
                ..seeded
            },
            Method::QuadRows { cutoff } => Self { cutoff: Some(cutoff), ..seeded },
            Method::Sgi { last_tie } => Self { last_tie: Some(last_tie.to_string()), ..plain },
            Method::Best => Self { cost: Some(options.cost.to_string()), ..search },
            Method::Fewest => search,
            Method::Cache => Self {
                vertex_cache: Some(options.vertex_cache.to_string()),
                objective: Some(options.objective.to_string()),
                ..search
            },
            Method::Tunnel { length } => Self { tunnel_length: Some(length), ..plain },
            Method::Eta { tunnels, acceptance, localization } => Self {
                acceptance: Some(acceptance.to_string()),
                localization: Some(localization.to_string()),
                ..seeded.with_tunnels(tunnels)
            },
            Method::GuidedTunnels(tunnels) => seeded.with_tunnels(tunnels),
            _ => plain,
        }
    }

    fn with_tunnels(self, tunnels: TunnelOptions) -> Self {
        Self {
            tunnel_length: Some(tunnels.length),
            threshold: Some(tunnels.threshold),
            start: Some(tunnels.start.to_string()),
            ..self
        }
    }

    /// Returns the name of the method.
    pub fn method(&self) -> &str {
        &self.method
    }

    /// Returns the objective of `cache`; `None` for other methods.
    pub fn objective(&self) -> Option<&str> {
        self.objective.as_deref()
    }

    /// Returns the effort; `None` for methods that do not search.
    pub fn effort(&self) -> Option<u8> {
        self.effort
    }

    /// Returns a short name of the method and its options: `stripe-local whole sequential`. The ties of `stripe-global` and `sgi`,
    /// and acceptance and localization of `eta`, are named where they are not the default.
    pub fn label(&self) -> String {
        let shown = |ties: &Option<String>, usual: &str| ties.clone().filter(|ties| ties != usual);
        let ties = match self.method.as_str() {
            "stripe-local" => self.ties.clone(),
            _ => shown(&self.ties, Ties::default().name()),
        };
        let words = [
            &self.triangulation,
            &ties,
            &shown(&self.last_tie, LastTie::default().name()),
            &self.patches,
            &self.cost,
            &self.vertex_cache,
            &self.objective,
            &self.start,
            &shown(&self.acceptance, Acceptance::default().name()),
            &shown(&self.localization, Localization::default().name())
                .map(|name| format!("localization {name}")),
        ];
        let numbers = [self.cutoff, self.effort.map(u32::from), self.tunnel_length];
        let words = [Some(self.method.clone())].into_iter().chain(words.into_iter().cloned()).flatten();
        let numbers = numbers.into_iter().flatten().map(|n| n.to_string());
        words.chain(numbers).collect::<Vec<_>>().join(" ")
    }

    /// Describes the method and its options: `method best, cost restart, effort 2`.
    pub fn description(&self) -> String {
        let number = |n: Option<u32>| n.map(|n| n.to_string());
        let options = [
            ("triangulation", self.triangulation.clone()),
            ("ties", self.ties.clone()),
            ("last tie", self.last_tie.clone()),
            ("patches", self.patches.clone()),
            ("cutoff", number(self.cutoff)),
            ("cost", self.cost.clone()),
            ("vertex cache", self.vertex_cache.clone()),
            ("objective", self.objective.clone()),
            ("effort", number(self.effort.map(u32::from))),
            ("tunnel length", number(self.tunnel_length)),
            ("threshold", number(self.threshold)),
            ("start", self.start.clone()),
            ("acceptance", self.acceptance.clone()),
            ("localization", self.localization.clone()),
        ];
        let options = options.into_iter().filter_map(|(name, value)| Some(format!("{name} {}", value?)));
        std::iter::once(format!("method {}", self.method)).chain(options).collect::<Vec<_>>().join(", ")
    }
}

/// Parses a method and its options in the flags of the command: `--method eta --start input`. Flags that are not given have the default of
/// the method.
///
/// # Errors
/// A flag is unknown, has an unknown value, or belongs to another method.
///
/// ```
/// use tristrip_pipeline::{MethodReport, parse_method};
/// let options = parse_method("--method stripe-local --ties random")?;
/// assert_eq!(MethodReport::of(&options).label(), "stripe-local whole random");
/// assert!(parse_method("--method sgi --start input").is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn parse_method(flags: &str) -> Result<StripifyOptions, Error> {
    Flags::of(flags)?.all_options()
}

/// Reads a method and its options from flags and their values, as [`parse_method`] does.
///
/// # Errors
/// As of [`parse_method`].
///
/// ```
/// use tristrip_pipeline::{MethodReport, method_of_flags};
/// let options = method_of_flags(&[("--method", "cache"), ("--vertex-cache", "fifo 24")]);
/// assert!(options.is_err(), "a vertex cache is written `fifo:24`");
/// let options = method_of_flags(&[("--method", "best"), ("--effort", "3")])?;
/// assert_eq!(MethodReport::of(&options).effort(), Some(3));
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn method_of_flags(flags: &[(&str, &str)]) -> Result<StripifyOptions, Error> {
    Flags(flags.to_vec()).all_options()
}

/// Parses the flags of a method, and `--price` of collapses.
pub(crate) fn parse_with_price(flags: &str) -> Result<(StripifyOptions, Price), Error> {
    let mut flags = Flags::of(flags)?;
    let price = flags.named("--price")?.unwrap_or_default();
    Ok((flags.all_options()?, price))
}

/// Flags that are not used yet, with their values.
struct Flags<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Flags<'a> {
    fn of(text: &'a str) -> Result<Self, Error> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let (pairs, rest) = words.as_chunks();
        match rest {
            [] => Ok(Self(pairs.iter().map(|&[flag, value]| (flag, value)).collect())),
            _ => Err(invalid("flags", text, "pairs of a flag and a value")),
        }
    }

    /// Removes a flag, and returns its value.
    fn take(&mut self, flag: &str) -> Option<&'a str> {
        let at = self.0.iter().position(|(name, _)| *name == flag)?;
        Some(self.0.remove(at).1)
    }

    fn number<T: FromStr>(&mut self, flag: &'static str) -> Result<Option<T>, Error> {
        let number =
            |text: &str| text.parse().map_err(|_| invalid(flag, text, "a whole number of 0 or more"));
        self.take(flag).map(number).transpose()
    }

    fn named<T: FromStr<Err = Error>>(&mut self, flag: &str) -> Result<Option<T>, Error> {
        self.take(flag).map(str::parse).transpose()
    }

    /// Returns the options of the method, to which all flags that are left belong.
    fn all_options(&mut self) -> Result<StripifyOptions, Error> {
        let options = self.options()?;
        match self.0.first() {
            None => Ok(options),
            Some((flag, _)) => Err(invalid("flag", flag, "a flag that belongs to the method")),
        }
    }

    fn options(&mut self) -> Result<StripifyOptions, Error> {
        let name = self.take("--method").unwrap_or("best");
        let method = self.method(name)?;
        let mut options = StripifyOptions::default().with_method(method);
        if name == "best"
            && let Some(cost) = self.named("--cost")?
        {
            options = options.with_cost(cost);
        }
        if name == "cache" {
            if let Some(objective) = self.named("--objective")? {
                options = options.with_objective(objective);
            }
            if let Some(cache) = self.named("--vertex-cache")? {
                options = options.with_vertex_cache(cache);
            }
        }
        if matches!(name, "best" | "fewest" | "cache")
            && let Some(text) = self.take("--effort")
        {
            let effort = text.parse().ok().and_then(Effort::new);
            options = options.with_effort(effort.ok_or_else(|| invalid("--effort", text, "0 to 9"))?);
        }
        if !matches!(name, "sequential" | "input" | "sgi" | "tunnel")
            && let Some(seed) = self.number("--seed")?
        {
            options = options.with_seed(seed);
        }
        Ok(options)
    }

    fn method(&mut self, name: &str) -> Result<Method, Error> {
        Ok(match name.parse()? {
            Method::StripeLocal { triangulation, ties } => Method::StripeLocal {
                triangulation: self.named("--triangulation")?.unwrap_or(triangulation),
                ties: self.named("--ties")?.unwrap_or(ties),
            },
            Method::StripeGlobal { patches, cutoff, ties } => Method::StripeGlobal {
                patches: self.named("--patches")?.unwrap_or(patches),
                cutoff: self.number("--cutoff")?.unwrap_or(cutoff),
                ties: self.named("--ties")?.unwrap_or(ties),
            },
            Method::QuadRows { cutoff } => {
                Method::QuadRows { cutoff: self.number("--cutoff")?.unwrap_or(cutoff) }
            }
            Method::Sgi { last_tie } => {
                Method::Sgi { last_tie: self.named("--last-tie")?.unwrap_or(last_tie) }
            }
            Method::Tunnel { length } => {
                Method::Tunnel { length: self.number("--tunnel-length")?.unwrap_or(length) }
            }
            Method::Eta { tunnels, acceptance, localization } => Method::Eta {
                tunnels: self.tunnels(tunnels)?,
                acceptance: self.named("--acceptance")?.unwrap_or(acceptance),
                localization: self.named("--localization")?.unwrap_or(localization),
            },
            Method::GuidedTunnels(tunnels) => Method::GuidedTunnels(self.tunnels(tunnels)?),
            method => method,
        })
    }

    fn tunnels(&mut self, mut tunnels: TunnelOptions) -> Result<TunnelOptions, Error> {
        if let Some(length) = self.number("--tunnel-length")? {
            tunnels = tunnels.with_length(length);
        }
        if let Some(threshold) = self.number("--threshold")? {
            tunnels = tunnels.with_threshold(threshold);
        }
        if let Some(start) = self.named("--start")? {
            tunnels = tunnels.with_start(start);
        }
        Ok(tunnels)
    }
}

fn invalid(name: &'static str, found: &str, expected: &'static str) -> Error {
    Error::Parameter { name, found: found.into(), expected }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_names_the_options() {
        let best = MethodReport::of(&StripifyOptions::default());
        assert_eq!(best.description(), "method best, cost restart, effort 2");
        let local = StripifyOptions::default().with_method(Method::STRIPE);
        assert_eq!(
            MethodReport::of(&local).description(),
            "method stripe-global, ties sequential, patches rows, cutoff 5"
        );
    }
}
