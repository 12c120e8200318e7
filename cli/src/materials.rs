//! `flb materials`: the materials of a mesh, and the class that each would get.

use flb_scene::classify::table::{MaterialRow, table, text_table};
use serde::Serialize;

use crate::args::MaterialsArgs;
use crate::classes::MeshReader;
use crate::exit::Failure;
use crate::print::{self, say};

#[derive(Serialize)]
struct Materials {
    mesh: String,
    /// Whether `flb bake` would know what to do.
    decided: bool,
    materials: Vec<MaterialRow>,
}

/// Prints the table; what is undecided says so.
pub fn run(args: &MaterialsArgs) -> Result<u8, Failure> {
    let reader = MeshReader::new(&args.mesh)?;
    let mesh = reader.read(&args.mesh_file)?;
    let rows =
        table(&mesh, &reader.plants.rules).map_err(|error| Failure::from(error).at(&args.mesh_file))?;
    let decided = rows.iter().all(|row| row.class != "undecided");
    let materials = Materials { mesh: args.mesh_file.display().to_string(), decided, materials: rows };
    match args.json {
        true => print::json(&materials)?,
        false => print::out(&text_table(&materials.materials))?,
    }
    if !decided {
        say!("some materials are undecided; say --leaf, --wood or --ignore with a pattern of their name");
    }
    Ok(0)
}
