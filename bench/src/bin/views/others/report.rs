//! The section of the page with its tables, and the best alternative per metric.

use tristrip_bench::text::Table;

use super::alternative::OtherFigures;
use crate::clusters::CLUSTER_TRIANGLES;
use crate::distance::POINTS;

/// The tolerance for errors relative to the allowed error, because distances are rounded.
const ROUNDING: f64 = 1.001;
/// The maximum number of triangles, relative to Skip Strips in the first row, that counts as equal.
const AS_MANY: f64 = 1.01;

/// Returns the section of the page.
pub(crate) fn page(table: &str, best: &str) -> String {
    format!(
        "\
Five frames of each flight, evenly apart, drawn in other ways in the same run. Each draws what it says it does, which is proven in these frames; the
figures are their medians. Milliseconds are medians of all frames but the first, with those of the five frames where a frame takes long.

- *Skip Strips*: display strips of `dtfs`, and strips repaired from frame to frame at effort 3.
- *A list*: the triangles of the same view, without strips. The whole list is written for each frame; a program that keeps it from frame to frame
  would take less, but no less than the update.
- *blocks, one level*: the whole model at the level whose error is allowed at its nearest vertex in the image. The simplification is the usual one, not the
  merge tree. In most frames the level stays.
- *meshopt simplify*: meshoptimizer simplifies the whole model for each frame to as many triangles as the view has, without regard to the
  camera; then its strips, or its order for the vertex cache. It does not keep the allowed error: *stated px* is its error at the nearest vertex in the image.
- *clusterlod*: meshoptimizer's hierarchy of clusters of up to {CLUSTER_TRIANGLES} triangles, as it is built by default for rasterization, but not permissive, because there are
  no attributes and its distances are smaller so. It works in the way of Nanite, today's
  usual answer. A frame is a cut through the hierarchy at the same error in pixels. Clusters outside of the image are not drawn, and each is drawn by
  strips of `best` that were made with the hierarchy. In the five frames the whole cut has no cracks: no edge has one triangle, except at borders of the
  full mesh. *As many triangles* is the cut at the error that leaves as many triangles as the view by Skip Strips, found by 17 cuts per frame.

*Vertices sent* are absolute and as fractions of three per triangle; *transformed / T* are the misses per triangle of a FIFO cache of 16 entries, and for
clusters the vertices of each cluster, which a mesh shader transforms once. *Bytes* are those of the model per vertex of the full mesh, and of a view: its
state, and the index buffer or the list that it draws. Positions are not counted, except 12 bytes that Skip Strips stores for its criteria.

The errors are not of one kind: Skip Strips allows surfaces that face away four times the error and silhouettes half of it, and bounds what collapses
together need; meshoptimizer's errors are those of its own quadrics. Therefore the distance is measured, too: *rms px* and *most px* are the root mean square and the
maximum over up to {POINTS} vertices of the full mesh that are in the image and face the eye, each with its distance from what is drawn, in pixels. No stated error is a bound of it.

{table}
The best by each figure: the first five of those that state no larger error than allowed, the last one of all with no more triangles than Skip Strips.

{best}
Who wins in what:
- Skip Strips adapts vertex by vertex. It needs the fewest triangles of those that keep the allowed error, and with as many triangles it is the nearest to the
  full mesh. Repaired strips also send the fewest vertices, but take many times as long per frame; `dtfs` sends more per triangle.
- clusterlod chooses a frame in a small part of the time of Skip Strips, with a fraction of its memory, next to nothing per view, and about half of the
  vertices transformed per triangle. At the allowed error it draws more triangles, and its measured distances are smaller; with as many triangles they are
  larger. Its clusters never change: only their indices are uploaded per frame. Where the time per frame, the
  memory or the vertices transformed are the limit, and not the number of triangles, it is the better answer.
- blocks at one level takes next to no time and sends few vertices per triangle, but draws the whole model as finely as its nearest vertex needs.
- Simplifying the model for each frame takes much longer than the update of Skip Strips, and spends triangles on what is far away or not seen.
"
    )
}

/// Returns a row per flight and alternative.
pub(crate) fn table<'a>(figures: impl IntoIterator<Item = &'a OtherFigures>) -> Table {
    let heads = [
        "flight",
        "drawn by",
        "triangles",
        "vertices sent",
        "of 3 T",
        "transformed / T",
        "ms",
        "bytes",
        "view bytes",
        "stated px",
        "rms px",
        "most px",
    ];
    let mut table = Table::new(2, &heads);
    for row in figures {
        table.push(vec![
            row.flight.into(),
            row.name.into(),
            format!("{:.0}", row.triangles),
            format!("{:.0}", row.vertices_sent),
            format!("{:.3}", row.fraction),
            format!("{:.3}", row.transformed),
            format!("{:.3}", row.milliseconds),
            format!("{:.1}", row.bytes[0]),
            format!("{:.1}", row.bytes[1]),
            format!("{:.3}", row.stated),
            format!("{:.4}", row.measured[0]),
            format!("{:.3}", row.measured[1]),
        ]);
    }
    table
}

/// Returns a row per flight: per column the best alternative that keeps the allowed error, and the
/// alternative with as many triangles that is nearest to the full mesh.
pub(crate) fn best<'a>(flights: impl IntoIterator<Item = &'a [OtherFigures]>) -> Table {
    let heads = [
        "flight",
        "triangles",
        "vertices sent",
        "vertices transformed",
        "ms",
        "bytes with a view",
        "rms px at as many triangles",
    ];
    let mut table = Table::new(heads.len(), &heads);
    for figures in flights.into_iter().filter(|figures| !figures.is_empty()) {
        let keeps = |row: &&OtherFigures| row.stated <= ROUNDING * row.allowed;
        let least = |figure: fn(&OtherFigures) -> f64| {
            let rows = figures.iter().filter(keeps);
            rows.min_by(|a, b| figure(a).total_cmp(&figure(b))).map_or("none", |row| row.name)
        };
        let most = AS_MANY * figures[0].triangles;
        let nearest = figures.iter().filter(|row| row.triangles <= most);
        let nearest = nearest.min_by(|a, b| a.measured[0].total_cmp(&b.measured[0]));
        table.push(vec![
            figures[0].flight.into(),
            least(|row| row.triangles).into(),
            least(|row| row.vertices_sent).into(),
            least(|row| row.transformed * row.triangles).into(),
            least(|row| row.milliseconds).into(),
            least(|row| row.bytes[0] + row.bytes[1]).into(),
            nearest.map_or("none", |row| row.name).into(),
        ]);
    }
    table
}
