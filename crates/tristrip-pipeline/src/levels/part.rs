//! A part at any level: renames vertices in its strips, filters the strips, and verifies that they
//! draw exactly the triangles of the level.

use std::sync::Arc;

use tristrip::lod::{Filter, LevelCursor, RESTART, Repair, RepairOptions, SkipStrips, SkipView};
use tristrip::text::counted;
use tristrip::verify::verify_drawing;
use tristrip::{CollapseSequence, Faces, Strips};

use super::filter::DisplayFilter;
use crate::error::Error;
use crate::parts::check_vertices;
use crate::places::SAME_SCALE;
use crate::simplify::UsedVertices;

/// A part: the strips of its full mesh, and its collapses. If the part uses few of its vertices,
/// both index only the used vertices; otherwise they index the vertices of the part.
/// [`LevelPart::outward`] converts.
#[derive(Debug, Clone)]
pub struct LevelPart {
    used: UsedVertices,
    /// The number of vertices of the part in the model.
    vertex_count: usize,
    sequence: Arc<CollapseSequence>,
    strips: Strips,
}

impl LevelPart {
    /// Builds a part from the strips of its full mesh, over its own vertices, and its collapses.
    pub(crate) fn new(
        used: UsedVertices,
        vertex_count: usize,
        strips: &Strips,
        sequence: CollapseSequence,
    ) -> Self {
        let strips = mapped(strips, |strip| used.inward(strip));
        Self { used, vertex_count, sequence: Arc::new(sequence), strips }
    }

    /// Returns the strips of the full mesh, over the vertices of the collapses.
    pub fn strips(&self) -> &Strips {
        &self.strips
    }

    /// Returns the collapses.
    pub fn sequence(&self) -> &Arc<CollapseSequence> {
        &self.sequence
    }

    /// Returns the number of vertices of the part in the model.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Returns, for each vertex of the part, the vertex that replaces it at a level. A vertex that
    /// the level still has maps to itself.
    ///
    /// # Errors
    /// [`Error::Level`]: the level does not exist.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::levels;
    /// let corners = "v 9 9 9\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
    /// let model = read([corners, "f 2 3 6\nf 3 4 6\nf 4 5 6\nf 5 2 6\n"].concat().as_bytes(), Format::Obj)?;
    /// let levels = levels::run(&model, &levels::Options::default(), &())?.model;
    /// let (part, last) = (&levels.parts[0], levels.collapse_count());
    /// assert_eq!(part.renaming(last)?, [0, 1, 2, 3, 4, 5]);
    /// assert_ne!(part.renaming(0)?, part.renaming(last)?);
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn renaming(&self, level: usize) -> Result<Vec<u32>, Error> {
        self.check(level)?;
        let renaming = self.sequence.renaming(level)?;
        let mut all: Vec<u32> = (0..self.vertex_count as u32).collect();
        let mut from: Vec<u32> = (0..renaming.len() as u32).collect();
        let mut to: Vec<u32> = renaming;
        self.used.outward(&mut from);
        self.used.outward(&mut to);
        from.iter().zip(to).for_each(|(&from, to)| all[from as usize] = to);
        Ok(all)
    }

    /// Returns the index map at a level: the strips with renamed vertices, and [`RESTART`] between
    /// them.
    ///
    /// # Errors
    /// [`Error::Level`]: the part does not have this level.
    pub fn index_map(&self, level: usize) -> Result<Vec<u32>, Error> {
        self.check(level)?;
        let renaming = self.sequence.renaming(level)?;
        let renamed = |v: u32| if v == RESTART { RESTART } else { renaming[v as usize] };
        Ok(self.strips.to_restart(RESTART).into_iter().map(renamed).collect())
    }

    /// Returns the display strips of a level.
    ///
    /// # Errors
    /// The part does not have this level.
    pub(crate) fn display(
        &self,
        level: usize,
        filter: DisplayFilter,
        repair: RepairOptions,
    ) -> Result<Strips, Error> {
        let map = self.index_map(level)?;
        let Some(scanner) = filter.scanner() else {
            let mut repaired = Repair::at(Arc::clone(&self.sequence), &self.strips, level, repair)?;
            return Ok(repaired.strips().clone());
        };
        let mut display = Strips::default();
        scanner.map_to(&map, &mut display);
        Ok(display)
    }

    /// Returns strips over the part's own vertices in the model.
    ///
    /// # Errors
    /// The strips refer to a vertex that the collapses do not have.
    pub fn outward(&self, strips: &Strips) -> Result<Strips, Error> {
        check_vertices(&[(strips, self.used.count().unwrap_or(self.vertex_count))])?;
        Ok(mapped(strips, |strip| self.used.outward(strip)))
    }

    /// Returns the triangles of a level, over the part's own vertices in the model.
    ///
    /// # Errors
    /// [`Error::Level`]: the part does not have this level.
    pub fn triangles(&self, level: usize) -> Result<Vec<u32>, Error> {
        self.check(level)?;
        Ok(self.outward_triangles(self.sequence.drawn(level)?))
    }

    /// Verifies that display strips draw exactly the triangles of a level.
    ///
    /// # Errors
    /// The part does not have this level, or the strips fail verification ([`Error::Unproven`]).
    pub fn prove(&self, level: usize, display: &Strips) -> Result<(), Error> {
        self.check(level)?;
        let expected = Faces::from_triangles(self.sequence.drawn(level)?.into_flattened())?;
        let drawn: Vec<[u32; 3]> = display.triangles().collect();
        verify_drawing(&expected, &drawn).map_err(|why| Error::unproven(format!("level {level}: {why}")))?;
        Ok(())
    }

    /// Returns a view of the part at its base mesh, or at its full mesh if `is_full`. Errors of the
    /// view are in the units of the positions. Errors of the collapses are in the scene, where the
    /// part has this scale.
    ///
    /// # Errors
    /// The positions do not belong to the part, or one is not finite.
    pub(super) fn view(&self, positions: &[[f32; 3]], is_full: bool, scale: f64) -> Result<SkipView, Error> {
        let positions = self.positions_of_collapses(positions)?;
        let scaled = if is_full || (scale - 1.0).abs() < SAME_SCALE {
            None
        } else {
            Some(CollapseSequence::clone(&self.sequence).with_scaled_errors(1.0 / scale)?)
        };
        let sequence = scaled.as_ref().unwrap_or(&self.sequence);
        let model = Arc::new(SkipStrips::new(&self.strips, sequence, &positions[..])?);
        // Files are written once, so the filter with the fewest indices may take longer.
        Ok(if is_full { model.full_view() } else { model.view_by(Filter::Linked) })
    }

    /// Returns the positions of the vertices that the collapses use, selected from the positions of
    /// the part.
    ///
    /// # Errors
    /// The positions do not belong to the part.
    pub fn positions_of_collapses(&self, positions: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, Error> {
        if positions.len() != self.vertex_count {
            let (found, expected) = (positions.len(), self.vertex_count);
            return Err(Error::unproven(format!(
                "found a part of {}, expected {expected}",
                counted(found, "vertex")
            )));
        }
        let mut vertices: Vec<u32> = (0..self.used.count().unwrap_or(self.vertex_count) as u32).collect();
        self.used.outward(&mut vertices);
        Ok(vertices.iter().map(|&v| positions[v as usize]).collect())
    }

    /// Converts triangles of the collapses to the part's own vertices in the model.
    pub(super) fn outward_triangles(&self, triangles: Vec<[u32; 3]>) -> Vec<u32> {
        let mut corners = triangles.into_flattened();
        self.used.outward(&mut corners);
        corners
    }

    fn check(&self, level: usize) -> Result<(), Error> {
        let last = self.sequence.len();
        if level > last { Err(Error::Level { found: level, last }) } else { Ok(()) }
    }
}

/// Returns strips that draw the same triangles, without vertices that only degenerate triangles
/// use. The file does not have those vertices.
///
/// All such vertices are replaced by one vertex of the triangles. Equal vertices stay equal, so
/// degenerate triangles stay degenerate, and the other triangles do not change. Without triangles
/// there are no strips.
pub(super) fn without_unused(strips: &Strips, triangles: &[u32], vertex_count: usize) -> Strips {
    let Some(&any) = triangles.first() else { return Strips::default() };
    let mut is_used = vec![false; vertex_count];
    triangles.iter().for_each(|&v| is_used[v as usize] = true);
    mapped(strips, |strip| strip.iter_mut().filter(|v| !is_used[**v as usize]).for_each(|v| *v = any))
}

/// Returns strips with mapped vertices.
fn mapped(strips: &Strips, map: impl Fn(&mut [u32])) -> Strips {
    let (mut out, mut mapped) = (Strips::default(), Vec::new());
    for strip in strips.iter() {
        mapped.clear();
        mapped.extend_from_slice(strip);
        map(&mut mapped);
        out.push(&mapped);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::Rename;

    #[test]
    fn vertices_of_degenerate_triangles_only_are_replaced() {
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 2, 4, 4, 5, 5, 3, 3, 6, 7]);
        strips.push(&[5, 5, 4]);
        let triangles = strips.to_list();
        assert_eq!(triangles, [0, 1, 2, 6, 3, 7]);
        let replaced = without_unused(&strips, &triangles, 8);
        assert_eq!(replaced.vertices(), [0, 1, 2, 2, 0, 0, 0, 0, 3, 3, 6, 7, 0, 0, 0]);
        assert_eq!(replaced.to_list(), triangles);
        assert!(without_unused(&strips, &[], 8).is_empty());
    }

    #[test]
    fn every_filter_draws_exactly_the_triangles_of_the_level() {
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 3, 4, 5]);
        let rename = [Rename { removed: 3, kept: 2 }];
        let sequence = CollapseSequence::from_collapses(6, strips.to_list(), [(&rename[..], 1.0)]).unwrap();
        let part = LevelPart::new(UsedVertices::default(), 6, &strips, sequence);
        assert_eq!(part.index_map(1).unwrap(), strips.vertices());
        assert_eq!(part.index_map(0).unwrap(), [0, 1, 2, 2, 4, 5]);
        for filter in DisplayFilter::ALL {
            let display = part.display(0, filter, RepairOptions::default()).unwrap();
            part.prove(0, &display).unwrap();
            assert!(matches!(part.prove(1, &display), Err(Error::Unproven { .. })));
        }
        assert_eq!(part.triangles(0).unwrap(), [0, 1, 2, 4, 2, 5]);
        assert!(matches!(part.triangles(2), Err(Error::Level { found: 2, last: 1 })));
    }

    #[test]
    fn positions_are_those_of_the_part() {
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 3, 4, 5]);
        let rename = [Rename { removed: 3, kept: 2 }];
        let sequence = CollapseSequence::from_collapses(6, strips.to_list(), [(&rename[..], 1.0)]).unwrap();
        let part = LevelPart::new(UsedVertices::default(), 6, &strips, sequence);
        let positions: Vec<[f32; 3]> = (0..6).map(|x| [x as f32, 0.0, 0.0]).collect();
        assert_eq!(part.positions_of_collapses(&positions).unwrap(), positions);
        assert!(part.positions_of_collapses(&positions[1..]).is_err());
    }
}
