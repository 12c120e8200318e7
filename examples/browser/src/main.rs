//! The same on this machine: the bits of each number, a line each.
#![forbid(unsafe_code)]

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("expected FILE.flb")?;
    for value in flb_browser::light(std::fs::read(path)?)? {
        println!("{}", value.to_bits());
    }
    Ok(())
}
