//! Options of the methods that search for long tunnels.

use crate::names::names;

/// Parameters of the tunnels that [`Method::GuidedTunnels`](super::Method::GuidedTunnels) and
/// [`Method::Eta`](super::Method::Eta) search for. The default values are for `GuidedTunnels`.
///
/// ```
/// use tristrip::{Faces, Mesh, Method, StripifyOptions, stripify};
/// use tristrip::stripify::{TunnelOptions, Start};
/// // A closed fan of six triangles.
/// let corners = (0..6).flat_map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
/// let mesh = Mesh::new(vec![[0.0; 3]; 7], Faces::from_triangles(corners)?)?;
/// let tunnels = TunnelOptions::default().with_length(9).with_start(Start::Isolated);
/// let strips = stripify(&mesh, &StripifyOptions::default().with_method(Method::GuidedTunnels(tunnels)))?;
/// assert_eq!(strips.len(), 1);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct TunnelOptions {
    /// Maximum length of a tunnel, in edges.
    pub length: u32,
    /// Maximum number of triangles visited by a search from one end of a strip.
    pub threshold: u32,
    /// The initial strips.
    pub start: Start,
}

/// The initial strips of [`Method::Eta`](super::Method::Eta) and
/// [`Method::GuidedTunnels`](super::Method::GuidedTunnels).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Start {
    /// Isolated triangles.
    Isolated,
    /// The strips of [`Method::Input`](super::Method::Input), the default of
    /// [`Method::Eta`](super::Method::Eta). The paper does not specify the initial strips. These
    /// strips reproduce its misses per triangle most closely.
    Input,
    /// The strips of [`Method::Sgi`](super::Method::Sgi).
    Sgi,
    /// The strips of [`Method::Sequential`](super::Method::Sequential). From these strips, guided
    /// tunnels take the least time and end with the fewest strips and swaps: 446 strips for dragon,
    /// compared with 461 from isolated triangles.
    #[default]
    Sequential,
}

/// Which tunnels [`Method::Eta`](super::Method::Eta) accepts (Porcu and Scateni 2006, section 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Acceptance {
    /// Depth first: every tunnel up to the maximum length, as it is found.
    #[default]
    DepthFirst,
    /// Depth first with increasing maximum lengths, each about twice the previous one: 49, 99, 199
    /// … up to the given length. Section 6.1 suggests longer tunnels for the strips that remain.
    Repeated,
    /// Breadth first: tunnels of length 1, 3, 5 …. The length increases when no terminal has a
    /// tunnel of the current length.
    BreadthFirst,
}

/// How far [`Method::Eta`](super::Method::Eta) propagates identifiers (Porcu and Scateni 2006,
/// section 4.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Localization {
    /// Within the star of the terminal, and to the ends of the strips when a tunnel is found.
    Star,
    /// Like [`Self::Star`], but the star is computed only when a search without a star has become
    /// long. This takes less time and results in the same strips.
    #[default]
    OnDemand,
    /// To the ends of the strips, at every step of a search.
    None,
}

names! {
    "tristrip::stripify::Acceptance", Acceptance, "acceptance",
    DepthFirst => "depth-first", "Every tunnel up to the maximum length, as it is found";
    Repeated => "repeated", "Depth-first with maximum lengths 49, 99, 199 and so on, up to tunnel-length";
    BreadthFirst => "breadth-first", "Shorter tunnels first, over the whole mesh";
}

names! {
    "tristrip::stripify::Localization", Localization, "localization",
    Star => "star", "Identifiers are written within the star of a search";
    OnDemand => "on-demand", "Like star, but only once a search has become long";
    None => "none", "Identifiers are written to the ends of the strips";
}

names! {
    "tristrip::stripify::Start", Start, "start",
    Isolated => "isolated", "One strip per triangle";
    Input => "input", "The strips of input";
    Sgi => "sgi", "The strips of sgi";
    Sequential => "sequential", "The strips of sequential";
}

/// Tunnels of up to 1000 edges, 512 triangles visited per search, starting from the strips of
/// `sequential`.
impl Default for TunnelOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl TunnelOptions {
    /// The default of [`Method::Eta`](super::Method::Eta): tunnels of up to 199 edges, 1000
    /// triangles visited per search, starting from the strips of `input`. The paper specifies no
    /// defaults; 200 is the only length in its text (section 6.1).
    pub const ETA: Self = Self { length: 199, threshold: 1000, start: Start::Input };

    pub(super) const DEFAULT: Self = Self { length: 1000, threshold: 512, start: Start::Sequential };

    /// Sets the maximum length of a tunnel, in edges.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let strips = |length| {
    ///     let tunnels = TunnelOptions::default().with_start(Start::Isolated).with_length(length);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::GuidedTunnels(tunnels)))
    /// };
    /// assert!(strips(9)?.len() < strips(3)?.len() && strips(3)?.len() < strips(1)?.len());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub const fn with_length(mut self, length: u32) -> Self {
        self.length = length;
        self
    }

    /// Sets the maximum number of triangles visited by a search from one end of a strip.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let strips = |threshold| {
    ///     let tunnels = TunnelOptions::default().with_start(Start::Isolated).with_threshold(threshold);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::GuidedTunnels(tunnels)))
    /// };
    /// assert!(strips(512)?.len() < strips(1)?.len());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub const fn with_threshold(mut self, threshold: u32) -> Self {
        self.threshold = threshold;
        self
    }

    /// Sets the initial strips.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let swaps = |start| {
    ///     let tunnels = Method::GuidedTunnels(TunnelOptions::default().with_start(start));
    ///     let strips = stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(tunnels));
    ///     strips.map(|strips| Metrics::of(&strips).swaps)
    /// };
    /// assert!(swaps(Start::Sequential)? < swaps(Start::Isolated)?);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub const fn with_start(mut self, start: Start) -> Self {
        self.start = start;
        self
    }
}
