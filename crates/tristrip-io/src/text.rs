//! Lines and words of the text formats, with line numbers for errors.
//!
//! A line ends with LF, CR LF or CR. In OBJ, a backslash at the end of a line joins it to the next
//! one. In OBJ and OFF, `#` starts a comment.

use memchr::memchr2;

use crate::error::Error;

/// A cursor over the lines and words of a text.
#[derive(Debug, Clone)]
pub(crate) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    comments: bool,
    continued: bool,
}

impl<'a> Text<'a> {
    /// Starts at the first line, after a byte order mark if present.
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { bytes, at: 0, line: 1, comments: false, continued: false }
    }

    /// Treats `#` as the start of a comment.
    pub(crate) fn with_comments(self) -> Self {
        Self { comments: true, ..self }
    }

    /// Joins a line that ends with a backslash to the next one.
    pub(crate) fn with_continued_lines(self) -> Self {
        Self { continued: true, ..self }
    }

    /// Sets the number of the first line.
    pub(crate) fn with_first_line(self, line: u64) -> Self {
        Self { line, ..self }
    }

    /// Describes the current position.
    pub(crate) fn position(&self) -> String {
        format!("line {}", self.line)
    }

    /// Returns the line number, counted from 1.
    pub(crate) fn line(&self) -> u64 {
        self.line
    }

    /// Returns the offset of the next byte, not counting a byte order mark.
    pub(crate) fn offset(&self) -> usize {
        self.at
    }

    /// Returns the number of remaining bytes.
    pub(crate) fn bytes_left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Returns the maximum number of words in the remaining bytes: a word takes at least one byte
    /// and a space.
    pub(crate) fn words_left(&self) -> usize {
        self.bytes_left().div_ceil(2)
    }

    /// Returns the next word of this line.
    pub(crate) fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            match *self.bytes.get(self.at)? {
                b' ' | b'\t' | 0x0b | 0x0c => self.at += 1,
                b'\n' | b'\r' => return None,
                b'#' if self.comments => {
                    self.at = self.line_end();
                    return None;
                }
                b'\\' if self.continued => match newline(self.bytes, self.at + 1) {
                    Some(next) => (self.at, self.line) = (next, self.line + 1),
                    None => break,
                },
                _ => break,
            }
        }
        let start = self.at;
        while let Some(&byte) = self.bytes.get(self.at) {
            let joins = byte == b'\\' && self.continued && newline(self.bytes, self.at + 1).is_some();
            if matches!(byte, b' ' | b'\t'..=b'\r') || joins {
                break;
            }
            self.at += 1;
        }
        Some(&self.bytes[start..self.at])
    }

    /// Returns the next word, on this line or a later one.
    pub(crate) fn word_on_any_line(&mut self) -> Option<&'a [u8]> {
        loop {
            if let Some(word) = self.word() {
                return Some(word);
            }
            if !self.next_line() {
                return None;
            }
        }
    }

    /// Advances to the next word, on this line or a later one. Returns whether there is one.
    pub(crate) fn skip_blank_lines(&mut self) -> bool {
        let mut ahead = self.clone();
        while ahead.word().is_none() {
            if !ahead.next_line() {
                *self = ahead;
                return false;
            }
            *self = ahead.clone();
        }
        true
    }

    /// Returns the rest of this line without surrounding white space.
    pub(crate) fn rest(&mut self) -> &'a [u8] {
        let start = self.at;
        self.at = self.line_end();
        self.bytes[start..self.at].trim_ascii()
    }

    /// Advances to the start of the next line. Returns whether there is one.
    pub(crate) fn next_line(&mut self) -> bool {
        loop {
            let end = self.line_end();
            let joined = self.continued && end > self.at && self.bytes[end - 1] == b'\\';
            match newline(self.bytes, end) {
                Some(next) => (self.at, self.line) = (next, self.line + 1),
                None => self.at = end,
            }
            if !joined || self.at >= self.bytes.len() {
                return self.at < self.bytes.len();
            }
        }
    }

    /// Parses the next word of this line as a finite number.
    pub(crate) fn number(&mut self, what: &str) -> Result<f32, Error> {
        match self.word() {
            Some(word) => self.parse_number(word, what),
            None => Err(self.missing(&format!("a number for {what}"))),
        }
    }

    /// Parses a word as a finite number.
    pub(crate) fn parse_number(&self, word: &[u8], what: &str) -> Result<f32, Error> {
        match fast_float2::parse::<f32, _>(word) {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(Error::format(self.position(), quote(word), format!("a finite number for {what}"))),
            Err(_) => Err(Error::format(self.position(), quote(word), format!("a number for {what}"))),
        }
    }

    /// Returns the error for a value missing at the end of the line or file.
    pub(crate) fn missing(&self, what: &str) -> Error {
        let found = if self.bytes_left() == 0 { "the end of the file" } else { "the end of the line" };
        Error::format(self.position(), found, what)
    }

    fn line_end(&self) -> usize {
        memchr2(b'\n', b'\r', &self.bytes[self.at..]).map_or(self.bytes.len(), |i| self.at + i)
    }
}

/// Returns the offset after the line end at `at`, or `None` if there is no line end at `at`.
fn newline(bytes: &[u8], at: usize) -> Option<usize> {
    match bytes.get(at)? {
        b'\r' if bytes.get(at + 1) == Some(&b'\n') => Some(at + 2),
        b'\n' | b'\r' => Some(at + 1),
        _ => None,
    }
}

/// Parses a decimal integer that fits into 64 bits.
pub(crate) fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] | digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let value = digits.iter().try_fold(0i64, |value, digit| {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 { None } else { value.checked_mul(10)?.checked_add(i64::from(digit)) }
    })?;
    Some(if negative { -value } else { value })
}

/// Quotes a word of a file for an error message, escaped and truncated to 32 bytes.
pub(crate) fn quote(word: &[u8]) -> String {
    const LONGEST: usize = 32;
    let cut = if word.len() > LONGEST { "…" } else { "" };
    format!("`{}{cut}`", word[..word.len().min(LONGEST)].escape_ascii())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(mut text: Text<'_>) -> Vec<(u64, Vec<String>)> {
        let mut out = Vec::new();
        loop {
            let mut words = Vec::new();
            while let Some(word) = text.word() {
                words.push(String::from_utf8_lossy(word).into_owned());
            }
            out.push((text.line, words));
            if !text.next_line() {
                return out;
            }
        }
    }

    #[test]
    fn every_line_end_counts_once() {
        let words = |n: u64, w: &[&str]| (n, w.iter().map(|&w| w.to_owned()).collect::<Vec<_>>());
        assert_eq!(
            lines(Text::new(b"a b\nc\r\nd\re\n\nf")),
            [
                words(1, &["a", "b"]),
                words(2, &["c"]),
                words(3, &["d"]),
                words(4, &["e"]),
                words(5, &[]),
                words(6, &["f"])
            ]
        );
    }

    #[test]
    fn backslashes_join_lines_but_not_comments() {
        let text = Text::new(b"f 1\\\r\n 2 \\\n3\n# c:\\\nv").with_comments().with_continued_lines();
        let got: Vec<_> = lines(text).into_iter().map(|(n, w)| (n, w.join(" "))).collect();
        assert_eq!(got, [(3, "f 1 2 3".into()), (4, String::new()), (5, "v".into())]);
    }

    #[test]
    fn skipping_a_line_skips_its_continuation() {
        let mut text = Text::new(b"curv 1 \\\n 2\nv").with_continued_lines();
        assert_eq!(text.word(), Some(&b"curv"[..]));
        assert!(text.next_line());
        assert_eq!((text.word(), text.line), (Some(&b"v"[..]), 3));
    }

    #[test]
    fn integers_are_checked() {
        assert_eq!(integer(b"-12"), Some(-12));
        for bad in ["", "-", "1.0", "99999999999999999999", "0x1", "--1"] {
            assert_eq!(integer(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn quoted_words_are_truncated_and_printable() {
        assert_eq!(quote(b"a\xff\n"), "`a\\xff\\n`");
        assert!(quote(&vec![b'x'; 1 << 20]).len() < 50);
    }
}
