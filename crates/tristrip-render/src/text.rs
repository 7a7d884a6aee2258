//! Text formatting: times, sizes, aligned tables.

use std::ops::Range;

use tristrip_pipeline::text::counted;

/// Formats a time in seconds with about three significant digits.
///
/// ```
/// assert_eq!([0.045, 2.7].map(tristrip_render::text::duration), ["45 ms", "2.70 s"]);
/// ```
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 0.001 => format!("{:.2} ms", s * 1e3),
        s if s < 0.01 => format!("{:.1} ms", s * 1e3),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 10.0 => format!("{s:.2} s"),
        s => format!("{s:.0} s"),
    }
}

/// Formats a size in bytes.
///
/// ```
/// assert_eq!([312, 1_300_000].map(tristrip_render::text::bytes), ["312 bytes", "1.3 MB"]);
/// ```
pub fn bytes(n: usize) -> String {
    match n {
        0..10_000 => counted(n, "byte"),
        10_000..1_000_000 => format!("{:.0} kB", n as f64 / 1e3),
        _ => format!("{:.1} MB", n as f64 / 1e6),
    }
}

/// Formats rows of cells as an aligned table with two spaces between columns. The columns in
/// `right` are right-aligned. Lines have no trailing spaces.
///
/// ```
/// let rows = [vec!["strips".to_owned(), "7".into()], vec!["swaps".into(), "12".into()]];
/// assert_eq!(tristrip_render::text::table(&rows, 1..2), "strips   7\nswaps   12\n");
/// ```
pub fn table(rows: &[Vec<String>], right: Range<usize>) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|c| width(c).unwrap_or(0)).collect();
    let mut out = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(c, (cell, width))| {
            if right.contains(&c) { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        out.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
        out.push('\n');
    }
    out
}

/// Formats rows as a Markdown table. The first row is the header; the columns in `right` are
/// right-aligned.
///
/// ```
/// let rows = [vec!["strips".to_owned(), "swaps".into()], vec!["7".into(), "12".into()]];
/// let table = tristrip_render::text::markdown(&rows, 0..2);
/// assert!(table.starts_with("| strips | swaps |\n|---:|---:|\n"));
/// ```
pub fn markdown(rows: &[Vec<String>], right: Range<usize>) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let rule = |column| if right.contains(&column) { "---:|" } else { "---|" };
    let rule = format!("|{}", (0..columns).map(rule).collect::<String>());
    let mut lines = rows.iter().map(|row| {
        let cells: Vec<String> = row.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |", cells.join(" | "))
    });
    let head = lines.next().unwrap_or_default();
    let body = lines.collect::<Vec<_>>().join("\n");
    format!("{head}\n{rule}\n{body}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_are_readable() {
        assert_eq!(
            [0.000_314, 0.0045, 0.045, 2.719, 61.0].map(duration),
            ["0.31 ms", "4.5 ms", "45 ms", "2.72 s", "61 s"]
        );
        assert_eq!([312, 31_200, 1_340_000].map(bytes), ["312 bytes", "31 kB", "1.3 MB"]);
    }

    #[test]
    fn tables_are_aligned() {
        let rows = [vec!["method".into(), "strips".into()], vec!["sgi".into(), "1,234,567".into()]];
        assert_eq!(table(&rows, 1..2), "method     strips\nsgi     1,234,567\n");
        assert_eq!(markdown(&rows, 1..2), "| method | strips |\n|---|---:|\n| sgi | 1,234,567 |\n");
    }
}
