//! Reproducible random numbers for tests that mutate files.
#![allow(dead_code, reason = "each test file uses a part of it")]

/// Returns a generator of numbers below its argument, always with the same seed.
pub(crate) fn random() -> impl FnMut(usize) -> usize {
    let mut random = tristrip::random::Random::new(1);
    move |below: usize| random.below(below)
}

/// Iterates over copies of a GLB with one to four digits changed.
pub(crate) fn mutated_documents(glb: &[u8], count: usize) -> impl Iterator<Item = Vec<u8>> {
    let mut random = random();
    let digits: Vec<usize> = (20..glb.len()).filter(|&at| glb[at].is_ascii_digit()).collect();
    (0..count).map(move |_| {
        let mut changed = glb.to_vec();
        for _ in 0..=random(3) {
            let at = digits[random(digits.len())];
            changed[at] = b'0' + random(10) as u8;
        }
        changed
    })
}

/// Changes, adds or removes one to `most` + 1 bytes.
pub(crate) fn mutate(bytes: &mut Vec<u8>, most: usize, random: &mut impl FnMut(usize) -> usize) {
    const INTERESTING: [u8; 23] = *b"\0\x01\x7f\x80\xff\n\r\t\\#/-+.eE 0129nf";
    for _ in 0..=random(most) {
        let at = random(bytes.len());
        match random(4) {
            0 => bytes[at] ^= 1 << random(8),
            1 => bytes[at] = INTERESTING[random(INTERESTING.len())],
            2 => bytes.insert(at, INTERESTING[random(INTERESTING.len())]),
            _ => drop(bytes.remove(at)),
        }
    }
}
