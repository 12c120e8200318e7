//! Bakes a plant that was made in memory, and lights it: no file is read or written.
//!
//! `cargo run -p flb-examples --bin bake_in_memory`
#![forbid(unsafe_code)]

use std::error::Error;

use flb_baker::bake::{BakeObserver, BakeSettings, NoStore, bake};
use flb_format::{Quality, sun};
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use flb_runtime::{Daylight, Library, SpeciesLight, Transform};
use flb_scene::mesh::Material;
use flb_scene::{MaterialClass, Mesh, Observer, Plant, Step};

/// Turns that leaves make around the stem, and leaves of a turn.
const TURNS: [u32; 2] = [12, 8];

/// Says on stdout what the bake does. A tool shows a bar here; [`Observer::is_cancelled`] is its button to stop.
struct Talk;

impl Observer for Talk {
    fn begin(&self, step: Step, species: &str) {
        println!("{species}: {}", step.name());
    }

    fn note(&self, text: &str) {
        println!("{text}");
    }
}

impl BakeObserver for Talk {}

/// Leaves of two triangles each, in turns around a stem that is not drawn; 1 m high.
fn fern() -> Plant {
    let mut mesh = Mesh { materials: vec![Material::opaque("leaf")], ..Mesh::default() };
    for turn in 0..TURNS[0] {
        for leaf in 0..TURNS[1] {
            let angle = std::f32::consts::TAU * (leaf as f32 + 0.5 * turn as f32) / TURNS[1] as f32;
            let (height_m, length_m) = (turn as f32 / TURNS[0] as f32, 0.5 - 0.035 * turn as f32);
            let along = [libm::cosf(angle), libm::sinf(angle)];
            let first = mesh.positions.len() as u32;
            for [out, side, up] in [[0.05, 0.0, 0.0], [0.5, 0.12, 0.1], [1.0, 0.0, 0.05], [0.5, -0.12, 0.1]] {
                let [out, side] = [out * length_m, side * length_m];
                let x = along[0] * out - along[1] * side;
                let z = along[1] * out + along[0] * side;
                mesh.positions.push([x, height_m + up * length_m, z]);
                mesh.normals.push([0.0, 1.0, 0.0]);
                mesh.uvs.push([0.0, 0.0]);
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            mesh.triangle_material.extend([0, 0]);
        }
    }
    Plant::new("fern", mesh, vec![MaterialClass::Leaf])
}

fn main() -> Result<(), Box<dyn Error>> {
    let settings = BakeSettings { voxels: 512, ..BakeSettings::of(Quality::Draft) };
    let baked = bake(fern(), &settings, &NoStore, &Talk)?;
    let coded = encode_species(&baked.fields, &EncodeSettings::default(), &|_| Ok(()))?;
    let mut file = Vec::new();
    write_library_to(&mut file, &[&coded])?;
    println!("{} bytes", file.len());

    let library = Library::from_source("fern in memory", Box::new(file))?;
    let light = SpeciesLight::load(&library, 0)?;
    let noon = Daylight { towards_sun: sun::towards_sun(180.0, 60.0), sun: 1.0, sky: 0.36 };
    let lit = light.lit_by(&noon, &Transform::IDENTITY)?;
    for height_m in [0.1, 0.5, 0.9] {
        let mut rgb = [0.0; 3];
        lit.at([0.0, height_m, 0.0], &mut rgb);
        println!("{height_m} m above the ground: {:.3} {:.3} {:.3}", rgb[0], rgb[1], rgb[2]);
    }
    Ok(())
}
