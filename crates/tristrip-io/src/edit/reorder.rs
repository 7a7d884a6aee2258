//! Orders the vertices of models by first use in their drawings, so vertices are fetched
//! sequentially.
//!
//! ```text
//! model, strips ─▶ groups of parts ─▶ order per group ─▶ model, strips ─▶ write
//! ```
//! # Algorithm
//! 1. Parts that share vertices in the file form one group (`renumber.rs`).
//! 2. The vertices of a group are ordered by first use in the index buffers that the writer builds
//!    from the drawings of the group. In the degenerate layout, the strips are joined first,
//!    because the joins depend on the vertex indices.
//! 3. Positions, attributes, faces and strips are renumbered. In a scene, all other vertex data is
//!    renumbered too. Parts that shared vertices still share them.
//!
//! # Complexity
//! Linear time. Memory: a second copy of vertices and faces, plus 8 bytes per vertex.

use tristrip::VertexOrder;
use tristrip::{Layout, Mesh, Strips};

use crate::edit::renumber::renumbered;
use crate::edit::vertex_group::{Renumbering, VertexGroup};
use crate::error::Error;
use crate::format::Format;
use crate::gltf::edit::renumber::SceneGroup;
use crate::model::{Drawing, Model};

/// A model with reordered vertices, and its drawings.
#[derive(Debug)]
pub struct Reordered {
    /// The parts, in their original order, with reordered vertices.
    pub model: Model,
    /// The strips of each part with new vertex indices; `None` for a part that is drawn as faces.
    pub strips: Vec<Option<Strips>>,
    /// The layout to write. It is [`Layout::Separate`] if the strips are already joined.
    pub layout: Layout,
    /// The groups in the order of their first parts. Every part is in exactly one group.
    pub groups: Vec<VertexGroup>,
}

impl Reordered {
    /// Returns the drawing of each part.
    ///
    /// ```
    /// use tristrip_io::{Drawing, Format, Part, read, reorder};
    /// let mut model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let twin = Part { mesh: model.parts[0].mesh.clone(), ..Part::default() };
    /// model.parts.push(twin);
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// let drawings = [Drawing::Faces, Drawing::Strips(&strips)];
    /// let reordered = reorder(&model, &drawings, Format::Ply, tristrip::Layout::Restart)?;
    /// assert!(matches!(reordered.drawings()[..], [Drawing::Faces, Drawing::Strips(_)]));
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn drawings(&self) -> Vec<Drawing<'_>> {
        self.strips.iter().map(|strips| strips.as_ref().map_or(Drawing::Faces, Drawing::Strips)).collect()
    }
}

/// Orders vertices by first use in drawings with the given format and layout. Unused vertices come
/// last, in their old order. The result must be written with its own drawings and layout.
///
/// If other data in a scene depends on the vertex indices, or may depend on them, the vertices keep
/// their order; [`VertexGroup::kept`] states the reason.
///
/// # Errors
/// The number of drawings differs from the number of parts, the scene has a different number of
/// parts, or a strip uses a vertex that its part does not have.
///
/// ```
/// use tristrip_io::{Drawing, Format, read, reorder, write};
/// let model = read(b"v 9 9 9\nv 0 1 0\nv 0 0 0\nv 1 0 0\nf 3 4 2\n", Format::Obj)?;
/// let mut strips = tristrip::Strips::default();
/// strips.push(&[2, 3, 1]);
/// let drawings = [Drawing::Strips(&strips)];
/// let reordered = reorder(&model, &drawings, Format::Ply, tristrip::Layout::Restart)?;
/// assert_eq!(reordered.groups[0].order.new_to_old(), [2, 3, 1, 0]);
/// assert_eq!(reordered.strips[0].as_ref().map(|strips| strips.vertices()), Some(&[0, 1, 2][..]));
/// let ply = write(&reordered.model, &reordered.drawings(), Format::Ply, reordered.layout)?;
/// assert_eq!(read(&ply, Format::Ply)?.parts[0].mesh.positions()[3], [9.0; 3]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn reorder(
    model: &Model,
    drawings: &[Drawing<'_>],
    format: Format,
    layout: Layout,
) -> Result<Reordered, Error> {
    model.check_drawings(drawings)?;
    let layout = if format == Format::Obj { Layout::List } else { layout };
    let join = layout == Layout::Degenerate;
    let layout = if join { Layout::Separate } else { layout };
    let strips: Vec<Option<Strips>> = drawings
        .iter()
        .map(|drawing| match *drawing {
            Drawing::Faces => None,
            Drawing::Strips(strips) => Some(if join { joined(strips) } else { strips.clone() }),
        })
        .collect();
    // 1. The order of each group.
    let number = |_: &[Mesh], parts: &[usize], group: Option<&SceneGroup>| -> Result<Renumbering, Error> {
        let kept = group.and_then(SceneGroup::why_ordered);
        let vertex_count = parts.first().map_or(0, |&part| model.parts[part].mesh.vertex_count());
        let indices = parts.iter().filter(|_| kept.is_none()).flat_map(|&part| match &strips[part] {
            Some(strips) => indices(strips, layout),
            None => model.parts[part].mesh.faces().corners().to_vec(),
        });
        Ok(Renumbering::of_order(VertexOrder::of_indices(vertex_count, indices)?, kept))
    };
    // 2. The scene and the parts. The flag `stripped` does not change.
    let meshes = model.parts.iter().map(|part| part.mesh.clone()).collect();
    let (mut reordered, groups) = renumbered(model, meshes, (format, false), number)?;
    for (part, old) in reordered.parts.iter_mut().zip(&model.parts) {
        part.stripped = old.stripped;
    }
    let groups: Vec<VertexGroup> = groups.into_iter().map(VertexGroup::from).collect();
    // 3. The strips.
    let mut out = vec![None; strips.len()];
    for group in &groups {
        for &part in &group.parts {
            out[part] = strips[part].as_ref().map(|strips| group.order.strips(strips)).transpose()?;
        }
    }
    Ok(Reordered { model: reordered, strips: out, layout, groups })
}

/// Joins strips into one.
fn joined(strips: &Strips) -> Strips {
    let mut out = Strips::default();
    let all = strips.to_degenerate();
    if !all.is_empty() {
        out.push(&all);
    }
    out
}

/// Returns the vertex indices of strips in the order of a layout.
fn indices(strips: &Strips, layout: Layout) -> Vec<u32> {
    if layout == Layout::List { strips.to_list() } else { strips.vertices().to_vec() }
}
