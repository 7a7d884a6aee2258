//! The methods and their options.

use crate::effort::Effort;
use crate::strip::Cost;
use crate::vertex_cache::VertexCache;

/// How strips are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Method {
    /// `Best`, at an effort that takes less than a second for a million triangles unless told otherwise.
    #[default]
    Auto,
    /// Ours: cheapest runs first, swaps only where they beat a restart, both ways, isolated triangles folded in.
    Sequential,
    /// Ours: annealing from `sequential`, for a cost and an effort.
    Best,
    /// Ours: as few strips as can be found, whatever the swaps.
    Fewest,
    /// Ours: strips in an order that respects a vertex buffer, grown along the border of what is drawn.
    Cache,
    /// The input's own order.
    Input,
    /// The SGI algorithm: least adjacency, one level of look-ahead.
    Sgi,
    /// STRIPE's local algorithms.
    StripeLocal {
        /// When polygons are cut into triangles.
        triangulation: FaceTriangulation,
        /// Which of several neighbours of least adjacency is taken.
        ties: Ties,
    },
    /// STRIPE's global algorithms: patches of quadrilaterals first, the rest locally.
    StripeGlobal {
        /// How patches become strips.
        patches: Patches,
        /// The smallest patch, in quadrilaterals, that is treated as one.
        cutoff: u32,
    },
    /// The tunnelling operator, lengths 1, 3, 5 … in turn, from isolated triangles.
    Tunnel {
        /// The greatest length of a tunnel, in edges. The time grows as its exponential.
        length: u32,
    },
    /// The enhanced tunnelling algorithm: long tunnels, and terminals that move toward each other.
    Eta(EtaOptions),
}

impl Method {
    /// STRIPE as its authors recommend it: rows or columns of patches of at least 5 quadrilaterals.
    pub const STRIPE: Self = Self::StripeGlobal { patches: Patches::Rows, cutoff: 5 };
}

/// When STRIPE cuts polygons into triangles (Evans et al. 1996, section 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FaceTriangulation {
    /// Before, by alternate left and right turns.
    Static,
    /// Wholly, when a strip enters the face.
    #[default]
    Whole,
    /// Only as far as the strip needs to leave the face where it wants to.
    Partial,
}

/// Which of several neighbours of least adjacency STRIPE takes (Evans et al. 1996, section 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Ties {
    /// The first found.
    Arbitrary,
    /// The one whose neighbours have the least adjacency.
    LookAhead,
    /// The one on the other side than last time.
    Alternate,
    /// One at random, by the seed.
    Random,
    /// One that needs no swap, else one at random.
    #[default]
    Sequential,
}

/// How STRIPE's patches become strips (Evans et al. 1996, section 3.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Patches {
    /// A strip for each row, or column, whichever makes longer strips.
    #[default]
    Rows,
    /// A strip for each patch, extended backward and forward.
    Full,
}

/// What a caller may choose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct StripifyOptions {
    method: Method,
    weld: bool,
    seed: u64,
    cost: Cost,
    effort: Option<Effort>,
    vertex_cache: VertexCache,
    objective: Objective,
}

/// What [`Method::Auto`] searches: the most that takes less than a second for a million triangles.
const AUTO_EFFORT: Option<Effort> = Effort::new(2);

impl StripifyOptions {
    /// Chooses the method.
    #[must_use]
    pub fn with_method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// Lets vertices with the same bits in position and all attributes stand for each other.
    #[must_use]
    pub fn with_weld(mut self, weld: bool) -> Self {
        self.weld = weld;
        self
    }

    /// Sets the seed of methods that choose at random.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Sets the cost that searches minimize.
    #[must_use]
    pub fn with_cost(mut self, cost: Cost) -> Self {
        self.cost = cost;
        self
    }

    /// Sets how long searches go on; the default depends on the method.
    #[must_use]
    pub fn with_effort(mut self, effort: Effort) -> Self {
        self.effort = Some(effort);
        self
    }

    /// Sets the vertex buffer that [`Method::Cache`] respects.
    #[must_use]
    pub fn with_vertex_cache(mut self, vertex_cache: VertexCache) -> Self {
        self.vertex_cache = vertex_cache;
        self
    }

    /// Sets what [`Method::Cache`] prefers where indices and misses are at odds.
    #[must_use]
    pub fn with_objective(mut self, objective: Objective) -> Self {
        self.objective = objective;
        self
    }

    /// Gives the method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Tells whether vertices with the same bits stand for each other.
    pub fn weld(&self) -> bool {
        self.weld
    }

    /// Gives the seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Gives the cost that searches minimize.
    pub fn cost(&self) -> Cost {
        self.cost
    }

    /// Gives the vertex buffer that strips shall respect.
    pub fn vertex_cache(&self) -> VertexCache {
        self.vertex_cache
    }

    /// Gives what is preferred where indices and misses are at odds.
    pub fn objective(&self) -> Objective {
        self.objective
    }

    /// Gives how long searches go on.
    pub fn effort(&self) -> Effort {
        let usual = if matches!(self.method, Method::Auto | Method::Cache) { AUTO_EFFORT } else { None };
        self.effort.or(usual).unwrap_or_default()
    }
}

/// What is weighed more where indices and misses are at odds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Objective {
    /// Few indices: about those of [`Best`](super::Method::Best), in an order that saves misses.
    Indices,
    /// Both: misses are saved as long as each takes less than about two thirds of an index.
    #[default]
    Balanced,
    /// Few misses: one counts as four indices.
    Misses,
}

/// What a caller of `eta` may choose.
///
/// ```
/// use tristrip::{Faces, Mesh, Method, StripifyOptions, stripify};
/// use tristrip::stripify::{EtaOptions, Start};
/// // A closed fan of six triangles.
/// let corners = (0..6).flat_map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
/// let mesh = Mesh::new(vec![[0.0; 3]; 7], Faces::from_triangles(corners)?)?;
/// let eta = EtaOptions::default().with_length(9).with_start(Start::Isolated);
/// let strips = stripify(&mesh, &StripifyOptions::default().with_method(Method::Eta(eta)))?;
/// assert_eq!(strips.len(), 1);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct EtaOptions {
    length: u32,
    threshold: u32,
    start: Start,
}

/// The strips that `eta` starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Start {
    /// Every triangle by itself.
    Isolated,
    /// Those of [`Method::Input`](super::Method::Input). The paper shows strips of a first phase and does not say which; from these the
    /// misses per triangle are within 0.02 of its own on all six models of its tables that are at hand.
    Input,
    /// Those of [`Method::Sgi`](super::Method::Sgi).
    Sgi,
    /// Those of [`Method::Sequential`](super::Method::Sequential), which leave the fewest strips, soonest, and the fewest swaps: dragon
    /// comes to 446, from isolated triangles to 461.
    #[default]
    Sequential,
}

/// Tunnels of up to 1000 edges, 512 accesses to nodes a search, from the strips of `sequential`.
impl Default for EtaOptions {
    fn default() -> Self {
        Self { length: 1000, threshold: 512, start: Start::default() }
    }
}

impl EtaOptions {
    /// Sets the greatest length of a tunnel, in edges.
    #[must_use]
    pub fn with_length(mut self, length: u32) -> Self {
        self.length = length;
        self
    }

    /// Sets the accesses to nodes after which the search from a terminal is given up.
    #[must_use]
    pub fn with_threshold(mut self, threshold: u32) -> Self {
        self.threshold = threshold;
        self
    }

    /// Sets the strips that it starts from.
    #[must_use]
    pub fn with_start(mut self, start: Start) -> Self {
        self.start = start;
        self
    }

    /// Gives the greatest length of a tunnel, in edges.
    pub fn length(&self) -> u32 {
        self.length
    }

    /// Gives the accesses to nodes after which the search from a terminal is given up.
    pub fn threshold(&self) -> u32 {
        self.threshold
    }

    /// Gives the strips that it starts from.
    pub fn start(&self) -> Start {
        self.start
    }
}
