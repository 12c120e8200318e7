//! What the docs say that the solve costs and how exact it is, as tables to paste. All on the built-in oak of 80,000
//! triangles (1024^3 voxels), the papers' optics, all cores.
//!
//! `cargo bench -p flb-baker --bench solve -- [PART]... [--lattice N] [--plot FILE.svg]`
//!
//! Parts; all of them if none is named:
//! * `accuracy`: tolerance -> sweeps, seconds, errors estimated and true, of all bases and bands. At lattice 64 unless
//!   `--lattice` says else: the f64 solutions to compare with take minutes at 128.
//! * `sides`: the sweep and the explicit solver carried to the same true error, at 64 and 128.
//! * `curve`: cost from lattice 32 to 256; `--plot` draws it.
//! * `bandwidth`: the explicit solver's iterations against the memory's speed, at 64 and 128.

mod accuracy;
mod bandwidth;
mod curve;
mod oak;
mod sides;

use std::path::PathBuf;

use peak_alloc::PeakAlloc;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

const PARTS: [&str; 4] = ["accuracy", "sides", "curve", "bandwidth"];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (mut parts, mut lattice, mut plot) = (vec![], 64, None);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{argument} without a value"));
        match argument.as_str() {
            // Cargo's.
            "--bench" => (),
            "--lattice" => lattice = value().parse().expect("--lattice takes a number"),
            "--plot" => plot = Some(PathBuf::from(value())),
            part if PARTS.contains(&part) => parts.push(part.to_owned()),
            other => panic!("{other}: expected some of {PARTS:?}, --lattice N, --plot FILE.svg"),
        }
    }
    let wants = |part: &str| parts.is_empty() || parts.iter().any(|wanted| wanted == part);
    if wants("accuracy") {
        accuracy::print(lattice);
    }
    if wants("sides") {
        [64, 128].into_iter().for_each(sides::print);
    }
    if wants("curve") {
        curve::print(plot.as_deref());
    }
    if wants("bandwidth") {
        bandwidth::print(&[64, 128]);
    }
}
