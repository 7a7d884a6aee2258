//! The content of a file: parts with one mesh each, and the scene of a glTF file.

use tristrip::{Mesh, Strips};

use crate::error::Error;
use crate::gltf::document::scene::Scene;
use crate::materials::Materials;

/// The geometry of a file, in file order. Clones share positions, attributes, buffers and images.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// The meshes. Each part is stripified and drawn separately.
    pub parts: Vec<Part>,
    /// Data that was dropped or changed while reading, as text with counts.
    pub notes: Vec<String>,
    /// The document of a glTF or GLB file.
    pub scene: Option<Scene>,
    /// The materials from the libraries of an OBJ, or materials that a program added; `None` for
    /// other formats. If a model with a scene is written as OBJ, these materials are written.
    pub materials: Option<Materials>,
}

impl Model {
    /// Checks that there is one drawing per part, and that its strips use only vertices of the
    /// part.
    pub(crate) fn check_drawings(&self, drawings: &[Drawing]) -> Result<(), Error> {
        if drawings.len() != self.parts.len() {
            let (found, expected) = (drawings.len(), self.parts.len());
            return Err(Error::Unsupported(format!(
                "drawings: found {found}, expected {expected} (one per part)"
            )));
        }
        for (part, drawing) in self.parts.iter().zip(drawings) {
            let Drawing::Strips(strips) = drawing else { continue };
            strips.check_vertices(part.mesh.vertex_count())?;
        }
        Ok(())
    }
}

/// One mesh: the faces of one material (OBJ), one primitive (glTF), or the whole file (PLY, OFF,
/// STL).
#[derive(Debug, Clone, Default)]
pub struct Part {
    /// Object, group or mesh name, if the file has one.
    pub name: Option<String>,
    /// Material name, if the file has one.
    pub material: Option<String>,
    /// The geometry.
    pub mesh: Mesh,
    /// Whether the file stores the part as strips or fans. The faces are their triangles, in order.
    pub stripped: bool,
    /// The original indices of a part stored as strips or fans; `None` for other parts.
    pub stored: Option<StoredStrips>,
}

impl Part {
    /// Returns a part with the same names and another mesh, which is not stripped.
    pub(crate) fn with_mesh(&self, mesh: Mesh) -> Self {
        let (name, material) = (self.name.clone(), self.material.clone());
        Self { name, material, mesh, stripped: false, stored: None }
    }
}

/// The indices of a part that is stored as strips or fans, before conversion to triangles.
///
/// ```
/// use tristrip_io::{Format, read};
/// let header = "ply\nformat ascii 1.0\nelement vertex 4\n";
/// let axes = "property float x\nproperty float y\nproperty float z\n";
/// let strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
/// let rows = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n7 0 1 2 -1 2 1 3\n";
/// let model = read([header, axes, strips, rows].concat().as_bytes(), Format::Ply)?;
/// let stored = model.parts[0].stored.clone().unwrap_or_default();
/// assert_eq!((stored.runs.len(), stored.restarts, stored.indices()), (2, 1, 7));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StoredStrips {
    /// Whether the runs are fans instead of strips.
    pub fans: bool,
    /// The vertices between restarts, including degenerate joins. Empty runs are dropped.
    pub runs: Strips,
    /// The number of restart indices.
    pub restarts: usize,
}

impl StoredStrips {
    /// Creates strips of one run.
    pub(crate) fn from_run(run: Vec<u32>, fans: bool) -> Self {
        let end = run.len() as u32;
        let runs = Strips::from_parts(run, Vec::from_iter((end > 0).then_some(end))).unwrap_or_default();
        Self { fans, runs, restarts: 0 }
    }

    /// Collects the runs between restarts, which may be empty.
    pub(crate) fn from_runs<'a>(runs: impl Iterator<Item = &'a [u32]>, fans: bool) -> Self {
        let mut stored = Self { fans, ..Self::default() };
        let mut run_count = 0_usize;
        for run in runs {
            run_count += 1;
            if !run.is_empty() {
                stored.runs.push(run);
            }
        }
        stored.restarts = run_count.saturating_sub(1);
        stored
    }

    /// Returns the number of indices, including restarts.
    ///
    /// ```
    /// use tristrip_io::StoredStrips;
    /// let mut stored = StoredStrips { restarts: 1, ..StoredStrips::default() };
    /// stored.runs.push(&[0, 1, 2, 3]);
    /// stored.runs.push(&[2, 3, 4]);
    /// assert_eq!(stored.indices(), 8);
    /// ```
    pub fn indices(&self) -> usize {
        self.runs.vertices_sent() + self.restarts
    }
}

/// The form in which a part is written: faces or strips.
#[derive(Debug, Clone, Copy)]
pub enum Drawing<'a> {
    /// The part's own faces. Polygons are preserved if the format supports them.
    Faces,
    /// Triangle strips of the part's vertices.
    Strips(&'a Strips),
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::Faces;

    #[test]
    fn drawings_are_checked() {
        let mesh = Mesh::new(vec![[0.0; 3]; 3], Faces::default()).unwrap();
        let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
        assert!(model.check_drawings(&[]).is_err());
        let mut strips = Strips::default();
        strips.push(&[0, 1, 3]);
        let wrong = model.check_drawings(&[Drawing::Strips(&strips)]).unwrap_err();
        assert_eq!(wrong.to_string(), "strip 0, vertex 2: found vertex index 3, expected less than 3");
    }
}
