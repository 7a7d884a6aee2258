//! Parsers for argument values that are not types of the libraries.

use std::str::FromStr;

use tristrip::Effort;

/// Parses a search effort.
pub(crate) fn effort(text: &str) -> Result<Effort, String> {
    let effort = text.parse().ok().and_then(Effort::new);
    effort.ok_or_else(|| format!("found {text}, expected a level from 0 to 9"))
}

/// Parses `N` comma-separated numbers.
pub(crate) fn numbers<T: FromStr, const N: usize>(text: &str) -> Result<[T; N], String> {
    separated(text, ',')
}

/// Parses the size of an image: `1920x1080`.
pub(crate) fn image_size(text: &str) -> Result<[u32; 2], String> {
    let size: [u32; 2] = separated(text, 'x')?;
    let is_valid = size.iter().all(|side| (1..=tristrip_render::images::MAX_SIZE).contains(side));
    is_valid.then_some(size).ok_or_else(|| format!("found {text}, expected columns and rows from 1 to 8192"))
}

fn separated<T: FromStr, const N: usize>(text: &str, separator: char) -> Result<[T; N], String> {
    let parsed: Option<Vec<T>> = text.split(separator).map(|part| part.trim().parse().ok()).collect();
    let numbers = parsed.and_then(|numbers| <[T; N]>::try_from(numbers).ok());
    numbers.ok_or_else(|| format!("found {text}, expected {N} numbers separated by {separator}"))
}
