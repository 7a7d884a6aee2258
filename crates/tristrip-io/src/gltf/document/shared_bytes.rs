//! Ranges of bytes that several values share.

use std::ops::Range;
use std::sync::Arc;

/// A range of bytes that are shared, never copied.
#[derive(Clone, Default)]
pub(in crate::gltf) struct SharedBytes {
    pub(in crate::gltf) owner: Arc<Vec<u8>>,
    pub(in crate::gltf) range: Range<usize>,
}

impl SharedBytes {
    pub(in crate::gltf) fn as_slice(&self) -> &[u8] {
        &self.owner[self.range.clone()]
    }

    pub(in crate::gltf) fn len(&self) -> usize {
        self.range.len()
    }
}

impl From<Vec<u8>> for SharedBytes {
    fn from(bytes: Vec<u8>) -> Self {
        let (owner, range) = whole_of(Arc::new(bytes));
        Self { owner, range }
    }
}

impl std::fmt::Debug for SharedBytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SharedBytes({})", self.len())
    }
}

/// Returns all bytes of an owner.
pub(in crate::gltf) fn whole_of(owner: Arc<Vec<u8>>) -> (Arc<Vec<u8>>, Range<usize>) {
    let range = 0..owner.len();
    (owner, range)
}
