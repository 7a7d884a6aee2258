//! Options of a simplification, and the weights of vertex attributes.

use std::str::FromStr;

use crate::error::Error;
use crate::names::names;
use crate::simplify::surface::topology::MAX_TRIANGLES;
use crate::text::counted;

/// How much vertex attributes count relative to the distance between the surfaces. A weight of 0
/// ignores the attribute.
///
/// At a weight of 1:
/// - a normal (`NORMAL`) that deviates by one radian counts as much as a distance of 0.042 times
///   the longest side of the bounding box; for a tangent (`TANGENT`), the factor is 0.03;
/// - a colour (`COLOR_n`) that deviates by 1 counts as much as a distance of 0.1 times that side;
/// - texture coordinates (`TEXCOORD_n`) count as much as 1.5 times the distance by which the
///   texture shifts on the surface;
/// - a skin (`JOINTS_n`, `WEIGHTS_n`) counts as much as the resulting difference in the
///   displacement of a vertex when a joint turns by a tenth of a radian.
///
/// ```
/// use tristrip::simplify::{AttributeWeights, SimplifyOptions};
/// let only_texture = AttributeWeights { uv: 1.0, ..AttributeWeights::NONE };
/// let options = SimplifyOptions::default().with_weights(only_texture);
/// assert_eq!((options.weights.normal, options.weights.uv), (0.0, 1.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttributeWeights {
    /// The weight of normals.
    pub normal: f32,
    /// The weight of texture coordinates.
    pub uv: f32,
    /// The weight of colours.
    pub colour: f32,
    /// The weight of tangents.
    pub tangent: f32,
    /// The weight of skin joints and their weights.
    pub skin: f32,
}

impl AttributeWeights {
    /// Ignores all attributes; only the distance between the surfaces counts.
    ///
    /// ```
    /// use tristrip::simplify::AttributeWeights;
    /// assert_eq!("normal=0,uv=0,colour=0,tangent=0,skin=0".parse(), Ok(AttributeWeights::NONE));
    /// ```
    pub const NONE: Self = Self::all(0.0);

    const fn all(weight: f32) -> Self {
        Self { normal: weight, uv: weight, colour: weight, tangent: weight, skin: weight }
    }

    /// Returns the weights with their names.
    fn named(&mut self) -> [(&'static str, &mut f32); 5] {
        let Self { normal, uv, colour, tangent, skin } = self;
        [("normal", normal), ("uv", uv), ("colour", colour), ("tangent", tangent), ("skin", skin)]
    }
}

impl Default for AttributeWeights {
    fn default() -> Self {
        Self::all(1.0)
    }
}

impl FromStr for AttributeWeights {
    type Err = Error;

    /// Parses weights such as `normal=2,uv=0.5`. Attributes that are not named have a weight of 1,
    /// so an empty string means the default weights.
    ///
    /// # Errors
    /// A name is unknown, or a weight is negative, infinite or not a number.
    fn from_str(text: &str) -> Result<Self, Error> {
        let mut weights = Self::default();
        for part in text.split(',').filter(|part| !part.trim().is_empty()) {
            let unknown = || Error::Parameter {
                name: "weight",
                found: format!("`{}`", part.trim()),
                expected: "normal, uv, colour, tangent or skin with a number of at least 0, such as uv=0.5",
            };
            let (name, value) = part.split_once('=').ok_or_else(unknown)?;
            let value: f32 = value.trim().parse().map_err(|_| unknown())?;
            if !value.is_finite() || value < 0.0 {
                return Err(unknown());
            }
            let named = weights.named().into_iter().find(|(known, _)| *known == name.trim());
            *named.ok_or_else(unknown)?.1 = value;
        }
        Ok(weights)
    }
}

/// How the cost of a collapse is computed. The cost determines the order of collapses and the
/// error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Price {
    /// Uses the distances of all removed vertices from the triangles, and the distances between old
    /// and new triangles.
    #[default]
    Distance,
    /// Uses only the distances from the planes of the full mesh. This takes about a third of the
    /// time. The mean distance between the surfaces is about a third larger. The maximum distance
    /// is unknown: it exceeds the reported error where triangles bridge a valley.
    Planes,
    /// Uses the quadrics of Garland and Heckbert 1997, as Kim et al. 2005 do. The cost is the sum
    /// of the squared distances from the planes of both points, and planes along borders have a
    /// weight of 1000. The error is the square root of this sum. The globally cheapest collapse is
    /// applied next. Attributes are ignored. The simplification runs on one thread.
    Quadric,
}

impl Price {
    /// Returns the cost that corresponds to a length: its cube, or its square for
    /// [`Price::Quadric`].
    ///
    /// ```
    /// use tristrip::simplify::Price;
    /// assert_eq!(Price::ALL.map(|price| price.cost_unit(10.0)), [1000.0, 1000.0, 100.0]);
    /// ```
    pub fn cost_unit(self, length: f64) -> f64 {
        match self {
            Self::Distance | Self::Planes => length * length * length,
            Self::Quadric => length * length,
        }
    }
}

names! {
    "tristrip::simplify::Price", Price, "price",
    Distance => "distance", "Distances of all removed vertices from the triangles, and between old and new triangles";
    Planes => "planes", "Distances from the planes of the full mesh only: a third of the time, larger distances";
    Quadric => "quadric", "Quadric error metrics as published in 1997: globally cheapest pair first; attributes are ignored";
}

/// Options of a simplification. Without limits, a mesh is simplified as far as its topology allows.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct SimplifyOptions {
    /// The target number of triangles.
    pub triangle_count: usize,
    /// The maximum error of a collapse, in mesh units; `None` for no limit.
    pub error: Option<f32>,
    /// Whether each vertex is locked. Vertices after the last value are not locked.
    pub locked: Vec<bool>,
    /// Error factors, one per vertex; see [`SimplifyOptions::with_error_factors`].
    pub error_factors: Vec<f32>,
    /// Whether vertices at the borders of the surface are locked.
    pub locked_borders: bool,
    /// For each vertex, the error of removing its whole component, in mesh units; see
    /// [`SimplifyOptions::with_vanishing`].
    pub vanishing: Vec<f32>,
    /// Whether collapses may change the topology and move seams.
    pub permissive: bool,
    /// How much attributes count relative to the distance between the surfaces.
    pub weights: AttributeWeights,
    /// How the cost of a collapse is computed.
    pub price: Price,
    /// The distance up to which vertices at open borders are joined, in mesh units. 0 joins only
    /// vertices at equal positions.
    pub weld_distance: f32,
}

impl SimplifyOptions {
    crate::setters! {
        /// Stops at this many triangles, or one fewer: a collapse can remove two.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let simplified = simplify(&grid, &SimplifyOptions::default().with_triangles(20))?;
        /// assert!((19..=20).contains(&simplified.mesh.faces().face_count()));
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_triangles(triangle_count: usize);

        /// Rejects collapses with a larger error, in mesh units; see
        /// [`Collapse::error`](crate::collapse::Collapse::error).
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let triangles = |error| {
        ///     let simplified = simplify(&grid, &SimplifyOptions::default().with_error(error))?;
        ///     Ok::<_, Error>(simplified.mesh.faces().face_count())
        /// };
        /// // The peak is kept if the error limit is below its height.
        /// assert!(triangles(0.5)? > triangles(2.0)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_error(error: f32) as Some;

        /// Locks vertices, one value per vertex. Vertices after the last value are not locked.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let kept = |options| simplify(&grid, &options).map(|simplified| simplified.vertices);
        /// // All vertices of the first row are kept.
        /// let locked = SimplifyOptions::default().with_locked(vec![true; 9]);
        /// assert_eq!(kept(locked)?[..9], [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        /// assert!(kept(SimplifyOptions::default())?.len() < 9);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_locked(locked: Vec<bool>);

        /// Sets a factor per vertex that scales errors while the collapses of a
        /// [batch](super::refinement_batches) are chosen. For example, distant vertices are removed
        /// earlier if the factors decrease with the distance from the eye. Vertices after the last
        /// value have the factor 1. The reported errors of levels are not scaled. Other
        /// simplifications ignore the factors.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// use tristrip::simplify::refinement_batches;
        /// // Errors on the left are weighted ten times.
        /// let factors = grid.positions().iter().map(|p| if p[0] < 4.0 { 10.0 } else { 1.0 }).collect();
        /// let options = SimplifyOptions::default().with_error_factors(factors);
        /// let tree = refinement_batches(&grid, grid.faces().corners().to_vec(), &options)?;
        /// assert!(tree.sequence.len() > 40);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_error_factors(error_factors: Vec<f32>);

        /// Locks the vertices at the borders of the surface. For example, terrain tiles then still
        /// match along their borders after simplification.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let options = SimplifyOptions::default().with_locked_borders(true);
        /// let kept = simplify(&grid, &options)?.vertices;
        /// // The first row, and the first and last vertex of the second row.
        /// assert!((0..10).chain([17]).all(|v| kept.contains(&v)));
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_locked_borders(locked_borders: bool);

        /// Allows components to vanish. Each value is the error of removing the vertex's whole
        /// component, in mesh units. Vertices with a missing, negative or NaN value keep one
        /// triangle of their component.
        ///
        /// ```
        /// use tristrip::{Faces, Mesh, simplify::{SimplifyOptions, simplify}};
        /// // A triangle, and a small one 0.1 above it.
        /// let corners = vec![[0., 0., 0.], [9., 0., 0.], [0., 9., 0.], [1., 1., 0.1], [1.1, 1., 0.1], [1., 1.1, 0.1]];
        /// let mesh = Mesh::new(corners, Faces::from_triangles(vec![0, 1, 2, 3, 4, 5])?)?;
        /// let errors = vec![f32::INFINITY, f32::INFINITY, f32::INFINITY, 0.1, 0.1, 0.1];
        /// let options = SimplifyOptions::default().with_error(0.5);
        /// assert_eq!(simplify(&mesh, &options)?.mesh.faces().face_count(), 2);
        /// assert_eq!(simplify(&mesh, &options.with_vanishing(errors))?.vertices, [0, 1, 2]);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_vanishing(vanishing: Vec<f32>);

        /// Allows collapses that change the topology or move a seam onto another seam. Holes can
        /// close, handles can vanish, and textures can shift at seams. Use this option to reduce
        /// cluttered models to very few triangles.
        ///
        /// ```
        /// use tristrip::{Faces, Mesh, simplify::{SimplifyOptions, simplify}};
        /// // The sides of a prism without its top and bottom: a closed strip of six triangles.
        /// let corners = vec![[0., 0., 0.], [4., 0., 0.], [0., 4., 0.], [0., 0., 1.], [4., 0., 1.], [0., 4., 1.]];
        /// let sides = vec![0, 1, 3, 3, 1, 4, 1, 2, 4, 4, 2, 5, 2, 0, 5, 5, 0, 3];
        /// let mesh = Mesh::new(corners, Faces::from_triangles(sides)?)?;
        /// let count = |permissive| {
        ///     let options = SimplifyOptions::default().with_permissive(permissive);
        ///     Ok::<_, tristrip::Error>(simplify(&mesh, &options)?.mesh.faces().face_count())
        /// };
        /// assert!(count(true)? < count(false)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_permissive(permissive: bool);

        /// Sets how much attributes count relative to the distance between the surfaces.
        ///
        /// ```
        /// use tristrip::simplify::{AttributeWeights, SimplifyOptions};
        /// let weights = AttributeWeights { uv: 2.0, ..AttributeWeights::default() };
        /// assert_eq!(SimplifyOptions::default().with_weights(weights).weights, weights);
        /// ```
        with_weights(weights: AttributeWeights);

        /// Sets how the cost of a collapse is computed.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// use tristrip::simplify::Price;
        /// let options = SimplifyOptions::default().with_triangles(20).with_price(Price::Planes);
        /// assert!(simplify(&grid, &options)?.mesh.faces().face_count() <= 20);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_price(price: Price);

        /// Joins vertices at open borders that are at most this far apart, in mesh units. Scanners
        /// and CAD programs write the two sides of a border with small differences; joined sides
        /// collapse together like the sides of a seam. Positions do not change. Errors can increase
        /// by up to this distance. The default 0 joins only vertices at equal positions. The
        /// distance should be shorter than the edges.
        ///
        /// ```
        /// use tristrip::{Faces, Mesh, simplify::{SimplifyOptions, simplify}};
        /// // Two flat grids of 8 × 8 squares, side by side with a gap of 0.001 along a zigzag
        /// // border.
        /// let at = |i: u32| {
        ///     let (x, y) = ((i % 9) as f32, (i / 9 % 9) as f32);
        ///     [x + y % 2.0 / 2.0 + (i / 81) as f32 * 8.001, y, 0.0]
        /// };
        /// let square = |i: u32| [i, i + 1, i + 9, i + 9, i + 1, i + 10];
        /// let grid = |first: u32| (0..64).flat_map(move |i| square(first + i / 8 * 9 + i % 8));
        /// let mesh = Mesh::new((0..162).map(at).collect::<Vec<_>>(), Faces::from_triangles(grid(0).chain(grid(81)).collect())?)?;
        /// let count = |weld_distance| {
        ///     let options = SimplifyOptions::default().with_error(0.01).with_weld_distance(weld_distance);
        ///     Ok::<_, tristrip::Error>(simplify(&mesh, &options)?.vertices.len())
        /// };
        /// // Once joined, the border is inside a flat surface. Only outer border vertices are
        /// // kept.
        /// assert!(count(0.01)? <= count(0.0)? / 2);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_weld_distance(weld_distance: f32);
    }

    /// Returns whether any collapse may change the topology.
    pub(super) fn may_break(&self) -> bool {
        self.permissive || !self.vanishing.is_empty()
    }

    /// Checks the error limit, the weld distance and the weights.
    pub(crate) fn check_limits(&self) -> Result<(), Error> {
        let (error, welds) = (self.error.unwrap_or_default(), self.weld_distance);
        if error.is_nan() || error < 0.0 {
            return Err(Error::Parameter { name: "error", found: error.to_string(), expected: "0 or more" });
        }
        if !welds.is_finite() || welds < 0.0 {
            let (found, expected) = (welds.to_string(), "a finite number of at least 0");
            return Err(Error::Parameter { name: "weld_distance", found, expected });
        }
        self.check_weights()
    }

    fn check_weights(&self) -> Result<(), Error> {
        let mut weights = self.weights;
        for (name, &mut weight) in weights.named() {
            if !weight.is_finite() || weight < 0.0 {
                return Err(Error::Parameter { name, found: weight.to_string(), expected: "0 or more" });
            }
        }
        Ok(())
    }

    /// Checks the options for a mesh.
    pub(super) fn check(&self, vertex_count: usize, corner_count: usize) -> Result<(), Error> {
        self.check_limits()?;
        if corner_count / 3 > MAX_TRIANGLES {
            let (found, limit) = (corner_count as u64 / 3, MAX_TRIANGLES as u64);
            return Err(Error::LimitExceeded { what: "triangles to simplify", found, limit });
        }
        if let Some(found) = self.error_factors.iter().find(|factor| !(**factor >= 0.0 && factor.is_finite()))
        {
            let (name, found) = ("error_factors", found.to_string());
            return Err(Error::Parameter { name, found, expected: "finite numbers of at least 0" });
        }
        let counts = [
            ("locked", self.locked.len()),
            ("error_factors", self.error_factors.len()),
            ("vanishing", self.vanishing.len()),
        ];
        for (name, count) in counts {
            if count > vertex_count {
                let found = format!("{} for {}", counted(count, "value"), counted(vertex_count, "vertex"));
                return Err(Error::Parameter { name, found, expected: "at most one value per vertex" });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_read_by_name() {
        let read = |text: &str| text.parse::<AttributeWeights>().ok();
        assert_eq!(read(""), Some(AttributeWeights::default()));
        let some = AttributeWeights { normal: 2.0, uv: 0.5, skin: 0.0, ..AttributeWeights::default() };
        assert_eq!(read("uv=0.5, normal=2,skin=0"), Some(some));
        for wrong in ["uv", "uv=", "uv=-1", "uv=nan", "uv=inf", "tangents=1"] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }
}
