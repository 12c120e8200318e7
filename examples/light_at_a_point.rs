//! Asks a baked file for the light at a few points, under three suns.
//!
//! `cargo run -p flb-examples --bin light_at_a_point [FILE.flb]`; without a file it takes the shrub of the tests.
#![forbid(unsafe_code)]

use std::error::Error;

use flb_format::sun;
use flb_runtime::{Daylight, Library, SpeciesLight, Transform};

const SHRUB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../runtime-loader/golden/shrub.flb");

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| SHRUB.to_owned());
    let library = Library::open(&path)?;
    for (index, species) in library.container().species().iter().enumerate() {
        let meta = &species.meta;
        println!("{}: {} bands, {} sites along each edge", meta.name, meta.band_count(), meta.grid.lattice);
        let light = SpeciesLight::load(&library, index)?;
        // A physical file takes the sky's fluence, the sun's being 1; the papers' model a factor on its ambient basis.
        let sky = if meta.physical().is_some() { 0.36 } else { 0.02 };
        let (min, max) = (meta.bounds_m.min, meta.bounds_m.max);
        for [azimuth_deg, elevation_deg] in [[90.0, 10.0], [180.0, 60.0], [270.0, 10.0]] {
            let daylight =
                Daylight { towards_sun: sun::towards_sun(azimuth_deg, elevation_deg), sun: 1.0, sky };
            let lit = light.lit_by(&daylight, &Transform::IDENTITY)?;
            for share in [0.25, 0.5, 0.75] {
                // On the axis of the plant, from low to high.
                let place = [0.5, share, 0.5];
                let point: [f32; 3] =
                    std::array::from_fn(|axis| (min[axis] + place[axis] * (max[axis] - min[axis])) as f32);
                let mut bands = vec![0.0; light.bands()];
                lit.at(point, &mut bands);
                let text: Vec<String> = bands.iter().map(|band| format!("{band:.3}")).collect();
                println!("  sun {azimuth_deg}, {elevation_deg}: {:.2} m up {}", point[1], text.join(" "));
            }
        }
    }
    Ok(())
}
