//! `flb scatter`: a scene file with many plants of a few species, upright, turned and sized at random.

mod plants;

use std::fmt::Write as _;
use std::path::Path;

use flb_files::{check_unread, publish};
use flb_scene::scene::scatter::{Amount, Plot, Spots, scatter};
use flb_scene::scene::{Grey, HeightMap, Heights, MAX_SCENE_BYTES, Scene};
use serde::Serialize;

use crate::args::{ScatterArgs, SpeciesArg};
use crate::exit::{Failure, INPUT_OUTPUT, LIMIT, USAGE};
use crate::inputs::check_output;
use crate::print::{self, line};
use crate::size::Measured;
use crate::toml_text::{toml_path, toml_string};

#[derive(Serialize)]
struct Scattered {
    output: String,
    instances: usize,
    /// No two plants are nearer to each other.
    spacing_m: f64,
    species: Vec<SpeciesCount>,
}

#[derive(Serialize)]
struct SpeciesCount {
    name: String,
    instances: usize,
    /// At scale 1.
    #[serde(flatten)]
    measured: Measured,
}

/// A plant of the scene.
#[derive(Clone)]
struct ScatteredPlant {
    species: usize,
    position_m: [f64; 3],
    yaw_deg: f64,
    scale: f64,
}

/// Scatters, writes the scene, says how many plants there are.
pub(crate) fn run(args: &ScatterArgs) -> Result<u8, Failure> {
    let mut inputs: Vec<&Path> = args.species.iter().map(|species| species.mesh.as_path()).collect();
    inputs.extend(args.species.iter().filter_map(|species| species.light.as_deref()));
    inputs.extend(args.density.as_deref());
    inputs.extend(args.height_map.as_deref());
    check_output(&args.output, &inputs, args.existing)?;
    check_species(&args.species)?;
    if !(args.scale[0] >= 1e-3 && args.scale[1] <= 1e3) {
        return Err(Failure::new(USAGE, format!("--scale is {:?}, expected 0.001 to 1000", args.scale)));
    }
    let heights = height_map(args).map(|map| map.read()).transpose()?;
    let amount = match (args.count, args.spacing) {
        (Some(count), _) => Amount::Count(count),
        (None, spacing) => Amount::Spacing(spacing.unwrap_or(0.0)),
    };
    let density = args.density.as_deref().map(Grey::read).transpose()?;
    let spots = scatter(&Plot { area_m: args.area, amount, density, seed: args.seed })?;
    let measured = args.species.iter().map(plants::measure).collect::<Result<Vec<_>, _>>()?;
    check_unread(&args.output)?;
    let stand = stand(args, &spots, heights.as_ref());
    let text = scene(args, &stand)?;
    check_readable(args, &stand)?;
    publish(&args.output, args.existing, |file| file.write_all(text.as_bytes()))?;
    let count = |index: usize| stand.iter().filter(|plant| plant.species == index).count();
    let scattered = Scattered {
        output: args.output.display().to_string(),
        instances: stand.len(),
        spacing_m: spots.spacing_m,
        species: args
            .species
            .iter()
            .zip(measured)
            .enumerate()
            .map(|(index, (species, measured))| SpeciesCount {
                name: species.name.clone(),
                instances: count(index),
                measured,
            })
            .collect(),
    };
    match args.json {
        true => print::json(&scattered)?,
        false => {
            let shares = scattered.species.iter().map(|share| format!("{} {}", share.instances, share.name));
            let counts = line!(
                "{}: {} plants ({}), {:.2} m apart or more",
                scattered.output,
                scattered.instances,
                shares.collect::<Vec<_>>().join(", "),
                scattered.spacing_m
            );
            let sizes = scattered
                .species
                .iter()
                .map(|share| line!("{}: {} at scale 1 (x, y up, z)", share.name, share.measured.text()));
            print::out(&(counts + &sizes.collect::<String>()))?;
        }
    }
    Ok(0)
}

/// Names are unique and files are there, so that the scene can be drawn.
fn check_species(species: &[SpeciesArg]) -> Result<(), Failure> {
    for (index, one) in species.iter().enumerate() {
        if species[..index].iter().any(|other| other.name == one.name) {
            return Err(Failure::new(USAGE, format!("--species: {:?} twice", one.name)));
        }
        for file in [Some(&one.mesh), one.light.as_ref()].into_iter().flatten() {
            if !file.is_file() {
                let message = format!("species {:?}: there is no such file", one.name);
                return Err(Failure::new(INPUT_OUTPUT, message).at(file));
            }
        }
    }
    Ok(())
}

/// The map lies on the rectangle.
fn height_map(args: &ScatterArgs) -> Option<HeightMap> {
    let (file, height_m) = args.height_map.clone().zip(args.height)?;
    let [x, z] = args.area;
    Some(HeightMap { file, origin_m: [-x / 2.0, 0.0, -z / 2.0], size_m: args.area, height_m })
}

fn stand(args: &ScatterArgs, spots: &Spots, heights: Option<&Heights>) -> Vec<ScatteredPlant> {
    let total: f64 = args.species.iter().map(|species| species.weight).sum();
    let place = |(index, [x, z]): (usize, &[f64; 2])| {
        let draw = |what: u64| unit(args.seed, index as u64 * 4 + what);
        let mut left = draw(0) * total;
        let species = args.species.iter().position(|species| {
            left -= species.weight;
            left < 0.0
        });
        ScatteredPlant {
            species: species.unwrap_or(args.species.len() - 1),
            position_m: [*x, heights.map_or(0.0, |heights| heights.at_m(*x, *z)), *z],
            yaw_deg: match args.yaws.map(f64::from) {
                Some(yaws) => 360.0 / yaws * (yaws * draw(1)).floor(),
                None => 360.0 * draw(1),
            },
            scale: args.scale[0] + (args.scale[1] - args.scale[0]) * draw(2),
        }
    };
    spots.points_m.iter().enumerate().map(place).collect()
}

/// 0 to below 1, of a seed and a place in its sequence (SplitMix64, Steele and others 2014).
fn unit(seed: u64, place: u64) -> f64 {
    let mut v = seed.wrapping_add((place + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    v = (v ^ (v >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    v = (v ^ (v >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((v ^ (v >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Refuses words that no scene may have, such as a name with a line break: the scene is read as every command reads it,
/// with the plants that it may fail for, one of each species and those at its ends.
fn check_readable(args: &ScatterArgs, stand: &[ScatteredPlant]) -> Result<(), Failure> {
    let of_species =
        (0..args.species.len()).filter_map(|index| stand.iter().find(|plant| plant.species == index));
    let by = |axis: usize| {
        move |a: &&ScatteredPlant, b: &&ScatteredPlant| a.position_m[axis].total_cmp(&b.position_m[axis])
    };
    let ends = (0..3).flat_map(|axis| [stand.iter().min_by(by(axis)), stand.iter().max_by(by(axis))]);
    let few: Vec<ScatteredPlant> = of_species.chain(ends.flatten()).cloned().collect();
    let folder = args.output.parent().unwrap_or(Path::new(""));
    match Scene::parse("the scene to be written", folder, &scene(args, &few)?) {
        Ok(_) => Ok(()),
        Err(error) => Err(Failure::new(USAGE, error)),
    }
}

/// The scene as TOML.
fn scene(args: &ScatterArgs, stand: &[ScatteredPlant]) -> Result<String, Failure> {
    let highest = stand.iter().map(|plant| plant.position_m[1]).fold(f64::NEG_INFINITY, f64::max);
    let [x, z] = args.area;
    // Over the tops of the first trees.
    let (away, above) = (z / 2.0 + (0.25 * x.max(z)).min(40.0), (0.2 * x.max(z)).min(30.0));
    let mut text = format!(
        "[sun]\nfixed = [[135.0, 35.0]]\n\n[camera]\nposition_m = [0.0, {:?}, {away:?}]\nlook_at_m = [0.0, {:?}, 0.0]\n\
         fov_deg = 45.0\nheight_px = 540\n\n[ground]\n",
        highest + above,
        highest
    );
    let push = |text: &mut String, line: std::fmt::Arguments| {
        text.write_fmt(line).expect("a string takes everything");
    };
    match height_map(args) {
        None => text += "height_m = 0.0\n",
        Some(HeightMap { file, origin_m, size_m, height_m }) => push(
            &mut text,
            format_args!(
                "height_map = {}\norigin_m = {origin_m:?}\nsize_m = {size_m:?}\nheight_m = {height_m:?}\n",
                toml_path(&args.output, &file)?
            ),
        ),
    }
    let used = |index: usize| stand.iter().any(|plant| plant.species == index);
    for (index, species) in args.species.iter().enumerate() {
        let (name, file) = (toml_string(&species.name), toml_path(&args.output, &species.mesh)?);
        push(&mut text, format_args!("\n[[species]]\nname = {name}\nfile = {file}\n"));
        if let Some(light) = &species.light {
            push(&mut text, format_args!("light = {}\n", toml_path(&args.output, light)?));
        }
        // A scene refuses a species that stands nowhere, unless it may stand anywhere.
        if !used(index) {
            text += "upright = true\n";
        }
    }
    // Those of few yaws are so close to theirs that nothing lies between them.
    let digits = if args.yaws.is_some() { 6 } else { 2 };
    for ScatteredPlant { species, position_m: [x, y, z], yaw_deg, scale } in stand {
        let name = toml_string(&args.species[*species].name);
        push(
            &mut text,
            format_args!(
                "\n[[instance]]\nspecies = {name}\nposition_m = [{x:.3}, {y:.3}, {z:.3}]\nyaw_deg = {yaw_deg:.digits$}\n\
                 scale = {scale:.3}\n"
            ),
        );
        // What is longer could not be read.
        if text.len() as u64 > MAX_SCENE_BYTES {
            let plants = stand.len();
            let message = format!("a scene of {plants} plants is over the limit of {MAX_SCENE_BYTES} bytes");
            return Err(Failure::new(LIMIT, message).at(&args.output));
        }
    }
    Ok(text)
}
