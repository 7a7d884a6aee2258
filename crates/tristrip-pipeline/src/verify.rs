//! The proof that one model draws exactly the faces of another.

use serde::Serialize;
use tristrip::verify::{Difference, Proof, verify_models};
use tristrip_io::Model;

use crate::error::Error;
use crate::parts::meshes;

/// Proves that a model draws exactly the faces of a source, each once, with its winding. Vertices are compared by the bits of their
/// positions; other attributes are not compared.
///
/// # Errors
/// The models together are too large for 32-bit ids.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{DifferenceReport, verify};
/// let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
/// let square = read([corners, "f 1 2 3 4\n"].concat().as_bytes(), Format::Obj)?;
/// let halves = read([corners, "f 1 2 3\nf 3 4 1\n"].concat().as_bytes(), Format::Obj)?;
/// let flipped = read([corners, "f 1 2 3\nf 4 3 1\n"].concat().as_bytes(), Format::Obj)?;
/// assert_eq!(verify(&square, &halves)?.map(|proof| proof.triangles), Ok(2));
/// let difference = verify(&halves, &flipped)?.unwrap_err();
/// assert_eq!(DifferenceReport::of(&difference).flipped, Some(1));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn verify(source: &Model, result: &Model) -> Result<Result<Proof, Difference>, Error> {
    Ok(verify_models(&meshes(source), &meshes(result))?)
}

/// How a result differs from its source; the keys are those of the JSON report.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct DifferenceReport {
    /// `triangles`, `outside`, `count` or `boundary`.
    pub kind: &'static str,
    /// Triangles of the source that the result lacks.
    pub missing: Option<usize>,
    /// Triangles of the result that the source lacks.
    pub extra: Option<usize>,
    /// Triangles drawn with the opposite winding.
    pub flipped: Option<usize>,
    /// The face of the source, counted from 0 over all parts.
    pub face: Option<u32>,
    /// The positions of the first difference.
    pub first: Vec<[f32; 3]>,
}

impl DifferenceReport {
    /// Reports a difference.
    pub fn of(difference: &Difference) -> Self {
        match *difference {
            Difference::Triangles { missing, extra, flipped, first } => Self {
                kind: "triangles",
                missing: Some(missing),
                extra: Some(extra),
                flipped: Some(flipped),
                first: first.to_vec(),
                ..Self::default()
            },
            Difference::Outside { triangle } => {
                Self { kind: "outside", first: triangle.to_vec(), ..Self::default() }
            }
            Difference::Count { face, position, found, expected } => Self {
                kind: "count",
                missing: Some(expected.saturating_sub(found)),
                extra: Some(found.saturating_sub(expected)),
                face: Some(face),
                first: vec![position],
                ..Self::default()
            },
            Difference::Boundary { face, edge } => {
                Self { kind: "boundary", face: Some(face), first: edge.to_vec(), ..Self::default() }
            }
            _ => Self { kind: "other", ..Self::default() },
        }
    }
}
