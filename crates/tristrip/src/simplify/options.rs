//! The limits of a simplification, and the weights of the attributes.

use std::str::FromStr;

use crate::error::Error;
use crate::names::names;
use crate::simplify::surface::topology::MAX_TRIANGLES;
use crate::text::counted;

/// How much the attributes of vertices count relative to the distance between the surfaces; 0 for not at all.
///
/// At a weight of 1 normals (`NORMAL`) that deviate by a radian count like a distance of 0.06 of the longest side of the bounding box, tangents
/// (`TANGENT`) half as much, and colours (`COLOR_n`) that deviate by 1 like a tenth of it. Texture coordinates (`TEXCOORD_n`) count like the distance by
/// which the texture moves over the surface, and a skin (`JOINTS_n`, `WEIGHTS_n`) like that by which a vertex moves elsewhere if a
/// joint turns by a tenth of a radian.
///
/// ```
/// use tristrip::simplify::{AttributeWeights, SimplifyOptions};
/// let only_texture = AttributeWeights { uv: 1.0, ..AttributeWeights::NONE };
/// let options = SimplifyOptions::default().with_weights(only_texture);
/// assert_eq!((options.weights.normal, options.weights.uv), (0.0, 1.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttributeWeights {
    /// The weight of the normals.
    pub normal: f32,
    /// The weight of the texture coordinates.
    pub uv: f32,
    /// The weight of the colours.
    pub colour: f32,
    /// The weight of the tangents.
    pub tangent: f32,
    /// The weight of the joints and their weights.
    pub skin: f32,
}

impl AttributeWeights {
    /// No attribute counts, only the shape.
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

    /// Parses weights such as `normal=2,uv=0.5`; those that are not named are 1, so that an empty text gives the default.
    ///
    /// # Errors
    /// A name is unknown, or a weight is negative or no number.
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

/// What a collapse costs: which one is done next, and what counts as the error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Price {
    /// The distances of all removed vertices from the triangles, and between old and new triangles.
    #[default]
    Distance,
    /// The distances from the planes of the full mesh alone: takes about a third of the time. The mean distance between the surfaces
    /// is about a third larger, and the largest is not known: where triangles bridge a valley it exceeds the error.
    Planes,
    /// The quadrics of Garland and Heckbert 1997, as Kim et al. 2005 use them: the sum of the squared distances from the planes of both points,
    /// the cheapest of all collapses next. The error is the square root of that sum, in which planes along borders count 1000 times. Attributes
    /// do not count, and one thread does all.
    Quadric,
}

impl Price {
    /// Returns the unit of costs for a unit of length: its third power, or its square for [`Price::Quadric`].
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
    Distance => "distance", "The distances of all removed vertices from the triangles, and between old and new triangles";
    Planes => "planes", "The distances from the planes of the full mesh alone: a third of the time, larger distances";
    Quadric => "quadric", "Quadric error metrics as published in 1997: the cheapest pair of all next; attributes do not count";
}

/// The limits of a simplification. Without a limit a mesh is simplified as far as its topology allows.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct SimplifyOptions {
    /// The number of triangles to stop at.
    pub triangle_count: usize,
    /// The largest error of a collapse, in mesh units; `None` for any.
    pub error: Option<f32>,
    /// Whether each vertex is locked; vertices after the last value are not.
    pub locked: Vec<bool>,
    /// The factor of the errors at each vertex; see [`SimplifyOptions::with_error_factors`].
    pub error_factors: Vec<f32>,
    /// Whether the vertices at the borders of the surface are locked.
    pub locked_borders: bool,
    /// The error of the removal of each vertex's whole component, in mesh units; see [`SimplifyOptions::with_vanishing`].
    pub vanishing: Vec<f32>,
    /// Whether collapses may change the topology and move seams.
    pub permissive: bool,
    /// How much attributes count relative to the distance between the surfaces.
    pub weights: AttributeWeights,
    /// What a collapse costs.
    pub price: Price,
    /// The distance at which vertices at open borders are joined, in mesh units; 0 for equal positions only.
    pub weld_distance: f32,
}

impl SimplifyOptions {
    crate::setters! {
        /// Stops at this number of triangles, or one fewer: a collapse drops up to two.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let simplified = simplify(&grid, &SimplifyOptions::default().with_triangles(20))?;
        /// assert!((19..=20).contains(&simplified.mesh.faces().face_count()));
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_triangles(triangle_count: usize);

        /// Allows no collapse with a larger error, in mesh units; see [`Collapse::error`](crate::collapse::Collapse::error).
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let triangles = |error| {
        ///     let simplified = simplify(&grid, &SimplifyOptions::default().with_error(error))?;
        ///     Ok::<_, Error>(simplified.mesh.faces().face_count())
        /// };
        /// // The peak stays where an error of its height is not allowed.
        /// assert!(triangles(0.5)? > triangles(2.0)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_error(error: f32) as Some;

        /// Locks vertices, one value per vertex; vertices after the last value are not locked.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let kept = |options| simplify(&grid, &options).map(|simplified| simplified.vertices);
        /// // The first row stays.
        /// let locked = SimplifyOptions::default().with_locked(vec![true; 9]);
        /// assert_eq!(kept(locked)?[..9], [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        /// assert!(kept(SimplifyOptions::default())?.len() < 9);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_locked(locked: Vec<bool>);

        /// Sets by how much errors at each vertex count when the collapses of a [batch](super::refinement_batches) are chosen, one value per vertex, such as one by the distance from the
        /// eye: where it is small, vertices are removed earlier. 1 for vertices after the last value; errors of levels stay what they are. Other simplifications ignore it.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// use tristrip::simplify::refinement_batches;
        /// // Errors on the left count ten times.
        /// let factors = grid.positions().iter().map(|p| if p[0] < 4.0 { 10.0 } else { 1.0 }).collect();
        /// let options = SimplifyOptions::default().with_error_factors(factors);
        /// let tree = refinement_batches(&grid, grid.faces().corners().to_vec(), &options)?;
        /// assert!(tree.sequence.len() > 40);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_error_factors(error_factors: Vec<f32>);

        /// Locks the vertices at the borders of the surface. Simplified tiles of a terrain then still fit together.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let options = SimplifyOptions::default().with_locked_borders(true);
        /// let kept = simplify(&grid, &options)?.vertices;
        /// // The first row, and the first and the last vertex of the second.
        /// assert!((0..10).chain([17]).all(|v| kept.contains(&v)));
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_locked_borders(locked_borders: bool);

        /// Allows components to vanish: for each vertex the error of the removal of its whole component, in mesh units. Components of vertices
        /// without a value, or with one that is no number of at least 0, keep a triangle.
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

        /// Allows collapses that change the topology, or move a seam onto another: holes may close, handles vanish, textures shift at
        /// seams. For clutter that is to become very small.
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

        /// Sets what a collapse costs.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// use tristrip::simplify::Price;
        /// let options = SimplifyOptions::default().with_triangles(20).with_price(Price::Planes);
        /// assert!(simplify(&grid, &options)?.mesh.faces().face_count() <= 20);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_price(price: Price);

        /// Joins vertices at open borders that are at most this far apart, in mesh units, so that the sides of a border that scanners or CAD wrote with
        /// small differences collapse together, as those of a seam do. Positions stay what they are; errors may be larger by the distance. 0, the
        /// default, joins only vertices of equal position. The distance should be less than the edges are long.
        ///
        /// ```
        /// use tristrip::{Faces, Mesh, simplify::{SimplifyOptions, simplify}};
        /// // Two flat grids of 8 × 8 squares, side by side with a gap of 0.001; the border between them is a zigzag.
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
        /// // Joined, the border between them lies inside a flat surface: only those outside stay.
        /// assert!(count(0.01)? <= count(0.0)? / 2);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_weld_distance(weld_distance: f32);
    }

    /// Checks whether any collapse may change the topology.
    pub(super) fn may_break(&self) -> bool {
        self.permissive || !self.vanishing.is_empty()
    }

    /// Checks the error limit, the distances and the weights.
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
