//! Reads arbitrary bytes as `.tlod`, unchanged and with corrected checksums. A model that can be
//! read is written with the same bytes.
#![no_main]

use tristrip_io::tlod::{TlodLimits, read, write};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    check(data);
    check(&sealed(data));
});

fn check(data: &[u8]) {
    let Ok(model) = read(data, &TlodLimits::default()) else { return };
    let mut again = Vec::new();
    write(&model, &mut again).expect("a model that was read can be written");
    assert!(again == data);
}

/// Corrects the checksum of each complete section.
fn sealed(data: &[u8]) -> Vec<u8> {
    let (mut bytes, mut at) = (data.to_vec(), 12);
    while let Some(&length) = bytes.get(at + 4..at + 12).and_then(|length| length.as_array()) {
        let Ok(length) = usize::try_from(u64::from_le_bytes(length)) else { break };
        let last = bytes.len().saturating_sub(4);
        let Some(end) = (at + 12).checked_add(length).filter(|&end| end <= last) else { break };
        let checksum = crc32fast::hash(&bytes[at..end]);
        bytes[end..end + 4].copy_from_slice(&checksum.to_le_bytes());
        at = end + 4;
    }
    bytes
}
