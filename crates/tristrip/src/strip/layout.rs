//! Index buffers from strips, in the four layouts that files and graphics interfaces know.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 1 (swaps by repeated
//! vertices); the draft glTF extension `KHR_mesh_primitive_restart`.

use super::{Strips, strip_triangles};

/// How strips are laid out in an index buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Strips separated by the restart index.
    Restart,
    /// One strip, joined by degenerate triangles, winding kept.
    Degenerate,
    /// One draw call, or primitive, a strip.
    Separate,
    /// A triangle list, in strip order.
    List,
}

impl Strips {
    /// Lays the strips out with `restart` between them.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// strips.push(&[3, 4, 5]);
    /// assert_eq!(strips.to_restart(u32::MAX), [0, 1, 2, u32::MAX, 3, 4, 5]);
    /// ```
    pub fn to_restart(&self, restart: u32) -> Vec<u32> {
        let mut out = Vec::with_capacity(self.vertices_sent() + self.len());
        for strip in self.iter() {
            if !out.is_empty() {
                out.push(restart);
            }
            out.extend_from_slice(strip);
        }
        out
    }

    /// Joins the strips into one by degenerate triangles, each strip keeping its winding.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[4, 5, 6]);
    /// assert_eq!(strips.to_degenerate(), [0, 1, 2, 3, 3, 4, 4, 5, 6]);
    /// ```
    pub fn to_degenerate(&self) -> Vec<u32> {
        let mut out: Vec<u32> = Vec::with_capacity(self.vertices_sent() + 3 * self.len());
        for strip in self.iter().filter(|strip| strip.len() >= 3) {
            if let Some(&last) = out.last() {
                out.push(last);
                // The strip's first vertex must land on an even place, its repeat before it on an odd one.
                if out.len().is_multiple_of(2) {
                    out.push(last);
                }
                out.push(strip[0]);
            }
            out.extend_from_slice(strip);
        }
        out
    }

    /// Unrolls the strips into a triangle list, in the order in which they are drawn.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// assert_eq!(strips.to_list(), [0, 1, 2, 2, 1, 3]);
    /// ```
    pub fn to_list(&self) -> Vec<u32> {
        self.iter().flat_map(strip_triangles).flatten().collect()
    }
}
