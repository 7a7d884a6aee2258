//! The options of guided tunnels, and the strips that tunnels start from.

use crate::names::names;

/// The options of [`Method::GuidedTunnels`](super::Method::GuidedTunnels).
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
pub struct TunnelOptions {
    length: u32,
    threshold: u32,
    start: Start,
}

/// The initial strips of [`Method::Eta`](super::Method::Eta) and [`Method::GuidedTunnels`](super::Method::GuidedTunnels).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Start {
    /// Isolated triangles.
    Isolated,
    /// The strips of [`Method::Input`](super::Method::Input), with which [`Method::Eta`](super::Method::Eta) starts by default: its paper does not name
    /// its first phase, and from these strips the misses per triangle are nearest to the paper's.
    Input,
    /// The strips of [`Method::Sgi`](super::Method::Sgi).
    Sgi,
    /// The strips of [`Method::Sequential`](super::Method::Sequential), which lead guided tunnels to the fewest strips and swaps in the shortest time:
    /// 446 strips for dragon, compared with 461 from isolated triangles.
    #[default]
    Sequential,
}

names! {
    "tristrip::stripify::Start", Start, "start",
    Isolated => "isolated", "One strip per triangle";
    Input => "input", "The strips of input";
    Sgi => "sgi", "The strips of sgi";
    Sequential => "sequential", "The strips of sequential";
}

/// Tunnels of up to 1000 edges, 512 node accesses per search, starting from the strips of `sequential`.
impl Default for TunnelOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl TunnelOptions {
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
    pub fn with_length(mut self, length: u32) -> Self {
        self.length = length;
        self
    }

    /// Sets the maximum number of node accesses of a search from one path end.
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
    pub fn with_threshold(mut self, threshold: u32) -> Self {
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
    pub fn with_start(mut self, start: Start) -> Self {
        self.start = start;
        self
    }

    /// Returns the maximum length of a tunnel, in edges.
    ///
    /// ```
    /// use tristrip::stripify::TunnelOptions;
    /// assert_eq!(TunnelOptions::default().length(), 1000);
    /// assert_eq!(TunnelOptions::default().with_length(9).length(), 9);
    /// ```
    pub fn length(&self) -> u32 {
        self.length
    }

    /// Returns the maximum number of node accesses of a search from one path end.
    ///
    /// ```
    /// use tristrip::stripify::TunnelOptions;
    /// assert_eq!(TunnelOptions::default().threshold(), 512);
    /// assert_eq!(TunnelOptions::default().with_threshold(64).threshold(), 64);
    /// ```
    pub fn threshold(&self) -> u32 {
        self.threshold
    }

    /// Returns the initial strips.
    ///
    /// ```
    /// use tristrip::stripify::{TunnelOptions, Start};
    /// assert_eq!(TunnelOptions::default().start(), Start::Sequential);
    /// assert_eq!(TunnelOptions::default().with_start(Start::Sgi).start().name(), "sgi");
    /// ```
    pub fn start(&self) -> Start {
        self.start
    }
}
