//! Lays strips out in memory that a graphics interface has mapped:
//! `cargo run -p tristrip --example upload`.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use tristrip::{Index, Layout};

fn main() -> Result<(), tristrip::Error> {
    let strips = tristrip::stripify_indices(&[0_u32, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7], 8)?;

    // As large as the interface gives it; only the beginning is written.
    let mut mapped = [0_u16; 64];
    for layout in Layout::ALL {
        let count = strips.write_indices(layout, &mut mapped)?;
        println!("{layout}: {:?}", &mapped[..count]);
    }
    println!("a restart is {}", u16::RESTART);

    // Vertex 300 does not fit 8 bits: an error, not a wrong picture.
    let strips = tristrip::stripify_indices(&[0, 1, 300_usize], 301)?;
    match strips.to_indices::<u8>(Layout::List) {
        Ok(_) => println!("an index was cut off"),
        Err(problem) => println!("refused: {problem}"),
    }
    Ok(())
}
