//! The head of chunk 0: grids, counts and attributes, followed by the weights and the base mesh.

use super::channels::{ChannelKind, ChannelModel};
use super::chunk::{ChunkReader, push_number};
use super::grid::{AttributeType, Channel, Grid};
use super::places::{ESTIMATES, EstimateWeights, MAX_BITS, USUAL_WEIGHTS};
use crate::entropy::numbers::code_small;
use crate::entropy::range_coder::BitCoder;
use crate::entropy::slots::Simple;
use crate::text::counted;

/// The maximum number of attributes of a mesh, and the maximum length of a name in bytes.
const MAX_CHANNELS: u32 = 64;
const MAX_NAME_BYTES: u32 = 256;

/// The fields of chunk 0 before the base mesh.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Head {
    pub(super) grid: Grid,
    pub(super) position_bits: u32,
    /// The position bits that the base mesh does not have yet.
    pub(super) unknown_bits: u32,
    pub(super) channels: Vec<Channel>,
    /// The number of triangles of the base mesh.
    pub(super) base_triangles: u32,
    /// The numbers of collapses, triangles and vertices of the full mesh.
    pub(super) levels: u32,
    pub(super) triangles: u32,
    pub(super) vertices: u32,
}

/// An invalid field of the head.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HeadFault {
    pub(super) found: String,
    pub(super) expected: &'static str,
}

fn fault<T>(found: String, expected: &'static str) -> Result<T, HeadFault> {
    Err(HeadFault { found, expected })
}

const KINDS: [ChannelKind; 4] =
    [ChannelKind::Linear, ChannelKind::Octahedral, ChannelKind::Tangent, ChannelKind::Names];

impl Head {
    pub(super) fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend([self.position_bits as u8, self.unknown_bits as u8]);
        bytes.extend(self.grid.origin.iter().chain([&self.grid.step]).flat_map(|x| x.to_le_bytes()));
        for number in
            [self.base_triangles, self.levels, self.triangles, self.vertices, self.channels.len() as u32]
        {
            push_number(bytes, number);
        }
        for channel in &self.channels {
            push_number(bytes, channel.name.len() as u32);
            bytes.extend(channel.name.as_bytes());
            let place = |index: Option<usize>| index.unwrap_or(0) as u8;
            let value_type = place(AttributeType::ALL.iter().position(|&kind| kind == channel.value_type));
            let kind = place(KINDS.iter().position(|&kind| kind == channel.kind));
            let normalized = u8::from(channel.normalized);
            bytes.extend([value_type, channel.components, normalized, kind, channel.bits as u8]);
            if matches!(channel.kind, ChannelKind::Linear | ChannelKind::Names) {
                bytes.extend(channel.origins.iter().chain([&channel.step]).flat_map(|x| x.to_le_bytes()));
            }
        }
    }

    pub(super) fn read(reader: &mut ChunkReader<'_>) -> Result<Self, HeadFault> {
        let short = HeadFault { found: "the end of the chunk".into(), expected: "the head of a base mesh" };
        let number = |reader: &mut ChunkReader<'_>| match reader.number() {
            Some(Ok(number)) => Ok(number),
            Some(Err(_)) => fault("a number of more than 32 bits".into(), "a count"),
            None => Err(short.clone()),
        };
        let byte = |reader: &mut ChunkReader<'_>| reader.byte().ok_or_else(|| short.clone());
        let [position_bits, unknown_bits] = [u32::from(byte(reader)?), u32::from(byte(reader)?)];
        if position_bits == 0 || position_bits > MAX_BITS || unknown_bits >= position_bits {
            let found = format!("{}, {unknown_bits} of them unknown", counted(position_bits, "bit"));
            return fault(found, "1 to 16 bits per coordinate, and fewer unknown ones");
        }
        let mut floats = [0.0; 4];
        for float in &mut floats {
            *float = reader.float().ok_or_else(|| short.clone())?;
        }
        let [x, y, z, step] = floats;
        let grid = Grid { origin: [x, y, z], step };
        if !grid.is_finite(position_bits) {
            return fault(
                format!("origin {x} {y} {z}, step {step}"),
                "finite positions and a step of at least 0",
            );
        }
        let mut counts = [0; 5];
        for count in &mut counts {
            *count = number(reader)?;
        }
        let [base_triangles, levels, triangles, vertices, channel_count] = counts;
        if channel_count > MAX_CHANNELS {
            return fault(format!("{channel_count} attributes"), "at most 64");
        }
        let mut channels = Vec::new();
        for _ in 0..channel_count {
            let length = number(reader)?;
            if length > MAX_NAME_BYTES {
                return fault(format!("a name of {length} bytes"), "at most 256 bytes");
            }
            let name = reader.take(length as usize).ok_or_else(|| short.clone())?;
            let Ok(name) = std::str::from_utf8(name) else {
                return fault("a name that is not UTF-8".into(), "UTF-8");
            };
            let mut fields = [0; 5];
            for field in &mut fields {
                *field = byte(reader)?;
            }
            let [value_type, components, normalized, kind, bits] = fields;
            let (Some(&value_type), Some(&kind)) =
                (AttributeType::ALL.get(usize::from(value_type)), KINDS.get(usize::from(kind)))
            else {
                return fault(
                    format!("values of type {value_type} and kind {kind}"),
                    "types 0 to 7, kinds 0 to 3",
                );
            };
            let is_shaped = match kind {
                ChannelKind::Octahedral => components == 3,
                ChannelKind::Tangent => components == 4,
                ChannelKind::Linear | ChannelKind::Names => components > 0,
            };
            let is_float = matches!(value_type, AttributeType::F32 | AttributeType::F64);
            let is_vector = matches!(kind, ChannelKind::Octahedral | ChannelKind::Tangent);
            if !is_shaped || bits > 24 || normalized > 1 || is_vector && (bits == 0 || !is_float) {
                let found = format!("{} of {}", counted(components, "component"), counted(bits, "bit"));
                return fault(found, "components and a type that fit the kind, and at most 24 bits");
            }
            let mut channel = Channel {
                name: name.into(),
                components,
                normalized: normalized == 1,
                value_type,
                kind,
                bits: bits.into(),
                origins: Vec::new(),
                step: 0.0,
            };
            if matches!(kind, ChannelKind::Linear | ChannelKind::Names) {
                for _ in 0..components {
                    channel.origins.push(reader.double().ok_or_else(|| short.clone())?);
                }
                channel.step = reader.double().ok_or_else(|| short.clone())?;
                let far = channel.step * f64::from(1_u32 << channel.bits);
                let is_finite = channel.origins.iter().all(|origin| (origin + far).is_finite());
                if !(channel.step >= 0.0 && is_finite) {
                    return fault(
                        format!("a step of {}", channel.step),
                        "finite values and a step of at least 0",
                    );
                }
            }
            channels.push(channel);
        }
        Ok(Self { grid, position_bits, unknown_bits, channels, base_triangles, levels, triangles, vertices })
    }

    /// Returns the models of the attributes.
    pub(super) fn channel_models(&self) -> Vec<ChannelModel> {
        self.channels
            .iter()
            .map(|channel| ChannelModel::new(channel.kind, channel.width(), channel.bits))
            .collect()
    }
}

/// Codes the weights of the estimates as differences from the usual ones.
pub(super) fn code_weights<C: BitCoder>(coder: &mut C, to_encode: &EstimateWeights) -> EstimateWeights {
    let mut model = Simple::new(32);
    let mut weights = USUAL_WEIGHTS;
    for (of_class, to_encode) in weights.iter_mut().zip(to_encode) {
        for i in 0..ESTIMATES {
            for side in 0..2 {
                // 0, −1, 1, −2, 2, …
                let difference = to_encode[i][side] - of_class[i][side];
                let folded = ((difference << 1) ^ (difference >> 31)).cast_unsigned();
                let folded = code_small(coder, &mut model, folded) & 0x3FF;
                of_class[i][side] += (folded >> 1).cast_signed() ^ -(folded & 1).cast_signed();
            }
        }
    }
    weights
}
