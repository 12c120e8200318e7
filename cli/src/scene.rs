//! `flb scene`: a scene file of a glTF that holds a forest. A file in between can be read, changed and compared, and is
//! drawn as every other scene is.

mod text;

use std::path::{Path, PathBuf};

use flb_files::publish;
use flb_scene::import::{Plant, Stand, Up, read_stand};
use flb_scene::scene::HeightMap;
use flb_scene::{ImportSettings, SpeciesFile};
use serde::Serialize;

use crate::args::SceneArgs;
use crate::classes::read_mesh;
use crate::exit::{Failure, INPUT_OUTPUT, USAGE};
use crate::inputs::{check_output, choose_species, open};
use crate::print::{self, line, say};
use flb_scene::plant::recorded_settings;

/// What `--json` prints (cli/schema/scene.json).
#[derive(Serialize)]
struct Found {
    output: String,
    instances: usize,
    /// Whether the file has them; else they were made up.
    has_camera: bool,
    has_sun: bool,
    species: Vec<Kind>,
}

/// A mesh that became a species.
#[derive(Serialize)]
struct Kind {
    name: String,
    gltf_mesh: String,
    instances: usize,
    light: Option<String>,
    species_file: Option<String>,
}

/// The files that flags name for each species.
struct Named<'a> {
    lights: Vec<Option<&'a Path>>,
    species_files: Vec<Option<&'a Path>>,
}

/// Reads where plants stand, writes the scene, says what there is.
pub(crate) fn run(args: &SceneArgs) -> Result<u8, Failure> {
    let files = args.light.iter().chain(&args.species_file).map(|(_, file)| file.as_path());
    let inputs: Vec<&Path> = files.chain([args.file.as_path()]).chain(args.height_map.as_deref()).collect();
    check_output(&args.output, &inputs, args.existing)?;
    check_ground(args)?;
    let mut stand = read_stand(&args.file, &args.leave_out, &args.node)
        .map_err(|error| Failure::from(error).at(&args.file))?;
    for warning in &stand.warnings {
        say!("warning: {warning}");
    }
    let named = Named {
        lights: by_species(&stand, "--light", &args.light, &args.file)?,
        species_files: by_species(&stand, "--species-file", &args.species_file, &args.file)?,
    };
    let models = (0..stand.species.len())
        .map(|index| named.model(args, &stand, index))
        .collect::<Result<Vec<_>, _>>()?;
    for plant in &mut stand.plants {
        let (up, unit_m, offset_m) = models[plant.species];
        *plant = plant.of_model(up, unit_m, offset_m);
        if !(1e-6..=1e6).contains(&plant.scale) {
            let (name, scale) = (&stand.species[plant.species].name, plant.scale);
            let message = format!(
                "species {name:?}: at {unit_m} m per unit a plant has scale {scale}, expected 1e-6 to 1e6"
            );
            return Err(Failure::new(USAGE, message).at(&args.file));
        }
    }
    let text = text::scene(args, &stand, &named)?;
    publish(&args.output, args.existing, |file| file.write_all(text.as_bytes()))?;
    let found = found(args, &stand, &named);
    match args.json {
        true => print::json(&found)?,
        false => print::out(&lines(&found))?,
    }
    Ok(0)
}

fn check_ground(args: &SceneArgs) -> Result<(), Failure> {
    if let Some(height_m) = args.ground.filter(|height_m| !(-1e9..=1e9).contains(height_m)) {
        return Err(Failure::new(USAGE, format!("--ground is {height_m}, expected -1e9 to 1e9 metres")));
    }
    let is_area = |edges: [f64; 2]| edges.iter().all(|edge| (1e-3..=1e9).contains(edge));
    if let Some(area) = args.area.filter(|area| !is_area(*area)) {
        return Err(Failure::new(
            USAGE,
            format!("--area is {area:?}, expected edges of 0.001 to 1e9 metres"),
        ));
    }
    // A scene that cannot be read is none.
    if let (Some(file), Some(height_m), Some(size_m)) = (args.height_map.clone(), args.height, args.area) {
        HeightMap { file, origin_m: [0.0; 3], size_m, height_m }.read()?;
    }
    Ok(())
}

/// For each species the file that a flag names for it.
fn by_species<'a>(
    stand: &Stand,
    flag: &str,
    named: &'a [(String, PathBuf)],
    forest: &Path,
) -> Result<Vec<Option<&'a Path>>, Failure> {
    let mut files: Vec<Option<&Path>> = vec![None; stand.species.len()];
    for (word, file) in named {
        let Some(index) = stand.find(word) else {
            let names: Vec<&str> =
                stand.species.iter().take(20).map(|species| species.gltf_mesh.as_str()).collect();
            let more = if stand.species.len() > names.len() { ", ..." } else { "" };
            let message =
                format!("{flag} {word:?}: no such mesh stands there; there are: {}{more}", names.join(", "));
            return Err(Failure::new(USAGE, message).at(forest));
        };
        if !file.is_file() {
            return Err(
                Failure::new(INPUT_OUTPUT, format!("{flag} {word:?}: there is no such file")).at(file)
            );
        }
        if files[index].replace(file).is_some() {
            return Err(Failure::new(USAGE, format!("{flag}: mesh {word:?} has a file already")).at(file));
        }
    }
    Ok(files)
}

impl Named<'_> {
    /// How the model of a species is read from its mesh: its light says how it was baked, else its species file how it
    /// will be.
    fn model(&self, args: &SceneArgs, stand: &Stand, index: usize) -> Result<(Up, f64, [f64; 3]), Failure> {
        let settings = match (self.lights[index], self.species_files[index]) {
            (Some(light), _) => {
                let library = open(light)?;
                let all = library.container().species();
                let name = Some(stand.species[index].name.as_str()).filter(|_| all.len() > 1);
                recorded_settings(&all[choose_species(&library, name, None)?].meta)
            }
            (None, Some(file)) => SpeciesFile::read(file)?.import_settings(&Default::default()),
            (None, None) => Default::default(),
        };
        let species = &stand.species[index];
        let offset_m = match settings.offset_m {
            Some(offset_m) => offset_m,
            None if species.is_far => {
                let gltf_mesh = Some(species.gltf_mesh.clone());
                read_mesh(&args.file, &ImportSettings { gltf_mesh, ..settings.clone() }, true)?.offset_m
            }
            None => [0.0; 3],
        };
        Ok((settings.up.unwrap_or(Up::Y), settings.unit_m.unwrap_or(1.0), offset_m))
    }
}

fn found(args: &SceneArgs, stand: &Stand, named: &Named) -> Found {
    let mut counts = vec![0; stand.species.len()];
    stand.plants.iter().for_each(|plant: &Plant| counts[plant.species] += 1);
    let text = |path: Option<&Path>| path.map(|path| path.display().to_string());
    let kind = |(index, instances): (usize, usize)| Kind {
        name: stand.species[index].name.clone(),
        gltf_mesh: stand.species[index].gltf_mesh.clone(),
        instances,
        light: text(named.lights[index]),
        species_file: text(named.species_files[index]),
    };
    Found {
        output: args.output.display().to_string(),
        instances: stand.plants.len(),
        has_camera: stand.camera.is_some(),
        has_sun: stand.sun.is_some(),
        species: counts.into_iter().enumerate().map(kind).collect(),
    }
}

fn lines(found: &Found) -> String {
    let head = ["species", "mesh", "instances", "light"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    rows.extend(found.species.iter().map(|kind| {
        let light = kind.light.clone().unwrap_or_else(|| "-".to_owned());
        vec![kind.name.clone(), kind.gltf_mesh.clone(), kind.instances.to_string(), light]
    }));
    let of_file = |is_there: bool| if is_there { "the file's" } else { "made up" };
    let (camera, sun) = (of_file(found.has_camera), of_file(found.has_sun));
    let read = line!("{}: {} plants; camera: {camera}, sun: {sun}", found.output, found.instances);
    format!("{}\n{read}", print::table(&rows))
}
