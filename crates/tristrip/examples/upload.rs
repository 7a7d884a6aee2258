//! Writes strips to memory mapped by a graphics API. Run with
//! `cargo run -p tristrip --example upload`.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use tristrip::{Index, Layout};

fn main() -> Result<(), tristrip::Error> {
    let strips = tristrip::stripify_indices(&[0_u32, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7], 8)?;

    // The mapped memory may be larger; only its start is written.
    let mut mapped = [0_u16; 64];
    for layout in Layout::ALL {
        let count = strips.write_indices(layout, &mut mapped)?;
        println!("{layout}: {:?}", &mapped[..count]);
    }
    println!("a restart is {}", u16::RESTART);

    // Vertex 300 does not fit in 8 bits: this is an error, not a wrong image.
    let strips = tristrip::stripify_indices(&[0, 1, 300_usize], 301)?;
    match strips.to_indices::<u8>(Layout::List) {
        Ok(_) => println!("an index was cut off"),
        Err(problem) => println!("refused: {problem}"),
    }
    Ok(())
}
