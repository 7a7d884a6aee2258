//! The stripification methods and their options.

mod stripe;
mod tunnels;

pub use stripe::{FaceTriangulation, LastTie, Patches, Ties};
pub use tunnels::{Acceptance, Localization, Start, TunnelOptions};

use crate::effort::Effort;
use crate::error::Error;
use crate::names::names;
use crate::strip::Cost;
use crate::vertex_cache::VertexCache;

/// The default cutoff of [`Method::QUAD_ROWS`], in quadrilaterals.
pub(super) const QUAD_ROWS_CUTOFF: u32 = 5;

/// A stripification method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Method {
    /// This library's fast greedy method, followed by a local search at the ends of strips.
    Sequential,
    /// This library's simulated annealing, starting from the strips of the cheapest fast method,
    /// for a given cost and effort. The default effort takes less than a second per million
    /// triangles.
    #[default]
    Best,
    /// This library's search for the fewest strips, regardless of swaps.
    Fewest,
    /// This library's method for vertex caches: strips grow along the front of the drawn triangles.
    Cache,
    /// Strips in the order of the input faces.
    Input,
    /// The SGI algorithm: fewest free neighbours, with one level of look-ahead.
    Sgi {
        /// Which neighbour is chosen if the look-ahead leaves a tie.
        last_tie: LastTie,
    },
    /// STRIPE's local algorithms.
    StripeLocal {
        /// When polygons are triangulated.
        triangulation: FaceTriangulation,
        /// How ties between neighbours with the lowest adjacency are broken.
        ties: Ties,
    },
    /// STRIPE's global algorithms: patches of quadrilaterals first, then the remaining faces by the
    /// local algorithm.
    StripeGlobal {
        /// How patches are turned into strips.
        patches: Patches,
        /// Minimum size of a patch, in quadrilaterals.
        cutoff: u32,
        /// How ties between neighbours with the lowest adjacency are broken outside the patches.
        ties: Ties,
    },
    /// This library's method for rows of quadrilateral patches. Strips grow at both ends, and the
    /// diagonals of a strip are chosen together.
    QuadRows {
        /// Minimum size of a patch, in quadrilaterals.
        cutoff: u32,
    },
    /// The tunnelling operator with lengths 1, 3, 5 …, starting from isolated triangles.
    Tunnel {
        /// Maximum length of a tunnel, in edges. The running time is exponential in it.
        length: u32,
    },
    /// The enhanced tunnelling algorithm: long tunnels, each searched within a star.
    Eta {
        /// The tunnels, and the initial strips.
        tunnels: TunnelOptions,
        /// Which tunnels are accepted.
        acceptance: Acceptance,
        /// How far identifiers are propagated. This does not change the strips.
        localization: Localization,
    },
    /// This library's long tunnels, guided by the distance to the ends of strips. Ends also move
    /// toward each other.
    GuidedTunnels(TunnelOptions),
}

impl Method {
    /// One method per name, with default parameters.
    pub const ALL: &'static [Self] = &[
        Self::Best,
        Self::Sequential,
        Self::Fewest,
        Self::Cache,
        Self::Input,
        Self::QUAD_ROWS,
        Self::SGI,
        Self::StripeLocal { triangulation: FaceTriangulation::Whole, ties: Ties::Sequential },
        Self::STRIPE,
        Self::TUNNEL,
        Self::ETA,
        Self::GuidedTunnels(TunnelOptions::DEFAULT),
    ];

    /// Returns the name of the method without parameters, as used by the command line and JSON.
    ///
    /// ```
    /// use tristrip::Method;
    /// assert_eq!("tunnel".parse::<Method>()?, Method::Tunnel { length: 9 });
    /// assert_eq!(Method::Tunnel { length: 5 }.name(), "tunnel");
    /// assert!(Method::ALL.iter().all(|method| method.name().parse() == Ok(*method)));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sequential => "sequential",
            Self::Best => "best",
            Self::Fewest => "fewest",
            Self::Cache => "cache",
            Self::Input => "input",
            Self::QuadRows { .. } => "quad-rows",
            Self::Sgi { .. } => "sgi",
            Self::StripeLocal { .. } => "stripe-local",
            Self::StripeGlobal { .. } => "stripe-global",
            Self::Tunnel { .. } => "tunnel",
            Self::Eta { .. } => "eta",
            Self::GuidedTunnels(_) => "guided-tunnels",
        }
    }

    /// Returns the one-line summary of the method, as shown in the command's help.
    ///
    /// ```
    /// assert_eq!(tristrip::Method::Input.summary(), "Strips in the order of the input");
    /// ```
    pub const fn summary(self) -> &'static str {
        match self {
            Self::Sequential => {
                "Fast, with few indices: cheapest runs first, swaps only where they cost less than a restart"
            }
            Self::Best => {
                "A search for the minimum cost; the default effort takes less than a second per million triangles"
            }
            Self::Fewest => "A search for the fewest strips",
            Self::Cache => "Strips ordered for a vertex cache",
            Self::Input => "Strips in the order of the input",
            Self::QuadRows { .. } => {
                "Rows of patches of quadrilaterals that grow at both ends; the diagonals of a strip are chosen together"
            }
            Self::Sgi { .. } => "The SGI algorithm: least adjacency, one level of look-ahead",
            Self::StripeLocal { .. } => "STRIPE's local algorithms",
            Self::StripeGlobal { .. } => {
                "STRIPE's global algorithms: patches of quadrilaterals first, the rest locally"
            }
            Self::Tunnel { .. } => {
                "Stewart's tunneling operator, short tunnels first, starting from isolated triangles"
            }
            Self::Eta { .. } => "The Enhanced Tunneling Algorithm of Porcu and Scateni",
            Self::GuidedTunnels(_) => {
                "Long tunnels toward the nearest end of another strip, and ends that move"
            }
        }
    }

    /// The tunnelling operator up to length 9. Each increase of the length by two edges makes the
    /// search several times slower.
    pub const TUNNEL: Self = Self::Tunnel { length: 9 };
    /// The depth-first enhanced tunnelling algorithm with stars on demand. Its paper gives no
    /// defaults; [`TunnelOptions::ETA`] has those used here.
    pub(crate) const ETA: Self = Self::Eta {
        tunnels: TunnelOptions::ETA,
        acceptance: Acceptance::DepthFirst,
        localization: Localization::OnDemand,
    };
    /// The SGI algorithm. If the look-ahead leaves a tie, the last neighbour is chosen. With the
    /// first neighbour, the strips of the model power lines have 1.5 % more vertices.
    pub const SGI: Self = Self::Sgi { last_tie: LastTie::Last };
    /// STRIPE with the settings that its authors recommend: patches of at least 5 quadrilaterals
    /// become rows or columns, and ties are sequential.
    pub const STRIPE: Self = Self::StripeGlobal { patches: Patches::Rows, cutoff: 5, ties: Ties::Sequential };
    /// Rows of patches of at least 5 quadrilaterals, as in [`Self::STRIPE`].
    pub const QUAD_ROWS: Self = Self::QuadRows { cutoff: QUAD_ROWS_CUTOFF };
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// Parses a [name](Method::name) to the method with default parameters. `stripe` is
/// [`Method::STRIPE`].
impl std::str::FromStr for Method {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        if name == "stripe" {
            return Ok(Self::STRIPE);
        }
        let method = Self::ALL.iter().copied().find(|method| method.name() == name);
        method.ok_or_else(|| Error::Parameter {
            name: "method",
            found: format!("`{name}`"),
            expected: "best, sequential, fewest, cache, input, quad-rows, sgi, stripe, stripe-local, stripe-global, tunnel, eta or guided-tunnels",
        })
    }
}

names! {
    "tristrip::stripify::Objective", Objective, "objective",
    Indices => "indices", "About as few indices as best, in an order that reduces misses";
    Balanced => "balanced", "Fewer misses, as long as they cost few indices";
    Misses => "misses", "The fewest misses";
}

/// Options for stripification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct StripifyOptions {
    /// The method.
    pub method: Method,
    /// The cost that searches minimize.
    pub cost: Cost,
    /// The effort of searches. `None` selects the method's default, which
    /// [`StripifyOptions::effort_or_default`] returns.
    pub effort: Option<Effort>,
    /// The vertex cache that [`Method::Cache`] optimizes for.
    pub vertex_cache: VertexCache,
    /// How [`Method::Cache`] weighs indices against misses.
    pub objective: Objective,
    /// Whether to weld vertices whose position and attributes have the same bits.
    pub weld: bool,
    /// The seed for the random number generator of randomized methods.
    pub seed: u64,
}

/// The default effort of [`Method::Best`] and [`Method::Cache`]: the highest level that takes less
/// than a second per million triangles.
const FAST_EFFORT: Option<Effort> = Effort::new(2);

impl StripifyOptions {
    crate::setters! {
        /// Sets the method.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let strips = |method| stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(method));
        /// let indices = |method| strips(method).map(|strips| strips.index_count(Layout::Restart));
        /// assert!(indices(Method::Best)? < indices(Method::Input)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_method(method: Method);

        /// Sets whether to weld vertices whose position and attributes have the same bits.
        ///
        /// ```
        /// use tristrip::{Faces, Mesh, StripifyOptions, stripify};
        /// // Two triangles that touch along an edge but share no vertex: 3 has the position of 1,
        /// // and 4 that of 2.
        /// let places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        /// let positions = [0, 1, 2, 1, 2, 3].map(|place| places[place]).to_vec();
        /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 4, 3, 5])?)?;
        /// let sent = |weld| stripify(&mesh, &StripifyOptions::default().with_weld(weld)).map(|s| s.vertices_sent());
        /// assert_eq!((sent(false)?, sent(true)?), (6, 4));
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_weld(weld: bool);

        /// Sets the seed for the random number generator of randomized methods.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let method = Method::StripeLocal { triangulation: FaceTriangulation::Whole, ties: Ties::Random };
        /// let options = StripifyOptions::default().with_method(method);
        /// let strips = |seed| stripify_indices_with(&grid, 289, &options.with_seed(seed));
        /// assert_ne!(strips(1)?, strips(2)?);
        /// assert_eq!(strips(2)?, strips(2)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_seed(seed: u64);

        /// Sets the cost that searches minimize.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let metrics = |cost| {
        ///     let strips = stripify_indices_with(&grid, 289, &StripifyOptions::default().with_cost(cost));
        ///     strips.map(|strips| Metrics::of(&strips))
        /// };
        /// // If swaps are free, fewer and longer strips with more swaps are better.
        /// let (restart, gl) = (metrics(Cost::Restart)?, metrics(Cost::Gl)?);
        /// assert!(restart.indices_restart < gl.indices_restart && restart.gl_cost > gl.gl_cost);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_cost(cost: Cost);

        /// Sets the effort of searches. The default depends on the method.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let indices = |options: &StripifyOptions| {
        ///     stripify_indices_with(&grid, 289, options).map(|strips| strips.index_count(Layout::Restart))
        /// };
        /// let options = StripifyOptions::default(); // level 2
        /// assert!(indices(&options.with_effort(Effort::MAX))? < indices(&options)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_effort(effort: Effort) as Some;

        /// Sets the vertex cache that [`Method::Cache`] optimizes for.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let cache = VertexCache::lru(24);
        /// let misses = |options| {
        ///     let strips = stripify_indices_with(&grid, 289, &options);
        ///     strips.map(|strips| VertexCacheStatistics::of(&strips, cache, FlushPolicy::default()).misses)
        /// };
        /// let options = StripifyOptions::default().with_method(Method::Cache);
        /// assert!(misses(options.with_vertex_cache(cache))? < misses(options)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_vertex_cache(vertex_cache: VertexCache);

        /// Sets how [`Method::Cache`] weighs indices against misses.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let options = StripifyOptions::default().with_method(Method::Cache);
        /// let strips = |objective| stripify_indices_with(&grid, 289, &options.with_objective(objective));
        /// let (indices, misses) = (strips(Objective::Indices)?, strips(Objective::Misses)?);
        /// assert!(indices.vertices_sent() < misses.vertices_sent());
        /// let count = |strips| VertexCacheStatistics::of(strips, VertexCache::default(), FlushPolicy::default()).misses;
        /// assert!(count(&indices) > count(&misses));
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_objective(objective: Objective);
    }

    /// Returns the effort that was set, or the default effort of the method.
    ///
    /// ```
    /// use tristrip::{Effort, Method, StripifyOptions};
    /// let options = StripifyOptions::default().with_method(Method::Fewest);
    /// assert_eq!(options.effort_or_default(), Effort::default());
    /// assert_eq!(options.with_effort(Effort::MAX).effort_or_default(), Effort::MAX);
    /// ```
    pub fn effort_or_default(&self) -> Effort {
        let default = if matches!(self.method, Method::Best | Method::Cache) { FAST_EFFORT } else { None };
        self.effort.or(default).unwrap_or_default()
    }
}

/// How [`Method::Cache`] weighs indices against vertex-cache misses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Objective {
    /// Few indices: about as many as [`Method::Best`], in an order that reduces misses.
    Indices,
    /// A balance of both: a miss counts as about two thirds of an index.
    #[default]
    Balanced,
    /// Few misses: a miss counts as four indices.
    Misses,
}
