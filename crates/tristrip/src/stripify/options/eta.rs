//! The options of the enhanced tunnelling algorithm.

use crate::names::names;

/// The options of [`Method::Eta`](super::Method::Eta).
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

/// The initial strips of [`Method::Eta`](super::Method::Eta).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Start {
    /// Isolated triangles.
    Isolated,
    /// The strips of [`Method::Input`](super::Method::Input). The paper starts from strips of a first phase that it does not name; from these strips, the
    /// misses per triangle are within 0.02 of the paper's on all six available models of its tables.
    Input,
    /// The strips of [`Method::Sgi`](super::Method::Sgi).
    Sgi,
    /// The strips of [`Method::Sequential`](super::Method::Sequential), which lead to the fewest strips and swaps in the shortest time: 446 strips for
    /// dragon, compared with 461 from isolated triangles.
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
impl Default for EtaOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl EtaOptions {
    pub(super) const DEFAULT: Self = Self { length: 1000, threshold: 512, start: Start::Sequential };

    /// Sets the maximum length of a tunnel, in edges.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let strips = |length| {
    ///     let eta = EtaOptions::default().with_start(Start::Isolated).with_length(length);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::Eta(eta)))
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
    ///     let eta = EtaOptions::default().with_start(Start::Isolated).with_threshold(threshold);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::Eta(eta)))
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
    ///     let eta = Method::Eta(EtaOptions::default().with_start(start));
    ///     let strips = stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(eta));
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
    /// use tristrip::stripify::EtaOptions;
    /// assert_eq!(EtaOptions::default().length(), 1000);
    /// assert_eq!(EtaOptions::default().with_length(9).length(), 9);
    /// ```
    pub fn length(&self) -> u32 {
        self.length
    }

    /// Returns the maximum number of node accesses of a search from one path end.
    ///
    /// ```
    /// use tristrip::stripify::EtaOptions;
    /// assert_eq!(EtaOptions::default().threshold(), 512);
    /// assert_eq!(EtaOptions::default().with_threshold(64).threshold(), 64);
    /// ```
    pub fn threshold(&self) -> u32 {
        self.threshold
    }

    /// Returns the initial strips.
    ///
    /// ```
    /// use tristrip::stripify::{EtaOptions, Start};
    /// assert_eq!(EtaOptions::default().start(), Start::Sequential);
    /// assert_eq!(EtaOptions::default().with_start(Start::Sgi).start().name(), "sgi");
    /// ```
    pub fn start(&self) -> Start {
        self.start
    }
}
