//! Stripification methods and their options: as typed, and as the library takes them.

use std::time::Duration;

use clap::Args;
use tristrip::Cost;
use tristrip::Effort;
use tristrip::stripify::{Acceptance, Localization, Objective, Start, TunnelOptions};
use tristrip::stripify::{FaceTriangulation, LastTie, Patches, Ties};
use tristrip::vertex_cache::VertexCache;
use tristrip::{Method, StripifyOptions};

use crate::values::{effort_parser, method_parser, named};

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
    /// The stripification method [default: best]
    ///
    /// The default starts from the cheapest result of `sequential`, `quad-rows` and `input`, so it is never worse than the input. A higher
    /// --effort gives fewer indices. Most other methods are published algorithms, included for comparison; `tristrip compare` shows
    /// them side by side.
    #[arg(short, long, value_parser = method_parser(), value_name = "METHOD")]
    method: Option<Method>,
    /// When stripe-local triangulates polygons [default: whole]
    #[arg(long, value_parser = named(FaceTriangulation::ALL, FaceTriangulation::name, FaceTriangulation::summary), value_name = "WHEN")]
    triangulation: Option<FaceTriangulation>,
    /// How stripe-local and stripe-global choose between equally good neighbours [default: sequential]
    #[arg(long, value_parser = named(Ties::ALL, Ties::name, Ties::summary), value_name = "RULE")]
    ties: Option<Ties>,
    /// Which neighbour sgi takes where looking ahead leaves several [default: last]
    #[arg(long, value_parser = named(LastTie::ALL, LastTie::name, LastTie::summary), value_name = "WHICH")]
    last_tie: Option<LastTie>,
    /// How stripe-global turns patches into strips [default: rows]
    #[arg(long, value_parser = named(Patches::ALL, Patches::name, Patches::summary), value_name = "HOW")]
    patches: Option<Patches>,
    /// The minimum size of a patch of stripe-global and quad-rows, in quadrilaterals [default: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cutoff: Option<u32>,
    /// The cost that best minimizes [default: restart]
    ///
    /// Strips with the least restart cost are nearly the cheapest for degenerate joins, too.
    #[arg(long, value_parser = named(Cost::ALL, Cost::name, Cost::summary), value_name = "COST")]
    cost: Option<Cost>,
    /// The vertex cache that cache optimizes for: fifo:N or lru:N, N entries [default: fifo:16]
    ///
    /// The cache is kept from one strip to the next, as graphics processors do. Desktop processors behave like 16 to 32 entries.
    #[arg(long, value_name = "CACHE")]
    vertex_cache: Option<VertexCache>,
    /// What cache favours where fewer indices cost more misses [default: balanced]
    #[arg(long, value_parser = named(Objective::ALL, Objective::name, Objective::summary), value_name = "OBJECTIVE")]
    objective: Option<Objective>,
    /// The search effort of best, fewest and cache, from 0 to 9 [default: 2, for fewest 5]
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
    /// Applies to best, fewest, cache, tunnel, eta and guided-tunnels, for each input; the first growth of cache is always completed. Results
    /// with a budget differ from run to run; results with --effort do not.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    budget: Option<Duration>,
    /// The maximum length of a tunnel, in edges of the dual graph [default: 9 for tunnel, 199 for eta, 1000 for guided-tunnels]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    tunnel_length: Option<u32>,
    /// The number of triangles that a search of eta or guided-tunnels steps on before it gives up [default: 1000 for eta, 512 for guided-tunnels]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threshold: Option<u32>,
    /// The initial strips of eta and guided-tunnels [default: input for eta, sequential for guided-tunnels]
    #[arg(long, value_parser = named(Start::ALL, Start::name, Start::summary), value_name = "STRIPS")]
    start: Option<Start>,
    /// Which tunnels eta accepts [default: depth-first]
    #[arg(long, value_parser = named(Acceptance::ALL, Acceptance::name, Acceptance::summary), value_name = "ORDER")]
    acceptance: Option<Acceptance>,
    /// How far eta writes identifiers during a search [default: on-demand]
    ///
    /// The strips are the same; only the time differs.
    #[arg(long, value_parser = named(Localization::ALL, Localization::name, Localization::summary), value_name = "RANGE")]
    localization: Option<Localization>,
    /// The seed of randomized methods: best, fewest, cache, eta, guided-tunnels, quad-rows, stripe [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    weld: WeldArgs,
}

impl MethodArgs {
    /// Uses the order for vertex caches unless a method is named: for triangle lists, in which strips save nothing.
    pub(crate) fn for_lists(self) -> Self {
        Self { method: self.method.or(Some(Method::Cache)), ..self }
    }

    /// Builds the options.
    ///
    /// # Errors
    /// A flag belongs to another method.
    pub(crate) fn validate(&self) -> Result<StripifyOptions, String> {
        let chosen = self.method.unwrap_or(Method::Best);
        let local = matches!(chosen, Method::StripeLocal { .. });
        let global = matches!(chosen, Method::StripeGlobal { .. });
        let (rows, sgi) = (matches!(chosen, Method::QuadRows { .. }), matches!(chosen, Method::Sgi { .. }));
        let (tunnel, eta) = (matches!(chosen, Method::Tunnel { .. }), matches!(chosen, Method::Eta { .. }));
        let long = eta || matches!(chosen, Method::GuidedTunnels(_));
        let check = |flag: &str, is_set: bool, fits: bool, methods: &str| {
            if is_set && !fits {
                return Err(format!("{flag} belongs to --method {methods}, not to {chosen}"));
            }
            Ok(())
        };
        check("--triangulation", self.triangulation.is_some(), local, "stripe-local")?;
        check("--ties", self.ties.is_some(), local || global, "stripe-local or stripe-global")?;
        check("--last-tie", self.last_tie.is_some(), sgi, "sgi")?;
        check("--patches", self.patches.is_some(), global, "stripe-global")?;
        check("--cutoff", self.cutoff.is_some(), global || rows, "stripe-global or quad-rows")?;
        let best = matches!(chosen, Method::Best);
        let cache = chosen == Method::Cache;
        let search = best || cache || chosen == Method::Fewest;
        let tunnels = tunnel || long;
        check("--cost", self.cost.is_some(), best, "best")?;
        check("--effort", self.effort.is_some(), search, "best, fewest or cache")?;
        check("--vertex-cache", self.vertex_cache.is_some(), cache, "cache")?;
        check("--objective", self.objective.is_some(), cache, "cache")?;
        let stoppable = "best, fewest, cache, tunnel, eta or guided-tunnels";
        check("--budget", self.budget.is_some(), search || tunnels, stoppable)?;
        check("--tunnel-length", self.tunnel_length.is_some(), tunnels, "tunnel, eta or guided-tunnels")?;
        check("--threshold", self.threshold.is_some(), long, "eta or guided-tunnels")?;
        check("--start", self.start.is_some(), long, "eta or guided-tunnels")?;
        check("--acceptance", self.acceptance.is_some(), eta, "eta")?;
        check("--localization", self.localization.is_some(), eta, "eta")?;
        let randomized = local || global || rows || search || long;
        check(
            "--seed",
            self.seed.is_some(),
            randomized,
            "best, fewest, cache, eta, guided-tunnels, quad-rows or one of stripe",
        )?;
        let method = match chosen {
            Method::StripeLocal { triangulation, ties } => Method::StripeLocal {
                triangulation: self.triangulation.unwrap_or(triangulation),
                ties: self.ties.unwrap_or(ties),
            },
            Method::StripeGlobal { patches, cutoff, ties } => Method::StripeGlobal {
                patches: self.patches.unwrap_or(patches),
                cutoff: self.cutoff.unwrap_or(cutoff),
                ties: self.ties.unwrap_or(ties),
            },
            Method::QuadRows { cutoff } => Method::QuadRows { cutoff: self.cutoff.unwrap_or(cutoff) },
            Method::Sgi { last_tie } => Method::Sgi { last_tie: self.last_tie.unwrap_or(last_tie) },
            Method::Tunnel { length } => Method::Tunnel { length: self.tunnel_length.unwrap_or(length) },
            Method::Eta { tunnels, acceptance, localization } => Method::Eta {
                tunnels: self.tunnels(tunnels),
                acceptance: self.acceptance.unwrap_or(acceptance),
                localization: self.localization.unwrap_or(localization),
            },
            Method::GuidedTunnels(tunnels) => Method::GuidedTunnels(self.tunnels(tunnels)),
            method => method,
        };
        let options = StripifyOptions::default()
            .with_method(method)
            .with_weld(self.weld.weld)
            .with_seed(self.seed.unwrap_or(0))
            .with_cost(self.cost.unwrap_or_default())
            .with_vertex_cache(self.vertex_cache.unwrap_or_default())
            .with_objective(self.objective.unwrap_or_default());
        Ok(match self.effort {
            Some(effort) => options.with_effort(effort),
            None => options,
        })
    }

    fn tunnels(&self, mut tunnels: TunnelOptions) -> TunnelOptions {
        if let Some(length) = self.tunnel_length {
            tunnels = tunnels.with_length(length);
        }
        if let Some(threshold) = self.threshold {
            tunnels = tunnels.with_threshold(threshold);
        }
        if let Some(start) = self.start {
            tunnels = tunnels.with_start(start);
        }
        tunnels
    }

    /// Returns the time after which a search stops.
    pub(crate) fn budget(&self) -> Option<Duration> {
        self.budget
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
        flags.method.validate()
    }

    /// Returns the flags of every value of a flag.
    fn each(method: &str, flag: &str, names: &[&str]) -> Vec<String> {
        names.iter().map(|name| format!("--method {method} {flag} {name}")).collect()
    }

    /// The recipes of papers are flags of the command, which the library parses by itself.
    #[test]
    fn flags_mean_the_same_to_the_command_and_to_the_library() {
        let methods = Method::ALL.iter().map(|method| format!("--method {method}"));
        let methods: Vec<String> = methods.chain(["--method stripe".to_owned()]).collect();
        let all = [
            methods,
            each("best", "--cost", &Cost::ALL.map(Cost::name)),
            each("cache", "--objective", &Objective::ALL.map(Objective::name)),
            each("eta", "--start", &Start::ALL.map(Start::name)),
            each("guided-tunnels", "--start", &Start::ALL.map(Start::name)),
            each("eta", "--acceptance", &Acceptance::ALL.map(Acceptance::name)),
            each("eta", "--localization", &Localization::ALL.map(Localization::name)),
            each("stripe-local", "--triangulation", &FaceTriangulation::ALL.map(FaceTriangulation::name)),
            each("stripe-local", "--ties", &Ties::ALL.map(Ties::name)),
            each("stripe-global", "--ties", &Ties::ALL.map(Ties::name)),
            each("sgi", "--last-tie", &LastTie::ALL.map(LastTie::name)),
            each("stripe-global", "--patches", &Patches::ALL.map(Patches::name)),
            [
                "",
                "--method stripe --cutoff 25 --seed 7",
                "--method quad-rows --seed 7 --cutoff 3",
                "--method tunnel --tunnel-length 1001",
                "--method eta --tunnel-length 20 --threshold 9",
                "--method guided-tunnels --tunnel-length 20 --threshold 9",
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
            let last = flags.split_whitespace().last().unwrap_or("best");
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
