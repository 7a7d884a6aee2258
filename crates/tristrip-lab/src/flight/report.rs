//! The report of a flight as text and as Markdown.

use tristrip_pipeline::text::{count, counted};

use super::frames::{FlightSummary, FrameRow, FrameValues};
use tristrip_render::text::{bytes, markdown, table};

/// The maximum number of rows of the table of frames.
const TABLE_ROWS: usize = 60;

/// Formats the summary of a flight as a text table.
///
/// ```
#[doc = include_str!("example.txt")]
/// let rows = fly(&model, &cameras, &FlightOptions::default(), &mut ())?;
/// assert!(as_text(&FlightSummary::of(&rows)).contains("vertices per triangle"));
/// # Ok::<(), Error>(())
/// ```
pub fn as_text(summary: &FlightSummary) -> String {
    format!("  {}\n{}", heading(summary), table(&summary_rows(summary, "  "), 1..4))
}

/// Formats a flight as a Markdown page: the title, a paragraph about the measurement, the summary,
/// and a table of at most 60 frames.
///
/// ```
#[doc = include_str!("example.txt")]
/// let rows = fly(&model, &cameras, &FlightOptions::default(), &mut ())?;
/// let page = as_markdown("Flight over a grid", "One pixel of error.", &rows);
/// assert!(page.starts_with("# Flight over a grid\n\nOne pixel of error.\n"));
/// # Ok::<(), Error>(())
/// ```
pub fn as_markdown(title: &str, how: &str, rows: &[FrameRow]) -> String {
    let summary = FlightSummary::of(rows);
    let head =
        ["frame", "triangles", "vertices sent", "strips", "collapses", "splits", "looked at", "segments"];
    let mut head: Vec<String> = head.map(String::from).to_vec();
    head.extend(["bytes changed", "ms", "proven"].map(String::from));
    let columns = head.len();
    let line = |row: &FrameRow| {
        let counts = [row.frame, row.triangles, row.vertices_sent, row.strips, row.collapses, row.splits];
        let mut cells: Vec<String> = counts.map(count).to_vec();
        cells.extend([row.looked_at, row.segments, row.bytes_changed].map(count));
        cells.push(format!("{:.3}", 1e3 * row.seconds.update));
        cells.push(if row.proven == Some(true) { "yes" } else { "" }.into());
        cells
    };
    let stride = rows.len().div_ceil(TABLE_ROWS).max(1);
    let lines: Vec<_> = std::iter::once(head).chain(rows.iter().step_by(stride).map(line)).collect();
    let which = if stride == 1 { String::new() } else { format!(", one of {stride}") };
    format!(
        "# {title}\n\n{how}\n\n{}\n\n{}\n## Frames{which}\n\n{}",
        heading(&summary),
        markdown(&summary_rows(&summary, ""), 1..4),
        markdown(&lines, 0..columns - 1)
    )
}

/// Returns a line with the number of frames, proven frames, and incomplete frames.
fn heading(summary: &FlightSummary) -> String {
    let frames = counted(summary.frame_count, "frame");
    let proven = match summary.frames_proven {
        0 => "none proven".into(),
        n => format!("{} proven to draw exactly the triangles of the view", count(n)),
    };
    let incomplete = match summary.frames_incomplete {
        0 => String::new(),
        n => format!("; {} ended by the limit of steps", count(n)),
    };
    format!("{frames}, {proven}{incomplete}")
}

fn summary_rows(summary: &FlightSummary, indent: &str) -> Vec<Vec<String>> {
    let row = |name: &str, value: &dyn Fn(&FrameValues) -> String| {
        let values = [&summary.median, &summary.worst, &summary.first].map(value);
        std::iter::once(format!("{indent}{name}")).chain(values).collect::<Vec<_>>()
    };
    let head = ["", "median", "worst", "first frame"].map(String::from).to_vec();
    vec![
        head,
        row("milliseconds", &|v| format!("{:.3}", 1e3 * v.seconds.update)),
        row("triangles", &|v| count(v.triangles)),
        row("vertices per triangle", &|v| format!("{:.3}", v.vertices_per_triangle)),
        row("changes per active vertex", &|v| format!("{:.2} %", v.changes_percent)),
        row("bytes changed", &|v| bytes(v.bytes_changed)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_without_frames_is_valid() {
        let page = as_markdown("t", "h", &[]);
        assert!(page.contains("0 frames, none proven\n") && page.contains("## Frames\n"), "{page}");
    }
}
