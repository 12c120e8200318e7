//! `flb materials`: what a plant became: its size, its materials and the class that each would get, its nodes, and what
//! was read, skipped and doubted.

use flb_files::publish;
use flb_render::classes::class_views;
use flb_render::picture::png_of;
use flb_scene::classify::table::{MaterialRow, PartRow, parts, rows, text_table};
use flb_scene::classify::{Found, found};
use flb_scene::extents::{Extents, number};
use flb_scene::unit::metres_in;
use flb_scene::{MaterialClass, Mesh};
use serde::Serialize;

use crate::args::MaterialsArgs;
use crate::classes::MeshReader;
use crate::colors::{self, ColorRow};
use crate::exit::{Failure, VERDICT};
use crate::inputs::check_output;
use crate::picture::expect_png;
use crate::print::{self, line, say};
use crate::size::Measured;

/// Nodes that the text lists; JSON has all.
const LISTED: usize = 32;

#[derive(Serialize)]
struct Materials {
    mesh: String,
    /// Whether `flb bake` would know what to do.
    decided: bool,
    #[serde(flatten)]
    measured: Measured,
    /// What is taken off the coordinates of a plant far from its origin.
    offset_m: [f64; 3],
    /// What was made of the file as it asks.
    read: Vec<String>,
    /// What was repaired or ignored.
    skipped: Vec<String>,
    materials: Vec<MaterialRow>,
    /// Of what is leaf or wood; empty while a material is undecided.
    colours: Vec<ColorRow>,
    nodes: Vec<PartRow>,
}

/// Prints the tables; what is undecided says so.
pub(crate) fn run(args: &MaterialsArgs) -> Result<u8, Failure> {
    if let Some(picture) = &args.picture {
        check_output(picture, &[&args.mesh_file], args.existing)?;
        expect_png(picture, "the picture of classes is a PNG: expected FILE.png")?;
    }
    let reader = MeshReader::new(&args.mesh)?;
    let mesh = reader.read(&args.mesh_file)?;
    let at_mesh = |error| Failure::from(error).at(&args.mesh_file);
    let known = found(&mesh, &reader.plants.rules).map_err(at_mesh)?;
    let decided = !known.iter().any(|found| matches!(found, Found::Open(_)));
    if let Some(picture) = &args.picture {
        draw(args, picture, &mesh, &known)?;
    }
    let (offset_m, mut read, mut skipped) = (mesh.offset_m, mesh.notes.clone(), mesh.warnings.clone());
    let nodes = parts(&mesh);
    let is_plant =
        |found: &Found| matches!(found, Found::Class(known) if known.class != MaterialClass::Neither);
    let (materials, measured, colours) = match decided && known.iter().any(is_plant) {
        true => {
            let (classed, _) = reader.plants.class(mesh).map_err(at_mesh)?;
            reader.say_sheets(&args.mesh_file, &classed);
            read.extend(classed.mesh.sheets.notes());
            let measured = Measured::of_reader(&classed, &reader.plants, reader.mend);
            // What is there twice is known with the classes.
            let materials = rows(&classed.mesh, &known);
            let (colours, warnings) = colors::rows(&args.mesh_file, &reader.plants, classed);
            skipped.extend(warnings);
            (materials, measured, colours)
        }
        // What is wood is not known: the box of all there is.
        false => {
            let extents = mesh.bounds().and_then(Extents::of_bounds);
            let measured = Measured::of_box(extents, &reader.plants.settings, reader.mend);
            (rows(&mesh, &known), measured, Vec::new())
        }
    };
    let mesh = args.mesh_file.display().to_string();
    let found = Materials { mesh, decided, measured, offset_m, read, skipped, materials, colours, nodes };
    match args.json {
        true => print::json(&found)?,
        false => print::out(&text(&found, &args.units))?,
    }
    found.measured.say(&args.mesh_file);
    if !decided {
        say!("some materials are undecided; say --leaf, --wood or --ignore with a pattern of their name");
    }
    if args.strict {
        found.measured.strict(&found.skipped, &args.mesh_file)?;
        if !decided {
            return Err(Failure::new(VERDICT, "--strict: some materials are undecided").at(&args.mesh_file));
        }
    }
    Ok(0)
}

fn draw(
    args: &MaterialsArgs,
    picture: &std::path::Path,
    mesh: &Mesh,
    known: &[Found],
) -> Result<(), Failure> {
    let class = |found: &Found| match found {
        Found::Class(classified) => Some(classified.class),
        Found::Open(_) => None,
        Found::Unused => Some(MaterialClass::Neither),
    };
    let classes: Vec<Option<MaterialClass>> = known.iter().map(class).collect();
    let rgb = class_views(mesh, &classes, args.view_size)?;
    let png = png_of([2 * args.view_size; 2], &rgb)?;
    Ok(publish(picture, args.existing, |file| file.write_all(&png))?)
}

fn text(found: &Materials, units: &[&str]) -> String {
    let size = |unit: &&str| {
        let edges = found.measured.size_m.map(|edge_m| number(edge_m / metres_in(unit)));
        format!("{} {unit}", edges.join(" x "))
    };
    let sizes = units.iter().map(size).collect::<Vec<_>>().join(" = ");
    let mut text =
        format!("{}\n{}", text_table(&found.materials), line!("{}: {sizes} (x, y up, z)", found.mesh));
    text += &totals(&found.materials);
    if !found.colours.is_empty() {
        text += &format!("\n{}\n", colors::table(&found.colours).trim_end());
    }
    if found.nodes.len() > 1 {
        text += &format!("\n{}\n", nodes(&found.nodes).trim_end());
    }
    let doubts: Vec<String> = found.measured.doubts.iter().map(|doubt| doubt.message.clone()).collect();
    text += "\n";
    for (word, said) in [("read", &found.read), ("skipped", &found.skipped), ("doubted", &doubts)] {
        match said.as_slice() {
            [] => text += &line!("{word}: nothing"),
            said => said.iter().for_each(|sentence| text += &line!("{word}: {sentence}")),
        }
    }
    text
}

/// Triangles and area of each class that is there, and what alpha leaves of it.
fn totals(rows: &[MaterialRow]) -> String {
    let of_class = |class: &str| {
        let of_it = || rows.iter().filter(|row| row.class == class && row.triangles > 0);
        let sum = |of: &dyn Fn(&MaterialRow) -> f64| of_it().map(of).sum::<f64>();
        let (triangles, area_m2) = (sum(&|row| row.triangles as f64), sum(&|row| row.area_m2));
        let left_m2 = sum(&|row| row.left * row.area_m2);
        let text = line!(
            "{class}: {triangles} triangles, {} m^2, of which {} m^2 are left",
            number(area_m2),
            number(left_m2)
        );
        (triangles > 0.0).then_some(text)
    };
    ["leaf", "wood", "neither", "undecided"].into_iter().filter_map(of_class).collect()
}

/// The nodes or groups that `--node` chooses among.
fn nodes(rows: &[PartRow]) -> String {
    let mut lines =
        vec![["node", "triangles", "area m^2", "from m", "to m", "materials"].map(str::to_owned).to_vec()];
    lines.extend(rows.iter().take(LISTED).map(|row| {
        let [low, high] = row.bounds_m.map(|corner| corner.map(number).join(" "));
        let area = format!("{:.4}", row.area_m2);
        vec![row.node.clone(), row.triangles.to_string(), area, low, high, row.materials.join(", ")]
    }));
    let more = rows.len().saturating_sub(LISTED);
    let table = print::table(&lines);
    if more > 0 { format!("{table}\n{more} more nodes: --json lists all") } else { table }
}
