//! Plants of a glTF as the text of a scene file: numbers rounded far below what is seen, so that they are short and
//! stay the same through an export and back; plants that only turn about the vertical by their yaw, which a plan needs
//! to know.

use std::fmt::Write as _;

use flb_scene::import::{Plant, Stand};
use flb_scene::scene::MAX_SCENE_BYTES;

use super::Named;
use crate::args::SceneArgs;
use crate::exit::{Failure, LIMIT};
use crate::toml_text::{decimal, decimals, digits, toml_path, toml_string};

/// Decimals of metres: micrometres.
const POSITION_DECIMALS: usize = 6;
/// Decimals of a quaternion, and of degrees: a tree of 30 m is off by micrometres.
const ROTATION_DECIMALS: usize = 7;
/// A quaternion's x and z below this are the rounding of f32, and the plant is upright.
const UPRIGHT: f64 = 1e-6;
/// Least extent that a made-up camera looks over, metres.
const MIN_EXTENT_M: f64 = 20.0;

/// The whole file.
pub(super) fn scene(args: &SceneArgs, stand: &Stand, named: &Named) -> Result<String, Failure> {
    let mut text = String::new();
    let [azimuth, elevation] = stand.sun.unwrap_or([135.0, 35.0]);
    push(&mut text, format_args!("[sun]\nfixed = [{}]\n", decimals([azimuth, elevation], ROTATION_DECIMALS)));
    push_camera(&mut text, stand);
    push_ground(&mut text, args)?;
    let file = toml_path(&args.output, &args.file)?;
    let mut names = Vec::with_capacity(stand.species.len());
    for (index, species) in stand.species.iter().enumerate() {
        let (name, mesh) = (toml_string(&species.name), toml_string(&species.gltf_mesh));
        push(&mut text, format_args!("\n[[species]]\nname = {name}\nfile = {file}\ngltf_mesh = {mesh}\n"));
        for (key, files) in [("species_file", &named.species_files), ("light", &named.lights)] {
            if let Some(path) = files[index] {
                push(&mut text, format_args!("{key} = {}\n", toml_path(&args.output, path)?));
            }
        }
        names.push(name);
    }
    for plant in &stand.plants {
        push_plant(&mut text, &names[plant.species], plant);
        if text.len() as u64 > MAX_SCENE_BYTES {
            let plants = stand.plants.len();
            let message = format!("a scene of {plants} plants is over the limit of {MAX_SCENE_BYTES} bytes");
            return Err(Failure::new(LIMIT, message).at(&args.file));
        }
    }
    Ok(text)
}

fn push(text: &mut String, more: std::fmt::Arguments) {
    text.write_fmt(more).expect("a string takes everything");
}

/// The file's camera; else one in the south that looks over all of it.
fn push_camera(text: &mut String, stand: &Stand) {
    let (position_m, look_at_m, fov_deg) = match &stand.camera {
        Some(camera) => (camera.position_m, camera.look_at_m, camera.fov_deg),
        None => {
            let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for (axis, x) in stand.plants.iter().flat_map(|plant| plant.position_m.into_iter().enumerate()) {
                low[axis] = low[axis].min(x);
                high[axis] = high[axis].max(x);
            }
            let middle: [f64; 3] = std::array::from_fn(|axis| (low[axis] + high[axis]) / 2.0);
            let extent = (high[0] - low[0]).max(high[2] - low[2]).max(MIN_EXTENT_M);
            // Over the tops of the first plants.
            let (away, above) = ((0.25 * extent).min(40.0), (0.2 * extent).min(30.0));
            let look_at_m = [middle[0], high[1], middle[2]];
            ([middle[0], high[1] + above, high[2].max(middle[2]) + away], look_at_m, 45.0)
        }
    };
    push(
        text,
        format_args!(
            "\n[camera]\nposition_m = {}\nlook_at_m = {}\nfov_deg = {}\nheight_px = 540\n",
            decimals(position_m, POSITION_DECIMALS),
            decimals(look_at_m, POSITION_DECIMALS),
            decimal(fov_deg, POSITION_DECIMALS)
        ),
    );
}

fn push_ground(text: &mut String, args: &SceneArgs) -> Result<(), Failure> {
    if let Some(height_m) = args.ground {
        push(text, format_args!("\n[ground]\nheight_m = {}\n", decimal(height_m, POSITION_DECIMALS)));
    }
    if let (Some(map), Some(height_m), Some(size_m)) = (&args.height_map, args.height, args.area) {
        let (map, origin_m) = (toml_path(&args.output, map)?, [-size_m[0] / 2.0, 0.0, -size_m[1] / 2.0]);
        push(
            text,
            format_args!(
                "\n[ground]\nheight_map = {map}\norigin_m = {origin_m:?}\nsize_m = {size_m:?}\nheight_m = {height_m:?}\n"
            ),
        );
    }
    Ok(())
}

fn push_plant(text: &mut String, name: &str, plant: &Plant) {
    let position_m = decimals(plant.position_m, POSITION_DECIMALS);
    push(text, format_args!("\n[[instance]]\nspecies = {name}\nposition_m = {position_m}\n"));
    let [x, y, z, w] = plant.rotation;
    if x.abs() < UPRIGHT && z.abs() < UPRIGHT {
        // A yaw is clockwise seen from above, a rotation about +Y the other way round.
        let yaw_deg = decimal((-2.0 * libm::atan2(y, w)).to_degrees().rem_euclid(360.0), ROTATION_DECIMALS);
        push(text, format_args!("yaw_deg = {yaw_deg}\n"));
    } else {
        push(text, format_args!("rotation = {}\n", decimals(plant.rotation, ROTATION_DECIMALS)));
    }
    push(text, format_args!("scale = {}\n", digits(plant.scale)));
}
