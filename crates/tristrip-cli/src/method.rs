//! The methods' names and options: what a user types, what the library takes, and what reports say.

use std::time::Duration;

use clap::{Args, ValueEnum};
use serde::Serialize;
use tristrip::strip::{Buffer, Cost};
use tristrip::stripify::{Effort, EtaOptions, Prefer, Start};
use tristrip::{FaceTriangulation, Method, Options, Patches, Ties};

/// The longest tunnel that `tunnel` looks for unless told otherwise: beyond, each two edges more take several times as long.
const TUNNEL_LENGTH: u32 = 9;

/// A method by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    /// The same as best, at effort 2: less than a second for a million triangles.
    Auto,
    /// Fast, few indices: cheapest runs first, swaps only where they beat a restart.
    Sequential,
    /// The cheapest that a search finds, by --cost and --effort.
    Best,
    /// As few strips as a search finds, by --effort.
    Fewest,
    /// Strips in an order that respects a vertex buffer, by --buffer and --prefer.
    Cache,
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
    /// The tunnelling operator of Stewart, short tunnels first, from isolated triangles.
    Tunnel,
    /// The Enhanced Tunnelling Algorithm of Porcu and Scateni.
    Eta,
}

/// What `best` minimizes, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CostName {
    /// The index buffer with a restart between strips.
    Restart,
    /// The vertices sent, swaps and winding repeats included.
    Opengl,
    /// The index buffer of strips joined by degenerate triangles.
    Degenerate,
    /// The vertices sent with swaps free.
    Gl,
}

/// What `cache` prefers, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PreferName {
    /// About the indices of best, in an order that saves misses.
    Indices,
    /// Fewer misses as long as they take few indices.
    Balanced,
    /// The fewest misses.
    Misses,
}

/// The strips that `eta` starts from, by their name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StartName {
    /// Every triangle by itself.
    Isolated,
    /// Those of input.
    Input,
    /// Those of sgi.
    Sgi,
    /// Those of sequential.
    Sequential,
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
    /// The default starts from the cheapest of `sequential`, `stripe` and `input`, so that the result is never worse than what you
    /// had. More --effort gives fewer indices. Most others are published algorithms, of interest for comparison; `tristrip compare`
    /// shows them side by side.
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
    /// What auto and best minimize [default: restart]
    ///
    /// Strips that are cheap with restarts are nearly the cheapest joined by degenerate triangles, too.
    #[arg(long, value_enum, value_name = "COST")]
    cost: Option<CostName>,
    /// The vertex buffer that cache respects, and --pareto measures with: fifo:N or lru:N, N places [default: fifo:16]
    ///
    /// It is kept from one strip to the next, as processors do. Desktop processors behave like some 16 to 32 places.
    #[arg(long, value_name = "BUFFER")]
    buffer: Option<Buffer>,
    /// What cache prefers where indices and misses are at odds [default: balanced]
    #[arg(long, value_enum, value_name = "WHAT")]
    prefer: Option<PreferName>,
    /// How long auto, best, fewest and cache search, from 0 to 9 [default: 2 for auto and cache, else 5]
    ///
    /// Effort is counted in steps, so that the result is the same on any machine. On one core, best takes for 70,000 triangles about
    /// 0.01 s at level 1, 0.04 s at 2, 0.1 s at 3, 0.3 s at 4, 0.6 s at 5, 1.3 s at 6, 2.5 s at 7, 5 s at 8 and 10 s at 9; for more triangles in
    /// proportion, for fewer the same down to 8,000. fewest ends when it meets its bound, and else takes twice as long for each level.
    /// cache takes a second for a million triangles up to level 2; from 3 on it grows strips in several ways, and for fifo buffers of up
    /// to 256 places searches on by exchanges. The indices of cache are searched as those of best.
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u8).range(0..=9))]
    effort: Option<u8>,
    /// Stop a search after a time, such as 5s or 500ms, with the best found by then
    ///
    /// Applies to auto, best, fewest, cache, tunnel and eta, for each input; the first growth of cache always ends. What is found in a time
    /// differs from run to run; --effort does not.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    budget: Option<Duration>,
    /// The longest tunnel of tunnel and eta, in edges of the dual graph [default: 9 for tunnel, 1000 for eta]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    tunnel_length: Option<u32>,
    /// Triangles that eta looks at before it gives up a search [default: 512]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threshold: Option<u32>,
    /// The strips that eta starts from [default: sequential]
    #[arg(long, value_enum, value_name = "STRIPS")]
    start: Option<StartName>,
    /// The seed of methods that choose at random: auto, best, fewest, cache, eta, stripe [default: 0]
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
    /// Makes options of the flags. Those of searches are for any method where all methods are drawn.
    ///
    /// # Errors
    /// A flag belongs to another method.
    pub(crate) fn validate(&self, all_drawn: bool) -> Result<Options, String> {
        use MethodName::{
            Auto, Best, Cache, Eta, Fewest, Input, Sequential, Sgi, Stripe, StripeGlobal, StripeLocal, Tunnel,
        };
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
        let best = matches!(self.method, Auto | Best);
        let cache = self.method == Cache;
        let search = best || cache || self.method == Fewest || all_drawn;
        let tunnels = matches!(self.method, Tunnel | Eta);
        belongs("--cost", self.cost.is_some(), best, "auto or best")?;
        belongs("--effort", self.effort.is_some(), search, "auto, best, fewest or cache")?;
        belongs("--buffer", self.buffer.is_some(), cache || all_drawn, "cache")?;
        belongs("--prefer", self.prefer.is_some(), cache, "cache")?;
        let long = "auto, best, fewest, cache, tunnel or eta";
        belongs("--budget", self.budget.is_some(), search || tunnels, long)?;
        belongs("--tunnel-length", self.tunnel_length.is_some(), tunnels, "tunnel or eta")?;
        belongs("--threshold", self.threshold.is_some(), self.method == Eta, "eta")?;
        belongs("--start", self.start.is_some(), self.method == Eta, "eta")?;
        let draws = local || global || search || self.method == Eta;
        belongs("--seed", self.seed.is_some(), draws, "auto, best, fewest, cache, eta or one of stripe")?;
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
            .with_weld(self.weld)
            .with_seed(self.seed.unwrap_or(0))
            .with_cost(self.cost.map(Into::into).unwrap_or_default())
            .with_buffer(self.buffer.unwrap_or_default())
            .with_prefer(self.prefer.map(Into::into).unwrap_or_default());
        Ok(match self.effort() {
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

    /// Gives the effort that was asked for.
    pub(crate) fn effort(&self) -> Option<Effort> {
        self.effort.and_then(Effort::new)
    }

    /// Gives the time after which a search shall stop.
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

impl From<PreferName> for Prefer {
    fn from(name: PreferName) -> Self {
        match name {
            PreferName::Indices => Self::Indices,
            PreferName::Balanced => Self::Balanced,
            PreferName::Misses => Self::Misses,
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

/// Gives the name of a value as it is typed.
fn name<E: ValueEnum + Copy>(value: E) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

/// A method as reports name it: the words of the command line.
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
    buffer: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    prefer: Option<String>,
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
        let plain = |method| Self { method: name(method), ..Self::default() };
        let search = |method| Self {
            cost: CostName::value_variants()
                .iter()
                .find(|&&n| Cost::from(n) == options.cost())
                .map(|&n| name(n)),
            effort: Some(options.effort().level()),
            seed: Some(options.seed()),
            ..plain(method)
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
            Method::Best => search(MethodName::Best),
            Method::Fewest => Self { cost: None, ..search(MethodName::Fewest) },
            Method::Cache => Self {
                cost: None,
                buffer: Some(options.buffer().to_string()),
                prefer: PreferName::value_variants()
                    .iter()
                    .find(|&&n| Prefer::from(n) == options.prefer())
                    .map(|&n| name(n)),
                ..search(MethodName::Cache)
            },
            Method::Tunnel { length } => Self { tunnel_length: Some(length), ..plain(MethodName::Tunnel) },
            Method::Eta(eta) => Self {
                tunnel_length: Some(eta.length()),
                threshold: Some(eta.threshold()),
                start: StartName::value_variants()
                    .iter()
                    .find(|&&n| Start::from(n) == eta.start())
                    .map(|&n| name(n)),
                seed: Some(options.seed()),
                ..plain(MethodName::Eta)
            },
            _ => search(MethodName::Auto),
        }
    }

    /// Gives the method's name.
    pub(crate) fn method(&self) -> &str {
        &self.method
    }

    /// Gives what the method prefers, if it prefers anything.
    pub(crate) fn prefer(&self) -> Option<&str> {
        self.prefer.as_deref()
    }

    /// Gives the effort of a method that searches.
    pub(crate) fn effort(&self) -> Option<u8> {
        self.effort
    }

    /// Says the method and its options in one line: `stripe-local whole sequential`.
    pub(crate) fn label(&self) -> String {
        let words = [
            &self.triangulation,
            &self.ties,
            &self.patches,
            &self.cost,
            &self.buffer,
            &self.prefer,
            &self.start,
        ];
        let numbers = [self.cutoff, self.effort.map(u32::from), self.tunnel_length];
        let words = [Some(self.method.clone())].into_iter().chain(words.into_iter().cloned()).flatten();
        let numbers = numbers.into_iter().flatten().map(|n| n.to_string());
        words.chain(numbers).collect::<Vec<_>>().join(" ")
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
}

/// An object of names and counts.
impl Serialize for Chosen {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, count)| (name, count)))
    }
}

/// Lists the methods to compare: a few that stand for their families, or every variant.
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
    fn all_variants_are_compared_under_names_of_their_own() {
        let label = |method| MethodReport::of(&Options::default().with_method(method)).label();
        let labels: HashSet<String> = methods_to_compare(true).into_iter().map(label).collect();
        assert_eq!(labels.len(), 9 + 15 + 10);
        assert!(
            labels.contains("stripe-local partial look-ahead") && labels.contains("stripe-global full 25")
        );
        assert!(methods_to_compare(false).into_iter().all(|method| labels.contains(&label(method))));
    }

    #[test]
    fn what_was_chosen_is_counted_by_name() {
        let chosen = Chosen::of(&[Method::Input, Method::Best, Method::Input]);
        assert_eq!(serde_json::to_string(&chosen).unwrap(), r#"{"best":1,"input":2}"#);
        assert_eq!(Chosen::of(&[]), Chosen::default());
    }
}
