//! The options of the enhanced tunnelling algorithm.

use super::Start;
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
    acceptance: Acceptance,
    localization: Localization,
}

/// Which tunnels [`Method::Eta`](super::Method::Eta) accepts (Porcu and Scateni 2006, section 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Acceptance {
    /// Every tunnel up to the maximum length, as it is found.
    #[default]
    DepthFirst,
    /// The same for one maximum length after the other, each about twice the last: 49, 99, 199 … up to the one given: section 6.1 suggests
    /// longer tunnels where strips are left.
    Repeated,
    /// Tunnels of length 1, 3, 5 …: the next length when no terminal has a tunnel of the last.
    BreadthFirst,
}

/// How far [`Method::Eta`](super::Method::Eta) writes identifiers (Porcu and Scateni 2006, section 4.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Localization {
    /// Within the star of the terminal; to the ends of the strips when a tunnel is found.
    Star,
    /// The same, but a star is found only when a search without it has become long. The strips are the same, in less time.
    #[default]
    OnDemand,
    /// To the ends of the strips, at every step of a search.
    None,
}

names! {
    "tristrip::stripify::Acceptance", Acceptance, "acceptance",
    DepthFirst => "depth-first", "Every tunnel up to the maximum length, as it is found";
    Repeated => "repeated", "The same with maximum lengths 49, 99, 199 … up to the one given";
    BreadthFirst => "breadth-first", "Shorter tunnels first, over the whole mesh";
}

names! {
    "tristrip::stripify::Localization", Localization, "localization",
    Star => "star", "Identifiers are written within the star of a search";
    OnDemand => "on-demand", "The same; a star is found when a search becomes long";
    None => "none", "Identifiers are written to the ends of the strips";
}

/// Tunnels of up to 199 edges, 1000 triangles stepped on per search, every tunnel accepted, stars on demand, from the strips of `input`. The paper
/// names no defaults; 200 is the only length in its text (section 6.1).
impl Default for EtaOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl EtaOptions {
    pub(super) const DEFAULT: Self = Self {
        length: 199,
        threshold: 1000,
        start: Start::Input,
        acceptance: Acceptance::DepthFirst,
        localization: Localization::OnDemand,
    };

    /// Sets the maximum length of a tunnel, in edges: the k of the paper.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let strips = |length| {
    ///     let eta = EtaOptions::default().with_start(Start::Isolated).with_length(length);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::Eta(eta)))
    /// };
    /// assert!(strips(9)?.len() < strips(1)?.len());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub fn with_length(mut self, length: u32) -> Self {
        self.length = length;
        self
    }

    /// Sets the maximum number of triangles that the paths of a search step on: the access threshold of section 4.2.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let strips = |threshold| {
    ///     let eta = EtaOptions::default().with_start(Start::Isolated).with_threshold(threshold);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::Eta(eta)))
    /// };
    /// assert!(strips(1000)?.len() < strips(1)?.len());
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

    /// Sets which tunnels are accepted.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let strips = |acceptance| {
    ///     let eta = EtaOptions::default().with_length(9).with_start(Start::Isolated).with_acceptance(acceptance);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::Eta(eta)))
    /// };
    /// assert_ne!(strips(Acceptance::DepthFirst)?, strips(Acceptance::BreadthFirst)?);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub fn with_acceptance(mut self, acceptance: Acceptance) -> Self {
        self.acceptance = acceptance;
        self
    }

    /// Sets how far identifiers are written. The strips are the same.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let strips = |localization| {
    ///     let eta = EtaOptions::default().with_length(9).with_localization(localization);
    ///     stripify_indices_with(&grid, 289, &StripifyOptions::default().with_method(Method::Eta(eta)))
    /// };
    /// assert_eq!(strips(Localization::OnDemand)?, strips(Localization::None)?);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub fn with_localization(mut self, localization: Localization) -> Self {
        self.localization = localization;
        self
    }

    /// Returns the maximum length of a tunnel, in edges.
    ///
    /// ```
    /// use tristrip::stripify::EtaOptions;
    /// assert_eq!(EtaOptions::default().length(), 199);
    /// ```
    pub fn length(&self) -> u32 {
        self.length
    }

    /// Returns the maximum number of triangles that the paths of a search step on.
    ///
    /// ```
    /// use tristrip::stripify::EtaOptions;
    /// assert_eq!(EtaOptions::default().threshold(), 1000);
    /// ```
    pub fn threshold(&self) -> u32 {
        self.threshold
    }

    /// Returns the initial strips.
    ///
    /// ```
    /// use tristrip::stripify::{EtaOptions, Start};
    /// assert_eq!(EtaOptions::default().start(), Start::Input);
    /// ```
    pub fn start(&self) -> Start {
        self.start
    }

    /// Returns which tunnels are accepted.
    ///
    /// ```
    /// use tristrip::stripify::{Acceptance, EtaOptions};
    /// assert_eq!(EtaOptions::default().acceptance(), Acceptance::DepthFirst);
    /// ```
    pub fn acceptance(&self) -> Acceptance {
        self.acceptance
    }

    /// Returns how far identifiers are written.
    ///
    /// ```
    /// use tristrip::stripify::{EtaOptions, Localization};
    /// assert_eq!(EtaOptions::default().localization(), Localization::OnDemand);
    /// ```
    pub fn localization(&self) -> Localization {
        self.localization
    }
}
