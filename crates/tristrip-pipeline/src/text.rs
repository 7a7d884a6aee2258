//! Counts as text, for notes and reports: `69,451`, `2 vertices`.

/// Formats a count with thousands separators.
///
/// ```
/// assert_eq!(tristrip_pipeline::text::count(69_451), "69,451");
/// ```
pub fn count(n: usize) -> String {
    grouped(&n.to_string())
}

/// Inserts thousands separators into digits.
///
/// ```
/// assert_eq!(tristrip_pipeline::text::grouped("1234567"), "1,234,567");
/// ```
pub fn grouped(digits: &str) -> String {
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// Formats a count with thousands separators and its noun, in the plural unless the count is 1.
///
/// ```
/// use tristrip_pipeline::text::counted;
/// assert_eq!([counted(1, "strip"), counted(2, "index"), counted(2, "mesh")], ["1 strip", "2 indices", "2 meshes"]);
/// ```
pub fn counted(n: usize, noun: &str) -> String {
    tristrip::text::counted(count(n), noun)
}
