//! The methods' names and options: what a user types, what the library takes, and what reports say.

use clap::{Args, ValueEnum};
use serde::Serialize;
use tristrip::{FaceTriangulation, Method, Options, Patches, Ties};

use crate::text::counted;

/// A method by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    /// The cheaper of sequential and input.
    Auto,
    /// Fast, few indices: cheapest runs first, swaps only where they beat a restart.
    Sequential,
    /// The input's own order as strips.
    Input,
    /// The SGI algorithm: least adjacency, one level of look-ahead.
    Sgi,
    /// STRIPE as its authors recommend it: stripe-global by rows, cut-off 5.
    Stripe,
    /// STRIPE's local algorithms.
    StripeLocal,
    /// STRIPE's global algorithms: patches of quadrilaterals first, the rest locally.
    StripeGlobal,
}

/// When STRIPE cuts polygons, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TriangulationName {
    /// Before, by alternate left and right turns.
    Static,
    /// Wholly, when a strip enters the face.
    Whole,
    /// Only as far as the strip needs to leave the face.
    Partial,
}

/// How STRIPE breaks ties, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TiesName {
    /// The first found.
    Arbitrary,
    /// The one whose neighbours have the least adjacency.
    LookAhead,
    /// The one on the other side than last time.
    Alternate,
    /// One at random, by the seed.
    Random,
    /// One that needs no swap, else one at random.
    Sequential,
}

/// How STRIPE's patches become strips, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PatchesName {
    /// A strip for each row or column.
    Rows,
    /// A strip for each patch, extended both ways.
    Full,
}

/// The flags that choose how strips are found.
#[derive(Debug, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodArgs {
    /// How strips are found
    ///
    /// The default takes the cheaper of `sequential` and `input` for each part, so that the result is never worse than what you
    /// had. The others are published algorithms, mostly of interest for comparison; `tristrip compare` shows them side by side.
    #[arg(short, long, value_enum, default_value_t = MethodName::Auto, value_name = "METHOD")]
    method: MethodName,
    /// When stripe-local cuts polygons into triangles [default: whole]
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = false)]
    triangulation: Option<TriangulationName>,
    /// Which of several equally good neighbours stripe-local takes [default: sequential]
    #[arg(long, value_enum, value_name = "RULE")]
    ties: Option<TiesName>,
    /// How stripe-global makes strips of patches [default: rows]
    #[arg(long, value_enum, value_name = "HOW")]
    patches: Option<PatchesName>,
    /// The smallest patch of stripe-global, in quadrilaterals [default: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cutoff: Option<u32>,
    /// The seed of the stripe methods, which break ties at random [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Let vertices with the same bits in position and all attributes count as one
    ///
    /// Strips then pass over the seam between them. Vertices that differ in any attribute, such as a normal or a texture coordinate,
    /// stay apart. Welding saves indices, never vertices: the vertex buffer is written as it was.
    #[arg(long)]
    weld: bool,
}

impl MethodArgs {
    /// Makes options of the flags.
    ///
    /// # Errors
    /// A flag belongs to another method.
    pub(crate) fn validate(&self) -> Result<Options, String> {
        use MethodName::{Auto, Input, Sequential, Sgi, Stripe, StripeGlobal, StripeLocal};
        let local = self.method == StripeLocal;
        let global = matches!(self.method, Stripe | StripeGlobal);
        let belongs = |flag: &str, given: bool, fits: bool, home: &str| {
            if given && !fits {
                return Err(format!("{flag} belongs to --method {home}, not to {}", name(self.method)));
            }
            Ok(())
        };
        belongs("--triangulation", self.triangulation.is_some(), local, "stripe-local")?;
        belongs("--ties", self.ties.is_some(), local, "stripe-local")?;
        belongs("--patches", self.patches.is_some(), global, "stripe-global")?;
        belongs("--cutoff", self.cutoff.is_some(), global, "stripe-global")?;
        belongs("--seed", self.seed.is_some(), local || global, "stripe-local or stripe-global")?;
        let method = match self.method {
            Auto => Method::Auto,
            Sequential => Method::Sequential,
            Input => Method::Input,
            Sgi => Method::Sgi,
            StripeLocal => Method::StripeLocal {
                triangulation: self.triangulation.map(Into::into).unwrap_or_default(),
                ties: self.ties.map(Into::into).unwrap_or_default(),
            },
            Stripe | StripeGlobal => Method::StripeGlobal {
                patches: self.patches.map(Into::into).unwrap_or_default(),
                cutoff: self.cutoff.unwrap_or(5),
            },
        };
        Ok(Options::default().with_method(method).with_weld(self.weld).with_seed(self.seed.unwrap_or(0)))
    }
}

impl From<TriangulationName> for FaceTriangulation {
    fn from(name: TriangulationName) -> Self {
        match name {
            TriangulationName::Static => Self::Static,
            TriangulationName::Whole => Self::Whole,
            TriangulationName::Partial => Self::Partial,
        }
    }
}

impl From<TiesName> for Ties {
    fn from(name: TiesName) -> Self {
        match name {
            TiesName::Arbitrary => Self::Arbitrary,
            TiesName::LookAhead => Self::LookAhead,
            TiesName::Alternate => Self::Alternate,
            TiesName::Random => Self::Random,
            TiesName::Sequential => Self::Sequential,
        }
    }
}

impl From<PatchesName> for Patches {
    fn from(name: PatchesName) -> Self {
        match name {
            PatchesName::Rows => Self::Rows,
            PatchesName::Full => Self::Full,
        }
    }
}

/// Gives the name of a value as it is typed.
fn name<E: ValueEnum + Copy>(value: E) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

/// A method as reports name it: the words of the command line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct MethodReport {
    method: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangulation: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ties: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    patches: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cutoff: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
}

impl MethodReport {
    pub(crate) fn of(options: &Options) -> Self {
        let plain = |method| Self {
            method: name(method),
            triangulation: None,
            ties: None,
            patches: None,
            cutoff: None,
            seed: None,
        };
        match options.method() {
            Method::Sequential => plain(MethodName::Sequential),
            Method::Input => plain(MethodName::Input),
            Method::Sgi => plain(MethodName::Sgi),
            Method::StripeLocal { triangulation, ties } => Self {
                triangulation: TriangulationName::value_variants()
                    .iter()
                    .find(|&&n| FaceTriangulation::from(n) == triangulation)
                    .map(|&n| name(n)),
                ties: TiesName::value_variants().iter().find(|&&n| Ties::from(n) == ties).map(|&n| name(n)),
                seed: Some(options.seed()),
                ..plain(MethodName::StripeLocal)
            },
            Method::StripeGlobal { patches, cutoff } => Self {
                patches: PatchesName::value_variants()
                    .iter()
                    .find(|&&n| Patches::from(n) == patches)
                    .map(|&n| name(n)),
                cutoff: Some(cutoff),
                seed: Some(options.seed()),
                ..plain(MethodName::StripeGlobal)
            },
            _ => plain(MethodName::Auto),
        }
    }

    /// Says the method and its options in one line: `stripe-local whole sequential`.
    pub(crate) fn label(&self) -> String {
        let cutoff = self.cutoff.map(|n| n.to_string());
        let words =
            [Some(&self.method), self.triangulation.as_ref(), self.ties.as_ref(), self.patches.as_ref()];
        words.into_iter().flatten().chain(cutoff.as_ref()).cloned().collect::<Vec<_>>().join(" ")
    }
}

/// Which methods were taken, by name, with the number of parts of each, in the order of the command line's methods.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Chosen(Vec<(String, usize)>);

impl Chosen {
    pub(crate) fn of(methods: &[Method]) -> Self {
        let mut counts: Vec<(String, usize)> =
            MethodName::value_variants().iter().map(|&method| (name(method), 0)).collect();
        for &method in methods {
            let name = MethodReport::of(&Options::default().with_method(method)).method;
            if let Some((_, count)) = counts.iter_mut().find(|(known, _)| *known == name) {
                *count += 1;
            }
        }
        counts.retain(|(_, count)| *count > 0);
        Self(counts)
    }

    /// Says it in one line: `sequential`, or `sequential for 2 parts, input for 1`.
    pub(crate) fn label(&self) -> String {
        match &self.0[..] {
            [(name, _)] => name.clone(),
            [] => String::new(),
            [(name, count), rest @ ..] => {
                let rest: Vec<String> =
                    rest.iter().map(|(name, count)| format!(", {name} for {count}")).collect();
                format!("{name} for {}{}", counted(*count, "part"), rest.concat())
            }
        }
    }
}

/// An object of names and counts.
impl Serialize for Chosen {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, count)| (name, count)))
    }
}

/// Lists the methods to compare: a few that stand for their families, or every variant.
pub(crate) fn methods_to_compare(every_variant: bool) -> Vec<Method> {
    let mut methods = vec![Method::Auto, Method::Input, Method::Sequential, Method::Sgi];
    let local = |triangulation, ties| Method::StripeLocal { triangulation, ties };
    let global = |patches, cutoff| Method::StripeGlobal { patches, cutoff };
    if every_variant {
        for &triangulation in TriangulationName::value_variants() {
            let ties = TiesName::value_variants().iter();
            methods.extend(ties.map(|&ties| local(triangulation.into(), ties.into())));
        }
        for &patches in PatchesName::value_variants() {
            methods.extend([5, 10, 15, 20, 25].map(|cutoff| global(patches.into(), cutoff)));
        }
    } else {
        methods.extend([
            local(FaceTriangulation::Static, Ties::Sequential),
            local(FaceTriangulation::Whole, Ties::Sequential),
            local(FaceTriangulation::Partial, Ties::Sequential),
            local(FaceTriangulation::Whole, Ties::LookAhead),
            global(Patches::Rows, 5),
            global(Patches::Full, 5),
        ]);
    }
    methods
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn all_variants_are_compared_under_names_of_their_own() {
        let label = |method| MethodReport::of(&Options::default().with_method(method)).label();
        let labels: HashSet<String> = methods_to_compare(true).into_iter().map(label).collect();
        assert_eq!(labels.len(), 4 + 15 + 10);
        assert!(
            labels.contains("stripe-local partial look-ahead") && labels.contains("stripe-global full 25")
        );
        assert!(methods_to_compare(false).into_iter().all(|method| labels.contains(&label(method))));
    }

    #[test]
    fn what_was_chosen_is_counted_by_name() {
        let chosen = Chosen::of(&[Method::Input, Method::Sequential, Method::Input]);
        assert_eq!(chosen.label(), "sequential for 1 part, input for 2");
        assert_eq!(Chosen::of(&[Method::STRIPE; 2]).label(), "stripe-global");
        assert_eq!(Chosen::of(&[]).label(), "");
    }
}
