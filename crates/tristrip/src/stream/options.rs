//! Encoder options of a stream.

use super::grid::AttributeBits;
use super::places::MAX_BITS;
use crate::error::Error;

/// Encoder options of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct StreamOptions {
    /// Bits per position coordinate, 4 to 16.
    pub position_bits: u32,
    pub(super) attribute_bits: AttributeBits,
    pub(super) least_chunk_bytes: usize,
    pub(super) most_chunk_bytes: usize,
    /// Two opposite corners of a box that the position grid covers in addition to the mesh; see
    /// [`StreamOptions::with_bounds`].
    pub bounds: Option<[[f32; 3]; 2]>,
    /// Whether positions have all bits at every level; see [`StreamOptions::with_exact_positions`].
    pub exact_positions: bool,
}

impl Default for StreamOptions {
    /// Returns options for 14 bits per position coordinate, 10 per normal component, 14 per texture
    /// coordinate for each repeat of the texture, and 10 per component of other attributes.
    /// Integers below 2²⁴ are exact, also when they are stored as floats. Chunks have a size of 1
    /// to 4 KiB.
    fn default() -> Self {
        Self {
            position_bits: 14,
            attribute_bits: AttributeBits { normal: 10, uv: 14, other: 10 },
            least_chunk_bytes: 1 << 10,
            most_chunk_bytes: 1 << 12,
            bounds: None,
            exact_positions: false,
        }
    }
}

impl StreamOptions {
    crate::setters! {
        /// Sets the bits per position coordinate, 4 to 16.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let encoded = |bits| {
        ///     let options = StreamOptions::default().with_position_bits(bits);
        ///     encode(&mesh, &batches.sequence, &batches.level_ends, 0, &options)
        /// };
        /// assert!(encoded(12)?.position_error > stream.position_error);
        /// assert!(encoded(17).is_err());
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_position_bits(position_bits: u32);
    }

    /// Checks the bits per position coordinate, as [`encode`](super::encode) does.
    ///
    /// # Errors
    /// The number of bits is less than 4 or greater than 16.
    ///
    /// ```
    /// use tristrip::stream::StreamOptions;
    /// assert!(StreamOptions::default().with_position_bits(12).check().is_ok());
    /// assert!(StreamOptions::default().with_position_bits(17).check().is_err());
    /// ```
    pub fn check(&self) -> Result<(), Error> {
        if (4..=MAX_BITS).contains(&self.position_bits) {
            return Ok(());
        }
        let found = self.position_bits.to_string();
        Err(Error::Parameter { name: "position-bits", found, expected: "4 to 16" })
    }

    crate::setters! {
        /// Sets two opposite corners of a box that the position grid covers in addition to the
        /// mesh. Meshes that lie in the same box and use it as bounds share one grid. They then
        /// meet without gaps where their positions are equal. The corners must be finite.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let options = StreamOptions::default().with_bounds([[0.0; 3], [1000.0; 3]]);
        /// let coarse = encode(&mesh, &batches.sequence, &batches.level_ends, 0, &options)?;
        /// assert!(coarse.position_error > 10.0 * stream.position_error);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_bounds(bounds: [[f32; 3]; 2]) as Some;

        /// Sets whether positions have all bits at every level. By default, coarse levels have only
        /// as many bits as their error justifies. With all bits, neighbouring meshes meet at every
        /// level where their full meshes meet. This adds a few bytes to the coarse levels.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// use tristrip::stream::{Decoder, StreamLimits};
        /// let options = StreamOptions::default().with_exact_positions(true);
        /// let exact = encode(&mesh, &batches.sequence, &batches.level_ends, 0, &options)?;
        /// let mut decoder = Decoder::new(StreamLimits::default());
        /// decoder.update(&exact.chunks[0].bytes)?;
        /// assert_eq!(decoder.part(0).map(|part| part.position_bits()), Some([14, 14]));
        /// # Ok::<(), Box<dyn std::error::Error>>(())
        /// ```
        with_exact_positions(exact_positions: bool);
    }
}
