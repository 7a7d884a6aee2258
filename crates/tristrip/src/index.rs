//! Index types for index buffers: 8, 16 and 32 bits for graphics APIs, and `usize` for computed
//! indices.

/// An index type for index buffers. The largest value of the type is the restart value.
///
/// ```
/// use tristrip::Index;
/// assert_eq!((u16::RESTART, u8::from_vertex(300), 7_u16.to_vertex()), (65_535, None, Some(7)));
/// ```
pub trait Index: Copy + Eq + std::fmt::Debug + Send + Sync + private::Sealed + 'static {
    /// The value that ends a strip in a buffer with restarts.
    const RESTART: Self;
    /// The name of the type in errors, with its number of bits.
    const DESCRIPTION: &'static str;

    /// Converts a vertex to an index, or returns `None` if it does not fit.
    ///
    /// ```
    /// use tristrip::Index;
    /// // This vertex fits in 16 bits, but equals the restart value.
    /// assert_eq!(u16::from_vertex(65_535), Some(u16::RESTART));
    /// assert_eq!(u16::from_vertex(65_536), None);
    /// ```
    fn from_vertex(vertex: u32) -> Option<Self>;

    /// Converts an index to a vertex, or returns `None` if it needs more than 32 bits.
    ///
    /// ```
    /// use tristrip::Index;
    /// fn largest<I: Index>(indices: &[I]) -> Option<u32> {
    ///     indices.iter().filter_map(|index| index.to_vertex()).max()
    /// }
    /// assert_eq!(largest(&[3_u8, 250, 7]), Some(250));
    /// assert_eq!(largest(&[2_usize, 70_000, 1]), Some(70_000));
    /// ```
    fn to_vertex(self) -> Option<u32>;
}

/// Only the types of this file implement `Index`, because code over indices relies on their
/// guarantees.
mod private {
    pub trait Sealed {}
}

macro_rules! index_types {
    ($($type:ty: $description:literal),+) => {$(
        impl private::Sealed for $type {}

        impl Index for $type {
            const RESTART: Self = Self::MAX;
            const DESCRIPTION: &'static str = $description;

            #[inline]
            fn from_vertex(vertex: u32) -> Option<Self> {
                Self::try_from(vertex).ok()
            }

            #[inline]
            fn to_vertex(self) -> Option<u32> {
                u32::try_from(self).ok()
            }
        }
    )+};
}

index_types!(u8: "8-bit index", u16: "16-bit index", u32: "32-bit index", usize: "index");
