//! What a file holds: parts with a mesh each, and for glTF the scene around them.

use tristrip::{Mesh, Strips};

/// A file's geometry, in the order of the file.
#[derive(Debug, Default)]
pub struct Model {
    /// The meshes, each of which is stripified and drawn by itself.
    pub parts: Vec<Part>,
    /// What was dropped or changed while reading, in words, with counts: nothing is lost silently.
    pub notes: Vec<String>,
    /// The document around the parts, for glTF and GLB.
    pub scene: Option<crate::gltf::Scene>,
}

/// One mesh: the faces of one material (OBJ), one primitive (glTF), or the whole file (PLY, OFF, STL).
#[derive(Debug, Default)]
pub struct Part {
    /// Object, group or mesh name, where the file has one.
    pub name: Option<String>,
    /// Material name, where the file has one.
    pub material: Option<String>,
    /// The geometry.
    pub mesh: Mesh,
    /// Whether the file drew the part as strips or fans, of which the faces are the triangles in order.
    pub stripped: bool,
    /// The indices that the file draws a stripped part with; `None` for others, whose faces are what is drawn.
    pub stored: Option<Stored>,
}

/// How a file draws a part as strips or fans: its indices, before they were taken apart into triangles.
///
/// ```
/// use tristrip_io::{Format, read};
/// let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
/// let strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
/// let rows = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n7 0 1 2 -1 2 1 3\n";
/// let model = read([header, strips, rows].concat().as_bytes(), Format::Ply)?;
/// let stored = model.parts[0].stored.as_ref();
/// assert_eq!(stored.map(|stored| (stored.runs.len(), stored.restarts, stored.indices())), Some((2, 1, 7)));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Stored {
    /// Whether each run is a fan, not a strip.
    pub fans: bool,
    /// The vertices between restarts, joins by degenerate triangles as they are; runs of no vertex are left out.
    pub runs: Strips,
    /// Restart indices.
    pub restarts: usize,
}

impl Stored {
    /// Takes runs apart at a restart index.
    pub(crate) fn new(indices: &[u32], restart: u32, fans: bool) -> Self {
        let mut stored = Self { fans, ..Self::default() };
        let mut runs = 0;
        for run in indices.split(|&i| i == restart) {
            runs += 1;
            if !run.is_empty() {
                stored.runs.push(run);
            }
        }
        stored.restarts = runs - 1;
        stored
    }

    /// Counts the indices, restarts included.
    pub fn indices(&self) -> usize {
        self.runs.vertices_sent() + self.restarts
    }
}

/// What to write for a part.
#[derive(Debug, Clone, Copy)]
pub enum Drawing<'a> {
    /// The part's own faces, polygons kept where the format has polygons.
    Faces,
    /// These triangle strips, over the part's vertices.
    Strips(&'a Strips),
}
