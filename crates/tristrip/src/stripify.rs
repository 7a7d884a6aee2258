//! Strips from a mesh: the methods, their options, and the stages that they share.
//!
//! Every method only chooses: which diagonals a polygon gets, and over which edges the triangles are linked to paths. What a
//! method chose is a [`Plan`]; one emitter makes the strips of it.

pub mod bound;
mod cache;
mod fewest;
pub mod input;
pub mod random;
pub(crate) mod refine;
pub mod sequential;
pub mod sgi;
pub mod stripe;
pub mod tunnel;
pub mod watch;

use crate::cover::PathCover;
use crate::dual::{DualGraph, FaceId};
use crate::error::Error;
use crate::mesh::{Mesh, Surface, Triangulation};
use crate::strip::{Buffer, Cost, Metrics, Strips, cover_cost, emit, emit_in_order};
pub use cache::Prefer;
pub use tunnel::{EtaOptions, Start};
pub use watch::{Progress, Watch};

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
pub struct Options {
    method: Method,
    weld: bool,
    seed: u64,
    cost: Cost,
    effort: Option<Effort>,
    buffer: Buffer,
    prefer: Prefer,
}

/// How long a search goes on, from 0 to 9. It counts steps, never seconds, so that the result is the same on any machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Effort(u8);

impl Effort {
    /// The longest search.
    pub const MAX: Self = Self(9);

    /// Takes a level from 0 to 9; `None` above.
    pub fn new(level: u8) -> Option<Self> {
        (level <= Self::MAX.0).then_some(Self(level))
    }

    /// Gives the level.
    pub fn level(self) -> u8 {
        self.0
    }
}

/// About a second for 100,000 triangles.
impl Default for Effort {
    fn default() -> Self {
        Self(5)
    }
}

/// What [`Method::Auto`] searches: the most that takes less than a second for a million triangles.
const AUTO_EFFORT: Effort = Effort(2);

impl Options {
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
    pub fn with_buffer(mut self, buffer: Buffer) -> Self {
        self.buffer = buffer;
        self
    }

    /// Sets what [`Method::Cache`] prefers where indices and misses are at odds.
    #[must_use]
    pub fn with_prefer(mut self, prefer: Prefer) -> Self {
        self.prefer = prefer;
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
    pub fn buffer(&self) -> Buffer {
        self.buffer
    }

    /// Gives what is preferred where indices and misses are at odds.
    pub fn prefer(&self) -> Prefer {
        self.prefer
    }

    /// Gives how long searches go on.
    pub fn effort(&self) -> Effort {
        let usual =
            if matches!(self.method, Method::Auto | Method::Cache) { AUTO_EFFORT } else { Effort::default() };
        self.effort.unwrap_or(usual)
    }
}

/// What a method chose: a triangulation and a cover of it.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The triangles.
    pub triangulation: Triangulation<'a>,
    /// The paths over them.
    pub cover: PathCover,
    /// The triangle with which each path begins, the paths as they are drawn; `None` leaves order and direction to the emitter.
    pub order: Option<Vec<FaceId>>,
}

impl<'a> Plan<'a> {
    /// Leaves the paths' order and direction to the emitter.
    pub fn new(triangulation: Triangulation<'a>, cover: PathCover) -> Self {
        Self { triangulation, cover, order: None }
    }

    /// Makes the strips.
    pub fn strips(&self) -> Strips {
        match &self.order {
            Some(order) => emit_in_order(&self.triangulation, &self.cover, order),
            None => emit(&self.triangulation, &self.cover),
        }
    }

    /// Counts the indices of the strips with restarts between them, as [`Plan::strips`] sends them.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, Options, Surface, stripify::plan};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 4], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
    /// let surface = Surface::new(&mesh, false);
    /// let graph = DualGraph::new(surface.faces());
    /// assert_eq!(plan(&surface, &graph, &Options::default())?.indices_restart(), 4);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices_restart(&self) -> usize {
        match &self.order {
            Some(_) => Metrics::of(&self.strips()).indices_restart,
            None => cover_cost(self.triangulation.graph(), &self.cover).saturating_sub(1),
        }
    }
}

/// Finds triangle strips for a mesh: the whole way from faces to strips.
///
/// # Errors
/// An option makes no sense for the method.
///
/// ```
/// use tristrip::{Faces, Mesh, Options, stripify, strip::verify};
/// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(corners, Faces::from_polygons([[0, 1, 2, 3]])?)?;
/// let strips = stripify(&mesh, &Options::default())?;
/// assert_eq!(strips.vertices_sent(), 4);
/// assert!(verify(&mesh, &strips).is_ok());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn stripify(mesh: &Mesh, options: &Options) -> Result<Strips, Error> {
    let surface = Surface::new(mesh, options.weld);
    let graph = DualGraph::new(surface.faces());
    let plan = plan(&surface, &graph, options)?;
    Ok(plan.strips())
}

/// Lets a method choose: the stage between the dual graph and the strips.
///
/// # Errors
/// An option makes no sense for the method.
pub fn plan<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    options: &Options,
) -> Result<Plan<'a>, Error> {
    choose(surface, graph, options).map(|(_, plan)| plan)
}

/// Lets a method choose, and says which method it was: for [`Method::Auto`] the one that it stands for, else the one that was
/// asked for.
///
/// # Errors
/// An option makes no sense for the method.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, Method, Options, Surface, stripify::choose};
/// // A fan in an order that no strip takes.
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let surface = Surface::new(&mesh, false);
/// let graph = DualGraph::new(surface.faces());
/// let (method, plan) = choose(&surface, &graph, &Options::default())?;
/// assert_eq!((method, plan.indices_restart()), (Method::Best, 5));
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn choose<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    options: &Options,
) -> Result<(Method, Plan<'a>), Error> {
    choose_watched(surface, graph, options, &())
}

/// Lets a method choose as [`choose`] does, under a watcher that takes notice of a long search's progress and may stop it. A search
/// that is stopped gives the best that it has.
///
/// # Errors
/// An option makes no sense for the method.
///
/// ```
/// use std::sync::atomic::{AtomicU64, Ordering};
/// use tristrip::{DualGraph, Faces, Mesh, Method, Options, Surface};
/// use tristrip::stripify::{Progress, Watch, choose_watched};
///
/// struct Impatient(AtomicU64);
/// impl Watch for Impatient {
///     fn go_on(&self, progress: Progress) -> bool {
///         self.0.fetch_max(progress.steps, Ordering::Relaxed) < 1000
///     }
/// }
///
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let surface = Surface::new(&mesh, false);
/// let graph = DualGraph::new(surface.faces());
/// let options = Options::default().with_method(Method::Best);
/// let (_, plan) = choose_watched(&surface, &graph, &options, &Impatient(AtomicU64::new(0)))?;
/// assert_eq!(plan.indices_restart(), 5);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn choose_watched<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    options: &Options,
    watch: &dyn Watch,
) -> Result<(Method, Plan<'a>), Error> {
    let plan = match options.method {
        Method::Sequential => sequential::plan(surface, graph),
        Method::Auto | Method::Best => {
            refine::plan(surface, graph, options.cost, options.effort(), options.seed, watch)
        }
        Method::Fewest => fewest::plan(surface, graph, options.effort(), options.seed, watch),
        Method::Cache => cache::plan(surface, graph, options, watch),
        Method::Input => input::plan(surface, graph),
        Method::Sgi => sgi::plan(surface, graph),
        Method::StripeLocal { triangulation, ties } => {
            stripe::plan_local(surface, graph, triangulation, ties, options.seed)
        }
        Method::StripeGlobal { patches, cutoff } => {
            stripe::plan_global(surface, graph, patches, cutoff, options.seed)?
        }
        Method::Tunnel { length } => tunnel::plan_tunnel(surface, graph, length, watch),
        Method::Eta(eta) => tunnel::plan_eta(surface, graph, eta, options.seed, watch),
    };
    let taken = if options.method == Method::Auto { Method::Best } else { options.method };
    Ok((taken, plan))
}
