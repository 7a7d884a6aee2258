//! The warning about a goal that was not reached: what held it back, and what to try.

use crate::collapses::Collapses;
use crate::goal::Deviation;
use crate::text::{count, counted};

/// Returns a sentence on the goal, if it was not reached.
pub(crate) fn warning(collapses: &Collapses, limit: Deviation, locks_borders: bool) -> Option<String> {
    let (stopped, target) = (collapses.vertices_kept?, collapses.target_triangles?);
    let limit = format!("the error limit of {limit}");
    let (locked, unlocked) = match (locks_borders, collapses.locked_vertices) {
        (true, 0) => {
            ("lie at open borders, which are locked", "a model without locked borders can get smaller")
        }
        (true, _) => (
            "lie at open borders, which are locked, or touch parts in other places of the scene",
            "a model without locked borders can get smaller",
        ),
        (false, _) => (
            "touch other parts of the scene and stay, to avoid gaps",
            "parts of one node are simplified together",
        ),
    };
    // What holds vertices, and what to try, by the number of vertices; of equal numbers the first.
    let reasons = [
        (stopped.error, format!("would exceed {limit}"), "a larger limit allows fewer triangles"),
        (stopped.locked, locked.into(), unlocked),
        (
            stopped.seam,
            "lie on seams of normals, texture coordinates or colours, which would open".into(),
            "a model with fewer seams can get smaller",
        ),
        (
            stopped.non_manifold,
            "lie on edges of more than two faces, or where surfaces touch in one point".into(),
            "a model repaired there can get smaller",
        ),
        (
            stopped.topology,
            "hold holes open or are the last of a piece".into(),
            "a larger error limit does not help",
        ),
        (stopped.fold_over, "would turn triangles over".into(), "a larger error limit does not help"),
    ];
    let (held, why, hint) = reasons.into_iter().rev().max_by_key(|(held, ..)| *held)?;
    let remain = if collapses.triangles_after == 1 { "remains" } else { "remain" };
    let kept = counted(collapses.triangles_after, "triangle");
    let left = counted(held, "vertex");
    Some(format!("{kept} {remain}, {} were asked for: {left} {why}; {hint}", count(target)))
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
            "1,380 triangles remain, 292 were asked for: 1,200 vertices would exceed the error limit of 1 % of the diagonal; a larger \
             limit allows fewer triangles"
        );
        collapses.triangles_after = 1;
        assert!(warn(&collapses, false).unwrap().starts_with("1 triangle remains, 292 were asked for: "));
        stopped.seam = 1201;
        collapses.vertices_kept = Some(stopped);
        assert!(warn(&collapses, false).unwrap().contains("1,201 vertices lie on seams"));
        // Vertices are locked at borders, or where other parts touch them.
        stopped.locked = 1300;
        collapses.vertices_kept = Some(stopped);
        assert!(warn(&collapses, false).unwrap().contains("1,300 vertices touch other parts of the scene"));
        assert!(
            warn(&collapses, true)
                .unwrap()
                .contains("1,300 vertices lie at open borders, which are locked; ")
        );
        collapses.locked_vertices = 7;
        assert!(
            warn(&collapses, true).unwrap().contains("locked, or touch parts in other places of the scene; ")
        );
    }
}
