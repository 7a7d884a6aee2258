//! The methods, with the names that the command uses.

use tristrip::Cost;
use tristrip::Effort;
use tristrip::stripify::{Acceptance, Localization, Objective, TunnelOptions};
use tristrip::stripify::{FaceTriangulation, Patches, Ties};
use tristrip::vertex_cache::VertexCache;
use tristrip::{Method, StripifyOptions};

const CUTOFFS: [u32; 5] = [5, 10, 15, 20, 25];
/// The name of `best` among the main methods, for restarts at the default effort.
pub const BEST: &str = "best 2";
/// The name of `fewest` among the main methods, at the lowest effort, because it runs many times on
/// every model.
pub const FEWEST: &str = "fewest 0";
/// The name of `guided-tunnels` among the main methods. Its tunnel length takes seconds even on
/// half a million triangles without tunnels.
pub const GUIDED_TUNNELS: &str = "guided-tunnels 20";
/// The name of `cache` among the main methods, for the default vertex cache at the default effort.
pub const CACHE: &str = "cache fifo:16 balanced";
const GUIDED_LENGTH: u32 = 20;
/// The suffix of methods that search without localization.
pub const NOT_LOCALIZED: &str = "not localized";
/// The maximum length of the tunnels of `eta`. With it, `eta` takes seconds on the largest models.
const ETA_LENGTH: u32 = 9;
/// The maximum length of plain tunnels. Their time grows exponentially with it.
const TUNNEL_LENGTH: u32 = 5;

/// A named method with its options: `stripe-local whole sequential`, `best 1 opengl`.
#[derive(Debug, Clone)]
pub struct NamedMethod {
    /// The name on the command line, followed by the options. `stripe` is the global algorithm with
    /// the options that its authors recommend.
    pub name: String,
    /// The method with its cost and effort.
    pub options: StripifyOptions,
}

impl NamedMethod {
    fn new(name: impl Into<String>, method: Method) -> Self {
        Self { name: name.into(), options: StripifyOptions::default().with_method(method) }
    }

    /// Creates a search. Its name has the method, the effort, and the cost unless it is the
    /// default.
    ///
    /// # Panics
    /// `effort` is greater than 9.
    #[expect(clippy::expect_used, reason = "the levels are constants of the benchmarks")]
    pub fn search(method: Method, effort: u8, cost: Cost) -> Self {
        let of_cost = if cost == Cost::default() { String::new() } else { format!(" {cost}") };
        let mut named = Self::new(format!("{method} {effort}{of_cost}"), method);
        let effort = Effort::new(effort).expect("a level from 0 to 9");
        named.options = named.options.with_effort(effort).with_cost(cost);
        named
    }

    /// Creates `cache` for a vertex cache and an objective. Its name has both.
    pub fn cache(cache: VertexCache, objective: Objective) -> Self {
        let mut named = Self::new(format!("cache {cache} {objective}"), Method::Cache);
        named.options = named.options.with_vertex_cache(cache).with_objective(objective);
        named
    }

    /// Sets an effort other than the default, and adds it to the name.
    ///
    /// # Panics
    /// `effort` is greater than 9.
    #[must_use]
    #[expect(clippy::expect_used, reason = "the levels are constants of the benchmarks")]
    pub fn at(self, effort: u8) -> Self {
        let level = Effort::new(effort).expect("a level from 0 to 9");
        Self { name: format!("{} {effort}", self.name), options: self.options.with_effort(level) }
    }
}

/// The default of STRIPE's local algorithm, with its name among the variants.
const LOCAL: (&str, Method) = (
    "stripe-local whole sequential",
    Method::StripeLocal { triangulation: FaceTriangulation::Whole, ties: Ties::Sequential },
);

/// Returns one method per family.
pub fn main_methods() -> Vec<NamedMethod> {
    let named = |name: &str, method| NamedMethod::new(name, method);
    vec![
        named("sequential", Method::Sequential),
        named("input", Method::Input),
        named("sgi", Method::SGI),
        named("stripe", Method::STRIPE),
        named("quad-rows", Method::QUAD_ROWS),
        named(LOCAL.0, LOCAL.1),
        NamedMethod::search(Method::Best, 2, Cost::Restart),
        NamedMethod::search(Method::Fewest, 0, Cost::Restart),
        named(GUIDED_TUNNELS, Method::GuidedTunnels(TunnelOptions::default().with_length(GUIDED_LENGTH))),
        NamedMethod::cache(VertexCache::default(), Objective::default()),
    ]
}

/// Returns every method with all its options: the methods without options, the 24 and 10 variants
/// of STRIPE, and `best` for each cost.
pub fn all_methods() -> Vec<NamedMethod> {
    let mut methods = main_methods();
    for triangulation in FaceTriangulation::ALL {
        for ties in Ties::ALL {
            let method = Method::StripeLocal { triangulation, ties };
            if method != LOCAL.1 {
                methods.push(NamedMethod::new(format!("stripe-local {triangulation} {ties}"), method));
            }
        }
    }
    for patches in Patches::ALL {
        for cutoff in CUTOFFS {
            let method = Method::StripeGlobal { patches, cutoff, ties: Ties::default() };
            if method != Method::STRIPE {
                methods.push(NamedMethod::new(format!("stripe-global {patches} {cutoff}"), method));
            }
        }
    }
    let caches = [VertexCache::fifo(16), VertexCache::lru(8)];
    for (cache, objective) in caches.into_iter().flat_map(|cache| Objective::ALL.map(|each| (cache, each))) {
        if (cache, objective) != (VertexCache::default(), Objective::default()) {
            methods.push(NamedMethod::cache(cache, objective));
        }
    }
    methods.push(NamedMethod::new("guided-tunnels", Method::GuidedTunnels(TunnelOptions::default())));
    let tunnels = TunnelOptions::ETA.with_length(ETA_LENGTH);
    let eta = |acceptance, localization| Method::Eta { tunnels, acceptance, localization };
    let published = eta(Acceptance::DepthFirst, Localization::OnDemand);
    methods.push(NamedMethod::new(format!("eta {ETA_LENGTH}"), published));
    let plain = eta(Acceptance::BreadthFirst, Localization::None);
    methods.push(NamedMethod::new(format!("eta {ETA_LENGTH} breadth-first {NOT_LOCALIZED}"), plain));
    methods
        .push(NamedMethod::new(format!("tunnel {TUNNEL_LENGTH}"), Method::Tunnel { length: TUNNEL_LENGTH }));
    methods.extend(Cost::ALL.map(|cost| NamedMethod::search(Method::Best, 1, cost)));
    methods
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_variant_comes_once() {
        let methods = all_methods();
        assert_eq!(methods.len(), 4 + 24 + 10 + 4 + 3 + 6 + Cost::ALL.len());
        assert_eq!(methods.iter().map(|m| m.options).collect::<HashSet<_>>().len(), methods.len());
        assert_eq!(methods.iter().map(|m| &m.name).collect::<HashSet<_>>().len(), methods.len());
        assert_eq!(BEST, format!("best {}", StripifyOptions::default().effort_or_default().level()));
        assert!(
            [BEST, FEWEST, GUIDED_TUNNELS, CACHE]
                .iter()
                .all(|name| main_methods().iter().any(|m| m.name == *name))
        );
    }
}
