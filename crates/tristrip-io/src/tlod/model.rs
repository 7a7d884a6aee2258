//! The content of a file: a mesh with matching strips and collapses.

use tristrip::text::counted;
use tristrip::verify::verify;
use tristrip::{CollapseSequence, Faces, Mesh, Strips};

use crate::error::Error;

/// A view-dependent level-of-detail model.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TlodModel {
    /// The positions and all attributes. The faces are the triangles of the strips, in drawing
    /// order.
    pub mesh: Mesh,
    /// The strips of the full mesh.
    pub strips: Strips,
    /// The collapses of the triangles of the strips.
    pub sequence: CollapseSequence,
}

impl TlodModel {
    /// Creates a model, and puts the triangles of the mesh and of the collapses in the order of the
    /// strips. Polygons become the triangles that the strips draw; degenerate triangles are
    /// dropped. The strips no longer record whether their order was optimized.
    ///
    /// # Errors
    /// The strips do not draw exactly the faces of the mesh or the triangles of the collapses, or
    /// they have welds. A file cannot store welds.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(model.mesh.faces().corners(), model.sequence.triangles());
    /// let none = TlodModel::new(model.mesh, Strips::default(), model.sequence);
    /// assert!(none.unwrap_err().to_string().starts_with("strips of the mesh: triangles missing: 2, "));
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn new(mesh: Mesh, strips: Strips, sequence: CollapseSequence) -> Result<Self, Error> {
        check_vertices(&mesh, &strips, &sequence)?;
        let unproven = |what| move |why| Error::Unsupported(format!("strips of the {what}: {why}"));
        verify(&mesh, &strips).map_err(unproven("mesh"))?;
        let collapsed = mesh.with_faces(Faces::from_triangles(sequence.triangles().to_vec())?)?;
        verify(&collapsed, &strips).map_err(unproven("collapses"))?;
        drop(collapsed);
        let mut model = Self { mesh, strips, sequence };
        if !model.is_in_order() {
            model.put_in_order()?;
        }
        let ends = strip_ends(&model.strips).collect();
        model.strips = Strips::from_parts(model.strips.vertices().to_vec(), ends)?;
        Ok(model)
    }

    /// Puts the triangles of the mesh and of the collapses in the order of the strips.
    fn put_in_order(&mut self) -> Result<(), Error> {
        let triangles = self.strips.to_list();
        let collapses = self.sequence.iter().map(|collapse| (collapse.renames, collapse.error));
        let vertex_count = self.mesh.vertex_count();
        self.sequence = CollapseSequence::from_collapses(vertex_count, triangles.clone(), collapses)?;
        self.mesh = self.mesh.with_faces(Faces::from_triangles(triangles)?)?;
        Ok(())
    }

    /// Returns whether the strips, the mesh and the collapses have the same triangles in the same
    /// order.
    fn is_in_order(&self) -> bool {
        let triangles = self.sequence.triangles();
        let drawn = self.strips.triangles().flatten();
        drawn.eq(triangles.iter().copied()) && self.mesh.faces().as_triangles() == Some(triangles)
    }

    /// Checks that the public fields are still consistent.
    pub(super) fn check(&self) -> Result<(), Error> {
        check_vertices(&self.mesh, &self.strips, &self.sequence)?;
        if self.is_in_order() {
            return Ok(());
        }
        let message = "triangles: found differences between mesh, strips and collapses, expected the same triangles in the same order";
        Err(Error::Unsupported(message.into()))
    }
}

/// Returns the end of each strip in the list of strip vertices.
pub(super) fn strip_ends(strips: &Strips) -> impl Iterator<Item = u32> {
    strips.iter().scan(0, |end, strip| {
        *end += strip.len() as u32;
        Some(*end)
    })
}

/// Checks that mesh, strips and collapses have the same vertices.
fn check_vertices(mesh: &Mesh, strips: &Strips, sequence: &CollapseSequence) -> Result<(), Error> {
    let vertex_count = mesh.vertex_count();
    if sequence.vertex_count() != vertex_count {
        let found = sequence.vertex_count();
        return Err(Error::Unsupported(format!(
            "vertices of the collapses: found {found}, expected {vertex_count}"
        )));
    }
    strips.check_vertices(vertex_count)?;
    if !strips.welds().is_empty() {
        let found = strips.welds().len();
        return Err(Error::Unsupported(format!(
            "strips: found {}, expected no welds",
            counted(found, "welded vertex")
        )));
    }
    Ok(())
}
