//! The warning about a goal that was not reached: its main cause, and what to try.

use crate::collapses::Collapses;
use crate::goal::Deviation;
use crate::text::{count, counted};

/// Returns a warning if the goal was not reached.
pub(crate) fn warning(collapses: &Collapses, limit: Deviation, locks_borders: bool) -> Option<String> {
    let (stopped, target) = (collapses.vertices_kept?, collapses.target_triangles?);
    let limit = format!("the error limit of {limit}");
    let (locked, unlocked) = match (locks_borders, collapses.locked_vertices) {
        (true, 0) => ("at locked open borders", "a model without locked borders can be simplified further"),
        (true, _) => (
            "at locked open borders, or touching parts of other nodes",
            "a model without locked borders can be simplified further",
        ),
        (false, _) => (
            "touching other parts of the scene, kept to avoid gaps",
            "the parts of one mesh are simplified together",
        ),
    };
    // The causes with their numbers of vertices and a hint. The largest number wins; in a tie, the
    // first.
    let reasons = [
        (stopped.error, format!("would exceed {limit}"), "a larger limit allows fewer triangles"),
        (stopped.locked, locked.into(), unlocked),
        (
            stopped.seam,
            "on seams of normals, texture coordinates or colours, which would open".into(),
            "a model with fewer seams can be simplified further",
        ),
        (
            stopped.non_manifold,
            "on edges of more than two faces, or where surfaces touch at one point".into(),
            "a model repaired there can be simplified further",
        ),
        (
            stopped.topology,
            "needed to keep a hole open or a component".into(),
            "a larger error limit does not help",
        ),
        (stopped.fold_over, "would flip a triangle".into(), "a larger error limit does not help"),
    ];
    let (held, why, hint) = reasons.into_iter().rev().max_by_key(|(held, ..)| *held)?;
    let kept = counted(collapses.triangles_after, "triangle");
    let left = counted(held, "vertex");
    Some(format!("stopped at {kept} ({} requested): {left} {why}; {hint}", count(target)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collapses::KeptVertices;

    #[test]
    fn the_commonest_reason_is_named_with_a_hint() {
        let mut stopped = KeptVertices::default();
        (stopped.error, stopped.seam) = (1200, 1200);
        let mut collapses = Collapses::default();
        (collapses.triangles_after, collapses.target_triangles) = (1380, Some(292));
        let warn =
            |collapses: &Collapses, locks_borders| warning(collapses, Deviation::default(), locks_borders);
        assert_eq!(warn(&collapses, false), None);
        collapses.vertices_kept = Some(stopped);
        assert_eq!(
            warn(&collapses, false).unwrap(),
            "stopped at 1,380 triangles (292 requested): 1,200 vertices would exceed the error limit of 1 % of the diagonal; a larger \
             limit allows fewer triangles"
        );
        collapses.triangles_after = 1;
        assert!(warn(&collapses, false).unwrap().starts_with("stopped at 1 triangle (292 requested): "));
        stopped.seam = 1201;
        collapses.vertices_kept = Some(stopped);
        assert!(warn(&collapses, false).unwrap().contains("1,201 vertices on seams"));
        // Vertices are locked at borders, or where other parts touch them.
        stopped.locked = 1300;
        collapses.vertices_kept = Some(stopped);
        assert!(
            warn(&collapses, false).unwrap().contains("1,300 vertices touching other parts of the scene")
        );
        assert!(warn(&collapses, true).unwrap().contains("1,300 vertices at locked open borders; "));
        collapses.locked_vertices = 7;
        assert!(warn(&collapses, true).unwrap().contains("borders, or touching parts of other nodes; "));
    }
}
