//! Counts as text, for messages.

use std::fmt::Display;

/// Formats a count with its noun. The noun is plural unless the count is `1`.
///
/// ```
/// use tristrip::text::counted;
/// assert_eq!([counted(1, "strip"), counted(0, "byte"), counted(2, "index")], ["1 strip", "0 bytes", "2 indices"]);
/// assert_eq!([counted("1,200", "mesh"), counted(2, "entry")], ["1,200 meshes", "2 entries"]);
/// ```
pub fn counted(count: impl Display, noun: &str) -> String {
    let count = count.to_string();
    if count == "1" { format!("1 {noun}") } else { format!("{count} {}", plural(noun)) }
}

fn plural(noun: &str) -> String {
    let has_stem = |stem: &&str| ["vert", "ind"].iter().any(|end| stem.ends_with(end));
    if let Some(stem) = noun.strip_suffix("ex").filter(has_stem) {
        return format!("{stem}ices");
    }
    match noun.strip_suffix('y') {
        Some(stem) if !stem.ends_with(['a', 'e', 'o', 'u']) => format!("{stem}ies"),
        _ if noun.ends_with("sh") => format!("{noun}es"),
        _ => format!("{noun}s"),
    }
}
