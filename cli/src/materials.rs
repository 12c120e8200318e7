//! `flb materials`: the materials of a mesh, the class that each would get, and how large the plant is.

use flb_scene::classify::table::{MaterialRow, table, text_table};
use flb_scene::{ClassedMesh, Extents, classify};
use serde::Serialize;

use crate::args::MaterialsArgs;
use crate::classes::MeshReader;
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
}

/// Prints the table; what is undecided says so.
pub fn run(args: &MaterialsArgs) -> Result<u8, Failure> {
    let reader = MeshReader::new(&args.mesh)?;
    let mesh = reader.read(&args.mesh_file)?;
    let rows =
        table(&mesh, &reader.plants.rules).map_err(|error| Failure::from(error).at(&args.mesh_file))?;
    let decided = rows.iter().all(|row| row.class != "undecided");
    let measured = match classify(&mesh, &reader.plants.rules) {
        Ok(decisions) => {
            let classes = decisions.iter().map(|decision| decision.class).collect();
            Measured::of(&ClassedMesh { mesh, classes }, &reader.plants.settings, reader.mend)
        }
        // What is wood is not known: the box of all there is.
        Err(_) => {
            let extents = mesh.bounds().and_then(Extents::of_bounds);
            Measured::of_box(extents, &reader.plants.settings, reader.mend)
        }
    };
    let mesh = args.mesh_file.display().to_string();
    let materials = Materials { mesh, decided, measured, materials: rows };
    match args.json {
        true => print::json(&materials)?,
        false => {
            let size = line!("{}: {} (x, y up, z)", materials.mesh, materials.measured.text());
            print::out(&format!("{}\n{size}", text_table(&materials.materials)))?;
        }
    }
    materials.measured.say(&args.mesh_file);
    if !decided {
        say!("some materials are undecided; say --leaf, --wood or --ignore with a pattern of their name");
    }
    Ok(0)
}
