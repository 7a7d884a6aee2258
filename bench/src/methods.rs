//! The methods by the names that the command gives them.

use tristrip::strip::Cost;
use tristrip::stripify::{Effort, EtaOptions, Objective};
use tristrip::vertex_cache::VertexCache;
use tristrip::{FaceTriangulation, Method, Patches, StripifyOptions, Ties};

const TRIANGULATIONS: [(FaceTriangulation, &str); 3] = [
    (FaceTriangulation::Static, "static"),
    (FaceTriangulation::Whole, "whole"),
    (FaceTriangulation::Partial, "partial"),
];
const TIES: [(Ties, &str); 5] = [
    (Ties::Arbitrary, "arbitrary"),
    (Ties::LookAhead, "look-ahead"),
    (Ties::Alternate, "alternate"),
    (Ties::Random, "random"),
    (Ties::Sequential, "sequential"),
];
const PATCHES: [(Patches, &str); 2] = [(Patches::Rows, "rows"), (Patches::Full, "full")];
const CUTOFFS: [u32; 5] = [5, 10, 15, 20, 25];
/// The costs by the names that the command gives them.
pub const COSTS: [(Cost, &str); 4] = [
    (Cost::Restart, "restart"),
    (Cost::OpenGl, "opengl"),
    (Cost::Degenerate, "degenerate"),
    (Cost::Gl, "gl"),
];
/// What `cache` prefers, by the names that the command gives it.
pub const PREFERENCES: [(Objective, &str); 3] =
    [(Objective::Indices, "indices"), (Objective::Balanced, "balanced"), (Objective::Misses, "misses")];
/// The name of `best` among the main methods: for restarts, at an effort that a build of assets does not notice.
pub const BEST: &str = "best 2";
/// The name of `fewest` among the main methods: at the least effort, as it is tried on every model many times.
pub const FEWEST: &str = "fewest 0";
/// The name of `eta` among the main methods: with tunnels that end in seconds also where no tunnel is left on half a million triangles.
pub const ETA: &str = "eta 20";
/// The name of `cache` among the main methods: for the usual buffer, at the usual effort.
pub const CACHE: &str = "cache fifo:16 balanced";
const ETA_LENGTH: u32 = 20;
/// The greatest length of the plain tunnels, whose time grows as its exponential.
const TUNNEL_LENGTH: u32 = 5;

/// A method and what goes with it, by a name: `stripe-local whole sequential`, `best 1 opengl`.
#[derive(Debug, Clone)]
pub struct Named {
    /// As on the command line, options after it; `stripe` is the global algorithm as its authors recommend it.
    pub name: String,
    /// The method with its cost and effort.
    pub options: StripifyOptions,
}

impl Named {
    fn new(name: impl Into<String>, method: Method) -> Self {
        Self { name: name.into(), options: StripifyOptions::default().with_method(method) }
    }

    /// Names a search by its method's name, the effort, and the cost unless it is the usual one.
    ///
    /// # Panics
    /// There is no such effort.
    #[expect(clippy::expect_used, reason = "the levels are constants of the benchmarks")]
    pub fn search(method: Method, effort: u8, cost: Cost) -> Self {
        let name = if method == Method::Fewest { "fewest" } else { "best" };
        let of_cost = COSTS.iter().find(|(each, _)| *each == cost && cost != Cost::default());
        let of_cost = of_cost.map(|(_, cost)| format!(" {cost}")).unwrap_or_default();
        let mut named = Self::new(format!("{name} {effort}{of_cost}"), method);
        let effort = Effort::new(effort).expect("a level from 0 to 9");
        named.options = named.options.with_effort(effort).with_cost(cost);
        named
    }

    /// Names `cache` by its buffer and what it prefers.
    pub fn cache(buffer: VertexCache, prefer: Objective) -> Self {
        let preferred = PREFERENCES.iter().find(|(each, _)| *each == prefer).map_or("", |(_, name)| *name);
        let mut named = Self::new(format!("cache {buffer} {preferred}"), Method::Cache);
        named.options = named.options.with_vertex_cache(buffer).with_objective(prefer);
        named
    }

    /// Takes another effort than the usual one, and says so in the name.
    ///
    /// # Panics
    /// There is no such effort.
    #[must_use]
    #[expect(clippy::expect_used, reason = "the levels are constants of the benchmarks")]
    pub fn at(self, effort: u8) -> Self {
        let level = Effort::new(effort).expect("a level from 0 to 9");
        Self { name: format!("{} {effort}", self.name), options: self.options.with_effort(level) }
    }
}

/// STRIPE's local algorithm as it is by default, by its name among the variants.
const LOCAL: (&str, Method) = (
    "stripe-local whole sequential",
    Method::StripeLocal { triangulation: FaceTriangulation::Whole, ties: Ties::Sequential },
);

/// Lists one method for each family.
pub fn main_methods() -> Vec<Named> {
    let named = |name: &str, method| Named::new(name, method);
    vec![
        named("sequential", Method::Sequential),
        named("auto", Method::Auto),
        named("input", Method::Input),
        named("sgi", Method::Sgi),
        named("stripe", Method::STRIPE),
        named(LOCAL.0, LOCAL.1),
        Named::search(Method::Best, 2, Cost::Restart),
        Named::search(Method::Fewest, 0, Cost::Restart),
        named(ETA, Method::Eta(EtaOptions::default().with_length(ETA_LENGTH))),
        Named::cache(VertexCache::default(), Objective::default()),
    ]
}

/// Lists every method with every option: those without any, the 15 and 10 of STRIPE, and `best` for each cost.
pub fn all_methods() -> Vec<Named> {
    let mut methods = main_methods();
    for (triangulation, when) in TRIANGULATIONS {
        for (ties, rule) in TIES {
            let method = Method::StripeLocal { triangulation, ties };
            if method != LOCAL.1 {
                methods.push(Named::new(format!("stripe-local {when} {rule}"), method));
            }
        }
    }
    for (patches, how) in PATCHES {
        for cutoff in CUTOFFS {
            let method = Method::StripeGlobal { patches, cutoff };
            if method != Method::STRIPE {
                methods.push(Named::new(format!("stripe-global {how} {cutoff}"), method));
            }
        }
    }
    let buffers = [VertexCache::fifo(16), VertexCache::lru(8)];
    for (buffer, (prefer, _)) in buffers.into_iter().flat_map(|buffer| PREFERENCES.map(|each| (buffer, each)))
    {
        if (buffer, prefer) != (VertexCache::default(), Objective::default()) {
            methods.push(Named::cache(buffer, prefer));
        }
    }
    methods.push(Named::new("eta", Method::Eta(EtaOptions::default())));
    methods.push(Named::new(format!("tunnel {TUNNEL_LENGTH}"), Method::Tunnel { length: TUNNEL_LENGTH }));
    methods.extend(COSTS.map(|(cost, _)| Named::search(Method::Best, 1, cost)));
    methods
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_variant_comes_once() {
        let methods = all_methods();
        assert_eq!(methods.len(), 4 + 15 + 10 + 4 + 1 + 6 + COSTS.len());
        assert_eq!(methods.iter().map(|m| m.options).collect::<HashSet<_>>().len(), methods.len());
        assert_eq!(methods.iter().map(|m| &m.name).collect::<HashSet<_>>().len(), methods.len());
        assert!([BEST, FEWEST, ETA, CACHE].iter().all(|name| main_methods().iter().any(|m| m.name == *name)));
    }
}
