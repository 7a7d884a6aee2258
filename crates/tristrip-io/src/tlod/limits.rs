//! The limits of the reader: the declared counts of a file, and its size.

use crate::error::Error;

/// Maximum memory that [`read`](super::read()) uses per byte of the file, in bytes.
pub const MEMORY_PER_BYTE: u64 = 32;

/// Limits of [`read`](super::read()). A file with larger counts is rejected before its data is
/// read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct TlodLimits {
    /// Maximum number of vertices; 2^26 by default.
    pub vertices: u32,
    /// Maximum number of triangles; 2^27 by default.
    pub triangles: u32,
    /// Maximum number of collapses; 2^26 by default.
    pub collapses: u32,
    /// Maximum number of attributes; 64 by default.
    pub attributes: u32,
    /// Maximum length of an attribute name in bytes; 1024 by default.
    pub name_bytes: u32,
    /// Maximum file size in bytes; 4 GiB by default.
    pub bytes: u64,
}

impl Default for TlodLimits {
    fn default() -> Self {
        Self {
            vertices: 1 << 26,
            triangles: 1 << 27,
            collapses: 1 << 26,
            attributes: 64,
            name_bytes: 1024,
            bytes: 1 << 32,
        }
    }
}

impl TlodLimits {
    /// Sets the maximum number of vertices.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// # let mut bytes = Vec::new();
    /// # tlod::write(&model, &mut bytes)?;
    /// let wrong = tlod::read(&bytes[..], &TlodLimits::default().with_vertices(3)).unwrap_err();
    /// assert_eq!(wrong.to_string(), "byte 24, vertices: found 4, the limit is 3");
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    #[must_use]
    pub fn with_vertices(self, vertices: u32) -> Self {
        Self { vertices, ..self }
    }

    /// Sets the maximum number of triangles.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// # let mut bytes = Vec::new();
    /// # tlod::write(&model, &mut bytes)?;
    /// assert!(tlod::read(&bytes[..], &TlodLimits::default().with_triangles(1)).is_err());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    #[must_use]
    pub fn with_triangles(self, triangles: u32) -> Self {
        Self { triangles, ..self }
    }

    /// Sets the maximum number of collapses.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// # let mut bytes = Vec::new();
    /// # tlod::write(&model, &mut bytes)?;
    /// assert!(tlod::read(&bytes[..], &TlodLimits::default().with_collapses(0)).is_err());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    #[must_use]
    pub fn with_collapses(self, collapses: u32) -> Self {
        Self { collapses, ..self }
    }

    /// Sets the maximum number of attributes.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// # let mut bytes = Vec::new();
    /// # tlod::write(&model, &mut bytes)?;
    /// // This model has no attributes.
    /// assert!(tlod::read(&bytes[..], &TlodLimits::default().with_attributes(0)).is_ok());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    #[must_use]
    pub fn with_attributes(self, attributes: u32) -> Self {
        Self { attributes, ..self }
    }

    /// Sets the maximum length of an attribute name in bytes.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// # let mut bytes = Vec::new();
    /// # tlod::write(&model, &mut bytes)?;
    /// assert!(tlod::read(&bytes[..], &TlodLimits::default().with_name_bytes(0)).is_ok());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    #[must_use]
    pub fn with_name_bytes(self, name_bytes: u32) -> Self {
        Self { name_bytes, ..self }
    }

    /// Sets the maximum file size in bytes.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// # let mut bytes = Vec::new();
    /// # tlod::write(&model, &mut bytes)?;
    /// assert!(tlod::read(&bytes[..], &TlodLimits::default().with_bytes(100)).is_err());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    #[must_use]
    pub fn with_bytes(self, bytes: u64) -> Self {
        Self { bytes, ..self }
    }
}

/// Checks that a number in a file is within its limit.
pub(super) fn check(at: u64, what: &str, found: u64, limit: u64) -> Result<(), Error> {
    if found <= limit {
        return Ok(());
    }
    Err(Error::LimitExceeded { at: format!("byte {at}, {what}"), found, limit })
}
