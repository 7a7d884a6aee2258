//! Verifies that one model draws exactly the faces of another.

use serde::Serialize;
use tristrip::verify::{Difference, verify_models};
use tristrip_io::Model;

use crate::error::Error;
use crate::observer::{Observer, Stage, begin};
use crate::parts::meshes;

/// Whether a model draws exactly the faces of another. The field names are the keys of the JSON
/// report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// Whether the result draws exactly the faces of the source.
    pub proven: bool,
    /// The number of faces of the source.
    pub faces: usize,
    /// The number of triangles of the result.
    pub triangles: usize,
    /// How the result differs from the source; `None` if it does not.
    pub difference: Option<FoundDifference>,
}

/// How a result differs from its source. The field names are the keys of the JSON report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FoundDifference {
    /// `triangles`: triangles are missing, extra or flipped. `outside`: a triangle is not inside
    /// any polygon. `count`: a polygon has too few or too many triangles. `boundary`: the triangles
    /// of a polygon do not have its boundary.
    pub kind: &'static str,
    /// The number of triangles of the source that are missing in the result; `None` if this does
    /// not apply to the kind.
    pub missing: Option<usize>,
    /// The number of triangles of the result that are not in the source; `None` if this does not
    /// apply to the kind.
    pub extra: Option<usize>,
    /// The number of triangles drawn with the opposite winding; `None` if this does not apply to
    /// the kind.
    pub flipped: Option<usize>,
    /// The index of the face of the source, from 0 over all parts; `None` if the kind does not
    /// refer to a face.
    pub face: Option<u32>,
    /// The positions of the first difference.
    pub first: Vec<[f32; 3]>,
    /// A description of the difference.
    #[serde(skip)]
    pub text: String,
}

/// Compares a result with its source: every face of the source is drawn exactly once, with its
/// original winding. Vertices are compared by the bits of their positions; other attributes are not
/// compared.
///
/// # Errors
/// The models together are too large for 32-bit ids, or the observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::verify;
/// let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
/// let square = read([corners, "f 1 2 3 4\n"].concat().as_bytes(), Format::Obj)?;
/// let halves = read([corners, "f 1 2 3\nf 3 4 1\n"].concat().as_bytes(), Format::Obj)?;
/// let flipped = read([corners, "f 1 2 3\nf 4 3 1\n"].concat().as_bytes(), Format::Obj)?;
/// let same = verify::run(&square, &halves, &())?;
/// assert_eq!((same.proven, same.faces, same.triangles), (true, 1, 2));
/// let difference = verify::run(&halves, &flipped, &())?.difference;
/// assert_eq!(difference.and_then(|found| found.flipped), Some(1));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(source: &Model, result: &Model, observer: &dyn Observer) -> Result<Outcome, Error> {
    begin(observer, Stage::Prove)?;
    let [expected, found] = [meshes(source), meshes(result)];
    let difference = verify_models(&expected, &found)?.err().map(|found| FoundDifference::of(&found));
    Ok(Outcome {
        proven: difference.is_none(),
        faces: expected.iter().map(|mesh| mesh.faces().face_count()).sum(),
        triangles: found.iter().map(|mesh| mesh.faces().triangle_count()).sum(),
        difference,
    })
}

impl FoundDifference {
    fn of(difference: &Difference) -> Self {
        let other = Self {
            kind: "other",
            missing: None,
            extra: None,
            flipped: None,
            face: None,
            first: Vec::new(),
            text: difference.to_string(),
        };
        match *difference {
            Difference::Triangles { missing, extra, flipped, first } => Self {
                kind: "triangles",
                missing: Some(missing),
                extra: Some(extra),
                flipped: Some(flipped),
                first: first.to_vec(),
                ..other
            },
            Difference::Outside { triangle } => Self { kind: "outside", first: triangle.to_vec(), ..other },
            Difference::Count { face, position, found, expected } => Self {
                kind: "count",
                missing: Some(expected.saturating_sub(found)),
                extra: Some(found.saturating_sub(expected)),
                face: Some(face),
                first: vec![position],
                ..other
            },
            Difference::Boundary { face, edge } => {
                Self { kind: "boundary", face: Some(face), first: edge.to_vec(), ..other }
            }
            _ => other,
        }
    }
}
