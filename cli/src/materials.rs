//! `flb materials`: the materials of a mesh, the class that each would get, and how large the plant is.

use flb_scene::classify::decide;
use flb_scene::classify::table::{MaterialRow, rows, text_table};
use flb_scene::{Extents, classify};
use serde::Serialize;

use crate::args::MaterialsArgs;
use crate::classes::MeshReader;
use crate::colors::{self, ColorRow};
use crate::exit::Failure;
use crate::print::{self, line, say};
use crate::size::Measured;

#[derive(Serialize)]
struct Materials {
    mesh: String,
    /// Whether `flb bake` would know what to do.
    decided: bool,
    #[serde(flatten)]
    measured: Measured,
    materials: Vec<MaterialRow>,
    /// Of what is leaf or wood; empty while a material is undecided.
    colours: Vec<ColorRow>,
}

/// Prints the table; what is undecided says so.
pub fn run(args: &MaterialsArgs) -> Result<u8, Failure> {
    let reader = MeshReader::new(&args.mesh)?;
    let mesh = reader.read(&args.mesh_file)?;
    let at_mesh = |error| Failure::from(error).at(&args.mesh_file);
    let decisions = decide(&mesh, &reader.plants.rules).map_err(at_mesh)?;
    let (rows, measured, colours) = match classify(&mesh, &reader.plants.rules) {
        Ok(_) => {
            let (classed, _) = reader.plants.class(mesh).map_err(at_mesh)?;
            reader.say_sheets(&args.mesh_file, &classed);
            let measured = Measured::of(&classed, &reader.plants.settings, reader.mend);
            // What is there twice is known with the classes.
            (
                rows(&classed.mesh, &decisions),
                measured,
                colors::rows(&args.mesh_file, &reader.plants, classed),
            )
        }
        // What is wood is not known: the box of all there is.
        Err(_) => {
            let extents = mesh.bounds().and_then(Extents::of_bounds);
            let measured = Measured::of_box(extents, &reader.plants.settings, reader.mend);
            (rows(&mesh, &decisions), measured, Vec::new())
        }
    };
    let decided = rows.iter().all(|row| row.class != "undecided");
    let mesh = args.mesh_file.display().to_string();
    let materials = Materials { mesh, decided, measured, materials: rows, colours };
    match args.json {
        true => print::json(&materials)?,
        false => {
            let size = line!("{}: {} (x, y up, z)", materials.mesh, materials.measured.text());
            let colours = match materials.colours.is_empty() {
                true => String::new(),
                false => format!("\n{}", colors::table(&materials.colours)),
            };
            print::out(&format!("{}\n{size}{colours}", text_table(&materials.materials)))?;
        }
    }
    materials.measured.say(&args.mesh_file);
    if !decided {
        say!("some materials are undecided; say --leaf, --wood or --ignore with a pattern of their name");
    }
    Ok(0)
}
