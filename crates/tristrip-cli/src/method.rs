//! Stripification methods and their options: as typed, as the library takes them, and as reports name them.

use std::time::Duration;

use clap::{Args, ValueEnum};
use serde::Serialize;
use tristrip::strip::{Buffer, Cost};
use tristrip::stripify::{Effort, EtaOptions, Prefer, Start};
use tristrip::{FaceTriangulation, Method, Options, Patches, Ties};

use crate::values::{effort_parser, name_of};

/// The default maximum length of a tunnel for `tunnel`: beyond it, every two more edges multiply the time several times.
const TUNNEL_LENGTH: u32 = 9;

/// A method by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    /// The same as best at effort 2: less than a second for a million triangles.
    Auto,
    /// Fast, with few indices: cheapest runs first, swaps only where they cost less than a restart.
    Sequential,
    /// A search for the least cost, see --cost and --effort.
    Best,
    /// A search for the fewest strips, see --effort.
    Fewest,
    /// Strips ordered for a vertex cache, see --vertex-cache and --objective.
    Cache,
    /// Strips in the order of the input.
    Input,
    /// The SGI algorithm: least adjacency, one level of look-ahead.
    Sgi,
    /// STRIPE as its authors recommend it: stripe-global by rows, cutoff 5.
    Stripe,
    /// STRIPE's local algorithms.
    StripeLocal,
    /// STRIPE's global algorithms: patches of quadrilaterals first, the rest locally.
    StripeGlobal,
    /// Stewart's tunneling operator, short tunnels first, starting from isolated triangles.
    Tunnel,
    /// The Enhanced Tunneling Algorithm of Porcu and Scateni.
    Eta,
}

/// The cost that `best` minimizes, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CostName {
    /// Indices, with a restart between strips.
    Restart,
    /// Vertices sent, including swaps and winding repeats.
    Opengl,
    /// Indices of the strips joined by degenerate triangles.
    Degenerate,
    /// Vertices sent, with free swaps.
    Gl,
}

/// The objective of `cache`, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ObjectiveName {
    /// About as few indices as best, in an order that reduces misses.
    Indices,
    /// Fewer misses, as long as they cost few indices.
    Balanced,
    /// The fewest misses.
    Misses,
}

/// The initial strips of `eta`, by their name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StartName {
    /// One strip per triangle.
    Isolated,
    /// The strips of input.
    Input,
    /// The strips of sgi.
    Sgi,
    /// The strips of sequential.
    Sequential,
}

/// When STRIPE triangulates polygons, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TriangulationName {
    /// In advance, by alternate left and right turns.
    Static,
    /// Completely, when a strip enters the face.
    Whole,
    /// Only as far as the strip needs to leave the face.
    Partial,
}

/// How STRIPE breaks ties, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TiesName {
    /// The first one found.
    Arbitrary,
    /// The one whose neighbours have the least adjacency.
    LookAhead,
    /// The one on the other side from the previous turn.
    Alternate,
    /// One chosen at random, by the seed.
    Random,
    /// One that needs no swap, else one chosen at random.
    Sequential,
}

/// How STRIPE turns patches into strips, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PatchesName {
    /// One strip per row or column.
    Rows,
    /// One strip per patch, extended at both ends.
    Full,
}

#[derive(Debug, Args)]
pub(crate) struct WeldArgs {
    /// Merge vertices with the same bits in position and all attributes
    ///
    /// Strips can then cross the seam between them. Vertices that differ in any attribute, such as a normal or a texture coordinate,
    /// stay separate. Welding saves indices, not vertices: the vertex buffer is written unchanged.
    #[arg(long)]
    pub(crate) weld: bool,
}

/// The flags that choose the method and its options.
#[derive(Debug, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodArgs {
    /// The stripification method
    ///
    /// The default starts from the cheapest result of `sequential`, `stripe` and `input`, so it is never worse than the input. A higher
    /// --effort gives fewer indices. Most other methods are published algorithms, included for comparison; `tristrip compare` shows
    /// them side by side.
    #[arg(short, long, value_enum, default_value_t = MethodName::Auto, value_name = "METHOD")]
    method: MethodName,
    /// When stripe-local triangulates polygons [default: whole]
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = false)]
    triangulation: Option<TriangulationName>,
    /// How stripe-local chooses between equally good neighbours [default: sequential]
    #[arg(long, value_enum, value_name = "RULE")]
    ties: Option<TiesName>,
    /// How stripe-global turns patches into strips [default: rows]
    #[arg(long, value_enum, value_name = "HOW")]
    patches: Option<PatchesName>,
    /// The minimum size of a patch of stripe-global, in quadrilaterals [default: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cutoff: Option<u32>,
    /// The cost that auto and best minimize [default: restart]
    ///
    /// Strips with the least restart cost are nearly the cheapest for degenerate joins, too.
    #[arg(long, value_enum, value_name = "COST")]
    cost: Option<CostName>,
    /// The vertex cache that cache optimizes for, and --pareto measures with: fifo:N or lru:N, N entries [default: fifo:16]
    ///
    /// The cache is kept from one strip to the next, as graphics processors do. Desktop processors behave like 16 to 32 entries.
    #[arg(long, value_name = "CACHE")]
    vertex_cache: Option<Buffer>,
    /// What cache favours where fewer indices cost more misses [default: balanced]
    #[arg(long, value_enum, value_name = "OBJECTIVE")]
    objective: Option<ObjectiveName>,
    /// The search effort of auto, best, fewest and cache, from 0 to 9 [default: 2 for auto and cache, else 5]
    ///
    /// Effort is counted in steps, so the result is the same on every machine. On one core and 70,000 triangles, best takes about
    /// 0.01 s at level 1, 0.04 s at 2, 0.1 s at 3, 0.3 s at 4, 0.6 s at 5, 1.3 s at 6, 2.5 s at 7, 5 s at 8 and 10 s at 9; the time is
    /// proportional to the triangles above 8,000 triangles, and constant below. fewest ends when it meets its lower bound; otherwise
    /// each level doubles its time. cache takes a second per million triangles up to level 2; from level 3 on, it grows strips with
    /// several heuristics, and for fifo caches of up to 256 entries continues with a local search. With --objective indices it searches
    /// in the same way as best.
    #[arg(long, value_name = "LEVEL", value_parser = effort_parser())]
    effort: Option<Effort>,
    /// Stop a search after a time such as 5s or 500ms, with the best result so far
    ///
    /// Applies to auto, best, fewest, cache, tunnel and eta, for each input; the first growth of cache is always completed. Results
    /// with a budget differ from run to run; results with --effort do not.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    budget: Option<Duration>,
    /// The maximum length of a tunnel for tunnel and eta, in edges of the dual graph [default: 9 for tunnel, 1000 for eta]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    tunnel_length: Option<u32>,
    /// The number of triangles that eta visits before it gives up a search [default: 512]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threshold: Option<u32>,
    /// The initial strips of eta [default: sequential]
    #[arg(long, value_enum, value_name = "STRIPS")]
    start: Option<StartName>,
    /// The seed of randomized methods: auto, best, fewest, cache, eta, stripe [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    weld: WeldArgs,
}

impl MethodArgs {
    /// Builds the options. With `all_methods`, the flags of searches fit any method, because all methods run.
    ///
    /// # Errors
    /// A flag belongs to another method.
    pub(crate) fn validate(&self, all_methods: bool) -> Result<Options, String> {
        use MethodName::{
            Auto, Best, Cache, Eta, Fewest, Input, Sequential, Sgi, Stripe, StripeGlobal, StripeLocal, Tunnel,
        };
        let local = self.method == StripeLocal;
        let global = matches!(self.method, Stripe | StripeGlobal);
        let check = |flag: &str, is_set: bool, fits: bool, methods: &str| {
            if is_set && !fits {
                return Err(format!("{flag} belongs to --method {methods}, not to {}", name_of(self.method)));
            }
            Ok(())
        };
        check("--triangulation", self.triangulation.is_some(), local, "stripe-local")?;
        check("--ties", self.ties.is_some(), local, "stripe-local")?;
        check("--patches", self.patches.is_some(), global, "stripe-global")?;
        check("--cutoff", self.cutoff.is_some(), global, "stripe-global")?;
        let best = matches!(self.method, Auto | Best);
        let cache = self.method == Cache;
        let search = best || cache || self.method == Fewest || all_methods;
        let tunnels = matches!(self.method, Tunnel | Eta);
        check("--cost", self.cost.is_some(), best, "auto or best")?;
        check("--effort", self.effort.is_some(), search, "auto, best, fewest or cache")?;
        check("--vertex-cache", self.vertex_cache.is_some(), cache || all_methods, "cache")?;
        check("--objective", self.objective.is_some(), cache, "cache")?;
        let stoppable = "auto, best, fewest, cache, tunnel or eta";
        check("--budget", self.budget.is_some(), search || tunnels, stoppable)?;
        check("--tunnel-length", self.tunnel_length.is_some(), tunnels, "tunnel or eta")?;
        check("--threshold", self.threshold.is_some(), self.method == Eta, "eta")?;
        check("--start", self.start.is_some(), self.method == Eta, "eta")?;
        let randomized = local || global || search || self.method == Eta;
        check("--seed", self.seed.is_some(), randomized, "auto, best, fewest, cache, eta or one of stripe")?;
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
            Best => Method::Best,
            Fewest => Method::Fewest,
            Cache => Method::Cache,
            Tunnel => Method::Tunnel { length: self.tunnel_length.unwrap_or(TUNNEL_LENGTH) },
            Eta => Method::Eta(self.eta()),
        };
        let options = Options::default()
            .with_method(method)
            .with_weld(self.weld.weld)
            .with_seed(self.seed.unwrap_or(0))
            .with_cost(self.cost.map(Into::into).unwrap_or_default())
            .with_buffer(self.vertex_cache.unwrap_or_default())
            .with_prefer(self.objective.map(Into::into).unwrap_or_default());
        Ok(match self.effort {
            Some(effort) => options.with_effort(effort),
            None => options,
        })
    }

    fn eta(&self) -> EtaOptions {
        let mut eta = EtaOptions::default();
        if let Some(length) = self.tunnel_length {
            eta = eta.with_length(length);
        }
        if let Some(threshold) = self.threshold {
            eta = eta.with_threshold(threshold);
        }
        if let Some(start) = self.start {
            eta = eta.with_start(start.into());
        }
        eta
    }

    /// Returns the requested effort.
    pub(crate) fn effort(&self) -> Option<Effort> {
        self.effort
    }

    /// Returns the time after which a search stops.
    pub(crate) fn budget(&self) -> Option<Duration> {
        self.budget
    }
}

impl From<CostName> for Cost {
    fn from(name: CostName) -> Self {
        match name {
            CostName::Restart => Self::Restart,
            CostName::Opengl => Self::OpenGl,
            CostName::Degenerate => Self::Degenerate,
            CostName::Gl => Self::Gl,
        }
    }
}

impl From<ObjectiveName> for Prefer {
    fn from(name: ObjectiveName) -> Self {
        match name {
            ObjectiveName::Indices => Self::Indices,
            ObjectiveName::Balanced => Self::Balanced,
            ObjectiveName::Misses => Self::Misses,
        }
    }
}

impl From<StartName> for Start {
    fn from(name: StartName) -> Self {
        match name {
            StartName::Isolated => Self::Isolated,
            StartName::Input => Self::Input,
            StartName::Sgi => Self::Sgi,
            StartName::Sequential => Self::Sequential,
        }
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

/// Returns the name of the value of a command-line enumeration that stands for a value of the library.
fn library_name<E: ValueEnum + Copy, T: From<E> + PartialEq + Copy>(value: T) -> Option<String> {
    E::value_variants().iter().find(|&&name| T::from(name) == value).map(|&name| name_of(name))
}

/// A method and its options in the words of the command line; the keys are those of the JSON report.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
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
    seed: Option<u64>,
}

impl MethodReport {
    pub(crate) fn of(options: &Options) -> Self {
        let plain = |method| Self { method: name_of(method), ..Self::default() };
        let search = |method| Self {
            cost: library_name::<CostName, _>(options.cost()),
            effort: Some(options.effort().level()),
            seed: Some(options.seed()),
            ..plain(method)
        };
        match options.method() {
            Method::Sequential => plain(MethodName::Sequential),
            Method::Input => plain(MethodName::Input),
            Method::Sgi => plain(MethodName::Sgi),
            Method::StripeLocal { triangulation, ties } => Self {
                triangulation: library_name::<TriangulationName, _>(triangulation),
                ties: library_name::<TiesName, _>(ties),
                seed: Some(options.seed()),
                ..plain(MethodName::StripeLocal)
            },
            Method::StripeGlobal { patches, cutoff } => Self {
                patches: library_name::<PatchesName, _>(patches),
                cutoff: Some(cutoff),
                seed: Some(options.seed()),
                ..plain(MethodName::StripeGlobal)
            },
            Method::Best => search(MethodName::Best),
            Method::Fewest => Self { cost: None, ..search(MethodName::Fewest) },
            Method::Cache => Self {
                cost: None,
                vertex_cache: Some(options.buffer().to_string()),
                objective: library_name::<ObjectiveName, _>(options.prefer()),
                ..search(MethodName::Cache)
            },
            Method::Tunnel { length } => Self { tunnel_length: Some(length), ..plain(MethodName::Tunnel) },
            Method::Eta(eta) => Self {
                tunnel_length: Some(eta.length()),
                threshold: Some(eta.threshold()),
                start: library_name::<StartName, _>(eta.start()),
                seed: Some(options.seed()),
                ..plain(MethodName::Eta)
            },
            _ => search(MethodName::Auto),
        }
    }

    /// Returns the name of the method.
    pub(crate) fn method(&self) -> &str {
        &self.method
    }

    /// Returns the objective of `cache`; `None` for other methods.
    pub(crate) fn objective(&self) -> Option<&str> {
        self.objective.as_deref()
    }

    /// Returns the effort; `None` for methods that do not search.
    pub(crate) fn effort(&self) -> Option<u8> {
        self.effort
    }

    /// Returns a short name of the method and its options: `stripe-local whole sequential`.
    pub(crate) fn label(&self) -> String {
        let words = [
            &self.triangulation,
            &self.ties,
            &self.patches,
            &self.cost,
            &self.vertex_cache,
            &self.objective,
            &self.start,
        ];
        let numbers = [self.cutoff, self.effort.map(u32::from), self.tunnel_length];
        let words = [Some(self.method.clone())].into_iter().chain(words.into_iter().cloned()).flatten();
        let numbers = numbers.into_iter().flatten().map(|n| n.to_string());
        words.chain(numbers).collect::<Vec<_>>().join(" ")
    }

    /// Describes the method and its options: `method best, cost restart, effort 2`. `auto` goes by the methods that it chose.
    pub(crate) fn description(&self, chosen: &Chosen) -> String {
        let names: Vec<&str> = chosen.0.iter().map(|(name, _)| name.as_str()).collect();
        let method = if names.is_empty() { self.method.clone() } else { names.join(" or ") };
        let number = |n: Option<u32>| n.map(|n| n.to_string());
        let options = [
            ("triangulation", self.triangulation.clone()),
            ("ties", self.ties.clone()),
            ("patches", self.patches.clone()),
            ("cutoff", number(self.cutoff)),
            ("cost", self.cost.clone()),
            ("vertex cache", self.vertex_cache.clone()),
            ("objective", self.objective.clone()),
            ("effort", number(self.effort.map(u32::from))),
            ("tunnel length", number(self.tunnel_length)),
            ("threshold", number(self.threshold)),
            ("start", self.start.clone()),
        ];
        let options = options.into_iter().filter_map(|(name, value)| Some(format!("{name} {}", value?)));
        std::iter::once(format!("method {method}")).chain(options).collect::<Vec<_>>().join(", ")
    }
}

/// The methods that were used, with the number of parts of each, in the order of [`MethodName`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Chosen(Vec<(String, usize)>);

impl Chosen {
    pub(crate) fn of(methods: &[Method]) -> Self {
        let mut counts: Vec<(String, usize)> =
            MethodName::value_variants().iter().map(|&method| (name_of(method), 0)).collect();
        for &method in methods {
            let name = MethodReport::of(&Options::default().with_method(method)).method;
            if let Some((_, count)) = counts.iter_mut().find(|(known, _)| *known == name) {
                *count += 1;
            }
        }
        counts.retain(|(_, count)| *count > 0);
        Self(counts)
    }
}

/// Serializes as an object of names and counts.
impl Serialize for Chosen {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, count)| (name, count)))
    }
}

/// Returns the methods to compare: one or a few per family, or every variant.
pub(crate) fn methods_to_compare(every_variant: bool) -> Vec<Method> {
    let mut methods = vec![
        Method::Auto,
        Method::Best,
        Method::Fewest,
        Method::Cache,
        Method::Input,
        Method::Sequential,
        Method::Sgi,
    ];
    let local = |triangulation, ties| Method::StripeLocal { triangulation, ties };
    let global = |patches, cutoff| Method::StripeGlobal { patches, cutoff };
    if every_variant {
        methods.extend([Method::Tunnel { length: TUNNEL_LENGTH }, Method::Eta(EtaOptions::default())]);
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
    fn all_variants_have_distinct_names() {
        let label = |method| MethodReport::of(&Options::default().with_method(method)).label();
        let labels: HashSet<String> = methods_to_compare(true).into_iter().map(label).collect();
        assert_eq!(labels.len(), 9 + 15 + 10);
        assert!(
            labels.contains("stripe-local partial look-ahead") && labels.contains("stripe-global full 25")
        );
        assert!(methods_to_compare(false).into_iter().all(|method| labels.contains(&label(method))));
    }

    #[test]
    fn chosen_methods_are_counted_by_name() {
        let chosen = Chosen::of(&[Method::Input, Method::Best, Method::Input]);
        assert_eq!(serde_json::to_string(&chosen).unwrap(), r#"{"best":1,"input":2}"#);
        assert_eq!(Chosen::of(&[]), Chosen::default());
    }

    #[test]
    fn auto_is_described_as_the_method_that_it_chose() {
        let auto = MethodReport::of(&Options::default());
        assert_eq!(auto.description(&Chosen::of(&[Method::Best])), "method best, cost restart, effort 2");
        let local = Options::default().with_method(Method::STRIPE);
        assert_eq!(
            MethodReport::of(&local).description(&Chosen::default()),
            "method stripe-global, patches rows, cutoff 5"
        );
    }
}
