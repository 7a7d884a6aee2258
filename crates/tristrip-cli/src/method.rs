//! Stripification methods and their options: as typed, and as the library takes them.

use std::time::Duration;

use clap::{Args, ValueEnum};
use tristrip::strip::Cost;
use tristrip::stripify::{Effort, EtaOptions, Objective, Start};
use tristrip::vertex_cache::VertexCache;
use tristrip::{FaceTriangulation, Method, Patches, StripifyOptions, Ties};
use tristrip_pipeline::TUNNEL_LENGTH;

use crate::values::{effort_parser, name_of};

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
    vertex_cache: Option<VertexCache>,
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
    pub(crate) fn validate(&self, all_methods: bool) -> Result<StripifyOptions, String> {
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
        let options = StripifyOptions::default()
            .with_method(method)
            .with_weld(self.weld.weld)
            .with_seed(self.seed.unwrap_or(0))
            .with_cost(self.cost.map(Into::into).unwrap_or_default())
            .with_vertex_cache(self.vertex_cache.unwrap_or_default())
            .with_objective(self.objective.map(Into::into).unwrap_or_default());
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

impl From<ObjectiveName> for Objective {
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use tristrip_pipeline::{MethodReport, parse_method};

    #[derive(Debug, Parser)]
    struct MethodFlags {
        #[command(flatten)]
        method: MethodArgs,
    }

    fn typed(flags: &str) -> Result<StripifyOptions, String> {
        let words = std::iter::once("tristrip").chain(flags.split_whitespace());
        let flags = MethodFlags::try_parse_from(words).map_err(|error| error.to_string())?;
        flags.method.validate(false)
    }

    /// Returns the flags of every value of an enumeration.
    fn each<E: ValueEnum + Copy>(method: &str, flag: &str) -> Vec<String> {
        E::value_variants()
            .iter()
            .map(|&name| format!("--method {method} {flag} {}", name_of(name)))
            .collect()
    }

    /// The recipes of papers are flags of the command, which the library parses by itself.
    #[test]
    fn flags_mean_the_same_to_the_command_and_to_the_library() {
        let methods: Vec<String> =
            MethodName::value_variants().iter().map(|&name| format!("--method {}", name_of(name))).collect();
        let all = [
            methods,
            each::<CostName>("best", "--cost"),
            each::<ObjectiveName>("cache", "--objective"),
            each::<StartName>("eta", "--start"),
            each::<TriangulationName>("stripe-local", "--triangulation"),
            each::<TiesName>("stripe-local", "--ties"),
            each::<PatchesName>("stripe-global", "--patches"),
            [
                "",
                "--method stripe --cutoff 25 --seed 7",
                "--method tunnel --tunnel-length 1001",
                "--method eta --tunnel-length 20 --threshold 9",
                "--method cache --vertex-cache lru:24 --effort 4",
                "--method fewest --effort 9",
            ]
            .map(String::from)
            .to_vec(),
        ];
        for flags in all.concat() {
            assert_eq!(typed(&flags).ok(), parse_method(&flags).ok(), "{flags}");
            let options = parse_method(&flags).unwrap();
            let report = serde_json::to_value(MethodReport::of(&options)).unwrap();
            let last = flags.split_whitespace().last().unwrap_or("auto");
            let named = report.as_object().unwrap().values();
            let names: Vec<String> = named.map(|value| value.to_string().replace('"', "")).collect();
            assert!(names.iter().any(|name| name == last) || last == "stripe", "{flags}: {report}");
        }
        for wrong in [
            "--method sgi --start input",
            "--colour red",
            "--method best --effort 10",
            "--method",
            "--cutoff 5",
        ] {
            assert!(typed(wrong).is_err() && parse_method(wrong).is_err(), "{wrong}");
        }
    }
}
