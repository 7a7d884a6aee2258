//! Vertex attributes as integers on a grid. The grid is the same at all levels.
//!
//! Each component of a new vertex is predicted as the mean over the vertices around it, and the
//! difference is coded. Joint indices are predicted from the kept vertex.

use crate::entropy::numbers::{NumberLevel, NumberModel, logarithm};
use crate::entropy::range_coder::{BitCoder, code_bits};
use crate::entropy::slots::Simple;

/// The meaning of the integers of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum ChannelKind {
    /// Steps of a grid, or integers.
    Linear,
    /// A unit vector on an octahedron, as two integers.
    Octahedral,
    /// A unit vector like `Octahedral`, and a sign: 0 or 1.
    Tangent,
    /// Names without an order, such as joint indices.
    Names,
}

/// The initial weights of the features of a level.
const LEVEL: [i32; 3] = [-8_000, 50_000, 10_000];

/// The coding state of a channel.
#[derive(Debug, Clone)]
pub(super) struct ChannelModel {
    kind: ChannelKind,
    /// The number of integers per vertex.
    pub(super) width: usize,
    /// The maximum number of bits of an integer.
    bits: u32,
    numbers: NumberModel,
    levels: Vec<NumberLevel<3>>,
    is_kept: Simple,
}

impl ChannelModel {
    pub(super) fn new(kind: ChannelKind, width: usize, bits: u32) -> Self {
        let axes = width.min(4);
        let levels = vec![NumberLevel::new(LEVEL); axes];
        Self { kind, width, bits, numbers: NumberModel::new(axes), levels, is_kept: Simple::new(axes) }
    }

    /// Codes the integers of a vertex, given those of the vertices around it, kept vertex first.
    /// Appends them to `values`.
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        around: &[&[i32]],
        to_encode: &[i32],
        values: &mut Vec<i32>,
    ) {
        let most = (1_i64 << self.bits) - 1;
        for component in 0..self.width {
            let axis = component.min(3);
            let to_encode = to_encode.get(component).copied().unwrap_or(0);
            let kept = around.first().map_or(0, |values| values[component]);
            let is_name =
                self.kind == ChannelKind::Names || self.kind == ChannelKind::Tangent && component == 2;
            if is_name {
                let value = if self.is_kept.code(coder, axis, to_encode == kept) {
                    kept
                } else {
                    code_bits(coder, self.bits, to_encode.cast_unsigned()).cast_signed()
                };
                values.push(value);
                continue;
            }
            let of_around = around.iter().map(|values| i64::from(values[component]));
            let count = i64::from(around.len().max(1) as u32);
            let expected = (2 * of_around.clone().sum::<i64>() + count).div_euclid(2 * count);
            let spread = of_around.clone().max().unwrap_or(most).abs_diff(of_around.min().unwrap_or(0));
            let far = (expected - i64::from(kept)).unsigned_abs();
            // In 1/16 of an octave.
            let size = |x: u64| 2 * logarithm(2 * x + 1) - 16;
            let features = [32, size(spread), size(far) - size(spread)];
            let level = &mut self.levels[axis];
            let difference = (i64::from(to_encode) - expected) as i32;
            let (difference, error) = self.numbers.code(coder, axis, level.expect(features), difference);
            level.learn(features, error);
            values.push((expected + i64::from(difference)).clamp(0, most) as i32);
        }
    }
}
