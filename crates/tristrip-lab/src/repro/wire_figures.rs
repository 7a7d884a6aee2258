//! The bytes of a progressive transmission as in Kim et al. 2005, section 3, written and read back.
//!
//! Metrics of a model, in bytes:
//! - `wire_positions`: the positions of the base mesh; `wire_map`: its index map with symbols;
//! - `wire_records_naive`, `wire_records_encoded`: the records of all vertex splits;
//! - `wire_total`: all bytes sent with symbols, including the header.

use tristrip::Strips;
use tristrip::lod::Encoding;
use tristrip_pipeline::{Error as PipelineError, PreparedModel, levels::LevelPart, levels::ModelLevels};

use crate::error::Error;
use crate::wire::{Encoded, Sizes, WireDecoder, encode_part};

/// The number of evenly spaced levels of each part that are proven.
const PROVEN_STEPS: usize = 8;

/// Encodes all parts of a model, proves the decoded levels, and counts the bytes.
///
/// # Errors
/// The decoded data does not draw the triangles of a level.
pub(super) fn measure(
    prepared: &PreparedModel<'_>,
    levels: &ModelLevels,
) -> Result<[(&'static str, f64); 5], Error> {
    let sizes = |encoding| {
        let parts = levels.parts.iter().zip(prepared.parts());
        let sizes = parts.map(|(part, prepared)| {
            let encoded = encode_part(part, prepared.mesh.positions(), encoding)?;
            prove(part, &encoded)?;
            Ok(encoded.sizes)
        });
        sizes.collect::<Result<Vec<Sizes>, Error>>()
    };
    let (naive, encoded) = (sizes(Encoding::Naive)?, sizes(Encoding::Offsets)?);
    let sum = |sizes: &[Sizes], bytes: fn(&Sizes) -> u64| sizes.iter().map(bytes).sum::<u64>() as f64;
    Ok([
        ("wire_positions", sum(&encoded, |sizes| sizes.position_bytes)),
        ("wire_map", sum(&encoded, |sizes| sizes.map_bytes)),
        ("wire_records_naive", sum(&naive, |sizes| sizes.record_bytes)),
        ("wire_records_encoded", sum(&encoded, |sizes| sizes.record_bytes)),
        ("wire_total", sum(&encoded, Sizes::total_bytes)),
    ])
}

/// Decodes the bytes of a part, and proves some of its levels, including the first and the last.
fn prove(part: &LevelPart, encoded: &Encoded) -> Result<(), Error> {
    let mut decoder = WireDecoder::default();
    decoder.update(&encoded.bytes).map_err(PipelineError::from)?;
    let last = part.sequence().len();
    for step in 0..=PROVEN_STEPS {
        let level = last * step / PROVEN_STEPS;
        decoder.set_level(level).map_err(PipelineError::from)?;
        let mut display = Strips::default();
        for strip in decoder.strips().iter() {
            let vertices: Vec<u32> = strip.iter().map(|&v| encoded.vertices[v as usize]).collect();
            display.push(&vertices);
        }
        part.prove(level, &display)?;
    }
    Ok(())
}
