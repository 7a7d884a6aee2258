//! The bits spent on each component of a stream.

/// The bits spent on each component of a stream.
///
/// ```
/// use tristrip::stream::StreamCosts;
/// let costs = StreamCosts { marks: 2.0, corners: 3.0, ..StreamCosts::default() };
/// assert_eq!(costs.connectivity(), 5.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StreamCosts {
    /// The base mesh, with its positions and attributes.
    pub base: f64,
    /// Marks: which vertices are split.
    pub marks: f64,
    /// Corners: which corners of split vertices move.
    pub corners: f64,
    /// The positions of new points.
    pub positions: f64,
    /// Additional position bits of existing points.
    pub precision: f64,
    /// The attributes of new vertices.
    pub attributes: f64,
}

impl StreamCosts {
    /// Returns the bits of the connectivity: marks plus corners.
    ///
    /// ```
    /// use tristrip::stream::StreamCosts;
    /// let costs = StreamCosts { marks: 1.5, corners: 3.0, positions: 20.0, ..StreamCosts::default() };
    /// assert_eq!(costs.connectivity(), 4.5);
    /// ```
    pub fn connectivity(&self) -> f64 {
        self.marks + self.corners
    }

    /// Adds the costs of another mesh.
    ///
    /// ```
    /// use tristrip::stream::StreamCosts;
    /// let mut costs = StreamCosts { base: 100.0, ..StreamCosts::default() };
    /// costs.add(&StreamCosts { base: 50.0, marks: 2.0, ..StreamCosts::default() });
    /// assert_eq!((costs.base, costs.marks), (150.0, 2.0));
    /// ```
    pub fn add(&mut self, other: &Self) {
        self.base += other.base;
        self.marks += other.marks;
        self.corners += other.corners;
        self.positions += other.positions;
        self.precision += other.precision;
        self.attributes += other.attributes;
    }
}
