//! Methods with parameters as text: `stripe-global:patches=full,cutoff=10`. One table defines the
//! parser, the reports and the help.

use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

use serde::Serialize;
use tristrip::stripify::{Acceptance, FaceTriangulation, LastTie, Localization, Objective, Patches};
use tristrip::stripify::{Start, Ties, TunnelOptions};
use tristrip::{Cost, Effort, Error, Method, StripifyOptions};

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(crate) enum Value {
    Word(String),
    Number(u64),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word(word) => f.write_str(word),
            Self::Number(number) => number.fmt(f),
        }
    }
}

/// A parameter of stripification methods.
pub(crate) struct Parameter {
    /// The name on the command line. Reports use `_` instead of `-`.
    pub(crate) name: &'static str,
    /// What the parameter does, in sentences.
    pub(super) help: &'static str,
    /// The accepted values.
    pub(super) values: AcceptedValues,
    /// Returns the value; `None` if the method of the options does not have the parameter.
    pub(crate) get: fn(&StripifyOptions) -> Option<Value>,
    /// Sets the value. The method of the options must have the parameter.
    set: fn(StripifyOptions, &str) -> Result<StripifyOptions, Error>,
}

/// The values that a parameter accepts.
pub(super) enum AcceptedValues {
    /// Named values, each with a line of help.
    Named(fn() -> Vec<(&'static str, &'static str)>),
    /// Any other values, with a description.
    Other(&'static str),
}

/// Returns the names and help lines of an enumeration.
macro_rules! named {
    ($type:ty) => {
        AcceptedValues::Named(|| <$type>::ALL.iter().map(|value| (value.name(), value.summary())).collect())
    };
}

/// All parameters, in the order of reports.
pub(crate) static PARAMETERS: [Parameter; 15] = [
    Parameter {
        name: "triangulation",
        help: "When polygons are triangulated.",
        values: named!(FaceTriangulation),
        get: |options| match options.method {
            Method::StripeLocal { triangulation, .. } => Some(word(triangulation.name())),
            _ => None,
        },
        set: |options, text| {
            let triangulation = text.parse()?;
            Ok(options.with_method(match options.method {
                Method::StripeLocal { ties, .. } => Method::StripeLocal { triangulation, ties },
                other => other,
            }))
        },
    },
    Parameter {
        name: "ties",
        help: "How ties between equally good neighbours are broken.",
        values: named!(Ties),
        get: |options| match options.method {
            Method::StripeLocal { ties, .. } | Method::StripeGlobal { ties, .. } => Some(word(ties.name())),
            _ => None,
        },
        set: |options, text| {
            let ties = text.parse()?;
            Ok(options.with_method(match options.method {
                Method::StripeLocal { triangulation, .. } => Method::StripeLocal { triangulation, ties },
                Method::StripeGlobal { patches, cutoff, .. } => {
                    Method::StripeGlobal { patches, cutoff, ties }
                }
                other => other,
            }))
        },
    },
    Parameter {
        name: "last-tie",
        help: "How ties that remain after the look-ahead are broken.",
        values: named!(LastTie),
        get: |options| match options.method {
            Method::Sgi { last_tie } => Some(word(last_tie.name())),
            _ => None,
        },
        set: |options, text| Ok(options.with_method(Method::Sgi { last_tie: text.parse()? })),
    },
    Parameter {
        name: "patches",
        help: "How patches of quadrilaterals are divided into strips.",
        values: named!(Patches),
        get: |options| match options.method {
            Method::StripeGlobal { patches, .. } => Some(word(patches.name())),
            _ => None,
        },
        set: |options, text| {
            let patches = text.parse()?;
            Ok(options.with_method(match options.method {
                Method::StripeGlobal { cutoff, ties, .. } => Method::StripeGlobal { patches, cutoff, ties },
                other => other,
            }))
        },
    },
    Parameter {
        name: "cutoff",
        help: "The minimum size of a patch, in quadrilaterals.",
        values: AcceptedValues::Other(POSITIVE),
        get: |options| match options.method {
            Method::StripeGlobal { cutoff, .. } | Method::QuadRows { cutoff } => Some(number(cutoff)),
            _ => None,
        },
        set: |options, text| {
            let cutoff = positive("cutoff", text)?;
            Ok(options.with_method(match options.method {
                Method::StripeGlobal { patches, ties, .. } => Method::StripeGlobal { patches, cutoff, ties },
                Method::QuadRows { .. } => Method::QuadRows { cutoff },
                other => other,
            }))
        },
    },
    Parameter {
        name: "cost",
        help: "The cost to minimize. The minimum restart cost gives nearly the minimum cost with degenerate \
               joins, too.",
        values: named!(Cost),
        get: |options| (options.method == Method::Best).then(|| word(options.cost.name())),
        set: |options, text| Ok(options.with_cost(text.parse()?)),
    },
    Parameter {
        name: "vertex-cache",
        help: "The vertex cache to optimize for. Desktop GPUs behave like caches of 16 to 32 entries. The cache is \
               not flushed between strips.",
        values: AcceptedValues::Other("fifo:N or lru:N with N entries"),
        get: |options| (options.method == Method::Cache).then(|| word(&options.vertex_cache)),
        set: |options, text| Ok(options.with_vertex_cache(text.parse()?)),
    },
    Parameter {
        name: "objective",
        help: "The trade-off between indices and cache misses.",
        values: named!(Objective),
        get: |options| (options.method == Method::Cache).then(|| word(options.objective.name())),
        set: |options, text| Ok(options.with_objective(text.parse()?)),
    },
    Parameter {
        name: "effort",
        help: "The search effort; --effort is a shorthand for it. Effort is counted in steps, so the result \
               is the same on every machine. On one core and 70,000 triangles, best takes about 0.01 s at \
               effort 1, 0.04 s at 2, 0.1 s at 3, 0.3 s at 4, 0.6 s at 5, 1.3 s at 6, 2.5 s at 7, 5 s at 8 \
               and 10 s at 9. Above 8,000 triangles, the time is proportional to their number; below, it is \
               constant. fewest stops when it meets its lower bound; otherwise each level doubles its time. \
               cache takes a second per million triangles up to effort 2. From effort 3, it grows strips \
               with several heuristics; for fifo caches of up to 256 entries, it continues with a local \
               search. With objective=indices, it uses the search of best.",
        values: AcceptedValues::Other(EFFORT),
        get: |options| {
            let searches = matches!(options.method, Method::Best | Method::Fewest | Method::Cache);
            searches.then(|| number(options.effort_or_default().level()))
        },
        set: |options, text| {
            let effort = text.parse().ok().and_then(Effort::new);
            let effort = effort.ok_or_else(|| invalid("effort", format!("`{text}`"), EFFORT))?;
            Ok(options.with_effort(effort))
        },
    },
    Parameter {
        name: "tunnel-length",
        help: "The maximum length of a tunnel, in edges of the dual graph.",
        values: AcceptedValues::Other(POSITIVE),
        get: |options| match options.method {
            Method::Tunnel { length } => Some(number(length)),
            method => tunnels(method).map(|tunnels| number(tunnels.length)),
        },
        set: |options, text| {
            let length = positive("tunnel-length", text)?;
            Ok(options.with_method(match options.method {
                Method::Tunnel { .. } => Method::Tunnel { length },
                method => with_tunnels(method, |tunnels| tunnels.with_length(length)),
            }))
        },
    },
    Parameter {
        name: "threshold",
        help: "The maximum number of triangles that a search visits.",
        values: AcceptedValues::Other(POSITIVE),
        get: |options| tunnels(options.method).map(|tunnels| number(tunnels.threshold)),
        set: |options, text| {
            let threshold = positive("threshold", text)?;
            let method = with_tunnels(options.method, |tunnels| tunnels.with_threshold(threshold));
            Ok(options.with_method(method))
        },
    },
    Parameter {
        name: "start",
        help: "The initial strips.",
        values: named!(Start),
        get: |options| tunnels(options.method).map(|tunnels| word(tunnels.start.name())),
        set: |options, text| {
            let start = text.parse()?;
            let method = with_tunnels(options.method, |tunnels| tunnels.with_start(start));
            Ok(options.with_method(method))
        },
    },
    Parameter {
        name: "acceptance",
        help: "Which tunnels are accepted.",
        values: named!(Acceptance),
        get: |options| match options.method {
            Method::Eta { acceptance, .. } => Some(word(acceptance.name())),
            _ => None,
        },
        set: |options, text| {
            let acceptance = text.parse()?;
            Ok(options.with_method(match options.method {
                Method::Eta { tunnels, localization, .. } => {
                    Method::Eta { tunnels, acceptance, localization }
                }
                other => other,
            }))
        },
    },
    Parameter {
        name: "localization",
        help: "How far identifiers are written during a search. All values give the same strips, but take \
               different times.",
        values: named!(Localization),
        get: |options| match options.method {
            Method::Eta { localization, .. } => Some(word(localization.name())),
            _ => None,
        },
        set: |options, text| {
            let localization = text.parse()?;
            Ok(options.with_method(match options.method {
                Method::Eta { tunnels, acceptance, .. } => Method::Eta { tunnels, acceptance, localization },
                other => other,
            }))
        },
    },
    Parameter {
        name: "seed",
        help: "The seed for the random number generator.",
        values: AcceptedValues::Other(NATURAL),
        get: |options| {
            let fixed = matches!(
                options.method,
                Method::Sequential | Method::Input | Method::Sgi { .. } | Method::Tunnel { .. }
            );
            (!fixed).then(|| number(options.seed))
        },
        set: |options, text| {
            let seed = text.parse().map_err(|_| invalid("seed", format!("`{text}`"), NATURAL))?;
            Ok(options.with_seed(seed))
        },
    },
];

const POSITIVE: &str = "an integer of at least 1";
const NATURAL: &str = "an integer of at least 0";
const EFFORT: &str = "an integer from 0 to 9";

fn word(word: &(impl ToString + ?Sized)) -> Value {
    Value::Word(word.to_string())
}

fn number(number: impl Into<u64>) -> Value {
    Value::Number(number.into())
}

fn positive(name: &'static str, text: &str) -> Result<u32, Error> {
    let number = text.parse().ok().filter(|number| *number > 0);
    number.ok_or_else(|| invalid(name, format!("`{text}`"), POSITIVE))
}

fn tunnels(method: Method) -> Option<TunnelOptions> {
    match method {
        Method::Eta { tunnels, .. } | Method::GuidedTunnels(tunnels) => Some(tunnels),
        _ => None,
    }
}

fn with_tunnels(method: Method, change: impl Fn(TunnelOptions) -> TunnelOptions) -> Method {
    match method {
        Method::Eta { tunnels, acceptance, localization } => {
            Method::Eta { tunnels: change(tunnels), acceptance, localization }
        }
        Method::GuidedTunnels(tunnels) => Method::GuidedTunnels(change(tunnels)),
        other => other,
    }
}

fn invalid(name: &'static str, found: String, expected: &'static str) -> Error {
    Error::Parameter { name, found, expected }
}

/// Returns the parameters of the method of the options, with their values.
pub(crate) fn parameters_of(options: &StripifyOptions) -> Vec<(&'static Parameter, Value)> {
    PARAMETERS.iter().filter_map(|p| Some((p, (p.get)(options)?))).collect()
}

/// For each method, what is expected in place of an unknown parameter.
static EXPECTED: LazyLock<Vec<String>> = LazyLock::new(|| {
    Method::ALL
        .iter()
        .map(|method| {
            let options = StripifyOptions::default().with_method(*method);
            let names: Vec<&str> =
                parameters_of(&options).iter().map(|(parameter, _)| parameter.name).collect();
            match names.split_last() {
                None => format!("no parameters for {method}"),
                Some((last, [])) => format!("the parameter {last}"),
                Some((last, others)) => format!("one of the parameters {} and {last}", others.join(", ")),
            }
        })
        .collect()
});

/// Parses a method with its parameters, such as `best`, `best:effort=5` or
/// `stripe-global:patches=full,cutoff=10`. Omitted parameters have the defaults of the method;
/// `tristrip help methods` lists all.
///
/// # Errors
/// The method is unknown, it does not have one of the parameters, or a value is invalid.
///
/// ```
/// use tristrip_pipeline::{MethodDescription, parse_method};
/// let options = parse_method("stripe-local:ties=random,seed=7")?;
/// assert_eq!(MethodDescription::of(&options).label(), "stripe-local:ties=random,seed=7");
/// let error = parse_method("sgi:start=input").unwrap_err();
/// assert_eq!(error.to_string(), "parameter `method`: found `start` in `sgi:start=input`, expected the parameter last-tie");
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn parse_method(text: &str) -> Result<StripifyOptions, Error> {
    let (name, parameters) = match text.split_once(':') {
        Some((name, parameters)) => (name, Some(parameters)),
        None => (text, None),
    };
    let mut options = StripifyOptions::default().with_method(Method::from_str(name)?);
    let mut named: Vec<&str> = Vec::new();
    for pair in parameters.into_iter().flat_map(|parameters| parameters.split(',')) {
        let (parameter, value) = pair
            .split_once('=')
            .ok_or_else(|| invalid("method", format!("`{pair}` in `{text}`"), "PARAMETER=VALUE"))?;
        if named.contains(&parameter) {
            return Err(invalid("method", format!("`{parameter}` twice in `{text}`"), "each parameter once"));
        }
        named.push(parameter);
        options = set(options, parameter, value, text)?;
    }
    Ok(options)
}

/// Sets a parameter of the options' method. The name may use `-` or `_`, and the value has the
/// syntax of [`parse_method`].
///
/// # Errors
/// The method does not have the parameter, or the value is invalid.
///
/// ```
/// use tristrip_pipeline::{parse_method, with_method_parameter};
/// let options = with_method_parameter(parse_method("cache")?, "vertex_cache", "lru:24")?;
/// assert_eq!(options, parse_method("cache:vertex-cache=lru:24")?);
/// assert!(with_method_parameter(options, "cutoff", "5").is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn with_method_parameter(
    options: StripifyOptions,
    name: &str,
    value: &str,
) -> Result<StripifyOptions, Error> {
    let text = format!("{}:{name}={value}", options.method);
    set(options, &name.replace('_', "-"), value, &text)
}

/// Sets a parameter by its name, which `text` contains.
fn set(options: StripifyOptions, name: &str, value: &str, text: &str) -> Result<StripifyOptions, Error> {
    let found = PARAMETERS.iter().find(|parameter| parameter.name == name);
    let Some(parameter) = found.filter(|parameter| (parameter.get)(&options).is_some()) else {
        let at = Method::ALL.iter().position(|method| method.name() == options.method.name());
        let expected = at.map_or("a parameter of the method", |at| EXPECTED[at].as_str());
        return Err(invalid("method", format!("`{name}` in `{text}`"), expected));
    };
    (parameter.set)(options, value).map_err(|error| match error {
        Error::Parameter { found, expected, .. } => {
            invalid(parameter.name, format!("{found} in `{text}`"), expected)
        }
        other => other,
    })
}
