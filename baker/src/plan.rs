//! From a scene to what is worth baking for it: bases, lattice and bands.
//!
//! ```text
//! Scene + bounds of its species -plan-> Outline -Plan::of-> plan file -> bake and pack
//! ```
//!
//! Bases: [`flb_format::sun::reach`], each species by the way that its instances are turned. Lattices: [`screen`].

pub mod file;
pub mod screen;
pub mod solar;

use std::collections::HashSet;

use flb_format::Placement;
use flb_format::bases::BaseSet;
use flb_format::meta::Bounds;
use flb_format::sun::reach::{Reach, Rotation, SunSet, Zone};

pub use file::{Plan, PlanError, PlannedSpecies, SpeciesPlan};
pub use screen::OnScreen;

use flb_scene::scene::{Scene, SceneSky, Suns};

/// Bases, bands and lattices that a scene needs, and the reason.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// The suns and the turns in words, for the file that lacks the rest.
    pub reason: String,
    /// Bands to bake; `None`: all.
    pub bands: Option<Vec<String>>,
    /// Bases of a plant that turns freely about the vertical.
    pub any_upright: BaseSet,
    /// Whether a sun of the scene is ever above the horizon, or stands fixed.
    pub has_sun: bool,
    /// Needs of the species of the scene, in its order.
    pub species: Vec<Need>,
}

/// Bases and lattice that a species needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Need {
    /// Name of the species.
    pub name: String,
    /// Number of its instances.
    pub instances: usize,
    /// Bases that some instance needs.
    pub bases: BaseSet,
    /// Size at which a camera sees the species; `None` without a camera that looks, or where it has no instance.
    pub on_screen: Option<OnScreen>,
}

/// Works out what a scene needs. `bounds` holds those of each species' mesh; a species without is given no lattice.
///
/// A scene of 100,000 instances takes a fraction of a second: what takes the time is the number of different rotations.
///
/// # Panics
/// If there are not as many bounds as species.
pub fn plan(scene: &Scene, bounds: &[Option<Bounds>]) -> Outline {
    assert_eq!(bounds.len(), scene.species.len(), "one bounds per species");
    let mut suns = sun_set(&scene.suns);
    suns.fixed_deg.extend(scene.sunlight.added.iter().map(|one| one.sun_deg));
    let reach = Reach::new(&suns);
    let sky = match (&scene.sky, scene.ambient == Some(0.0)) {
        (_, true) => BaseSet::NONE,
        (SceneSky::Even, false) => BaseSet::NONE.with(0),
        // What an uneven sky scatters is summed over suns in all directions.
        (SceneSky::Clear { .. } | SceneSky::Image(_), false) => BaseSet::ALL,
    };
    let mut of_species: Vec<Vec<&Placement>> = vec![Vec::new(); scene.species.len()];
    scene.instances.iter().for_each(|instance| of_species[instance.species].push(instance));
    let species = scene.species.iter().zip(&of_species).zip(bounds).map(|((species, instances), bounds)| {
        let turned = if species.upright { reach.any_yaw() } else { rotated(&reach, instances) };
        let seen = scene.camera.as_ref().zip(bounds.as_ref());
        Need {
            name: species.name.clone(),
            instances: instances.len(),
            bases: turned.union(sky),
            on_screen: seen
                .and_then(|(camera, bounds)| screen::on_screen(camera, bounds, instances.iter().copied())),
        }
    });
    Outline {
        reason: reason(scene, !reach.is_dark()),
        bands: scene.bands.clone(),
        any_upright: reach.any_yaw().union(sky),
        has_sun: !reach.is_dark(),
        species: species.collect(),
    }
}

/// The suns of a scene as a set of directions.
pub fn sun_set(suns: &Suns) -> SunSet {
    match suns {
        Suns::Sky => SunSet { fixed_deg: Vec::new(), zones: vec![Zone::SKY] },
        Suns::Fixed(fixed) => SunSet { fixed_deg: fixed.clone(), zones: Vec::new() },
        Suns::Path(path) => {
            let (latitude_deg, declination_deg) = (path.latitude_deg, solar::declinations_deg(path));
            SunSet { fixed_deg: Vec::new(), zones: vec![Zone { latitude_deg, declination_deg }] }
        }
    }
}

/// Rotations that [`rotated`] remembers: of a million different ones, a set would be larger than the scene.
const MAX_REMEMBERED: usize = 1 << 16;

/// The directional bases that instances need as they are turned. Equal rotations are asked for once, where there are
/// few of them, and nothing is asked when nothing can be added; the order in which instances come changes nothing.
fn rotated(reach: &Reach, instances: &[&Placement]) -> BaseSet {
    let upright = instances.iter().all(|instance| instance.transform.is_upright());
    let most = if upright { reach.any_yaw() } else { BaseSet::ALL };
    let mut asked: HashSet<[u64; 9]> = HashSet::new();
    let mut reached = BaseSet::NONE;
    for instance in instances {
        if reached.union(BaseSet::NONE.with(0)) == most.union(BaseSet::NONE.with(0)) {
            break;
        }
        if asked.len() == MAX_REMEMBERED {
            asked.clear();
        }
        if asked.insert(bits(&instance.transform.rotation)) {
            reach.add_rotated(&instance.transform.rotation, &mut reached);
        }
    }
    reached
}

fn bits(rotation: &Rotation) -> [u64; 9] {
    std::array::from_fn(|i| rotation[i / 3][i % 3].to_bits())
}

fn reason(scene: &Scene, has_sun: bool) -> String {
    let suns = match &scene.suns {
        Suns::Sky => "every sun above the horizon".to_owned(),
        Suns::Fixed(suns) if suns.len() == 1 => format!("the sun at {},{}", suns[0][0], suns[0][1]),
        Suns::Fixed(suns) => format!("{} suns that stand still", suns.len()),
        Suns::Path(path) => format!(
            "{} at latitude {}, {} to {}",
            if has_sun { "the suns" } else { "no sun rises" },
            path.latitude_deg,
            path.from,
            path.to
        ),
    };
    let added = match scene.sunlight.added.len() {
        0 => String::new(),
        added => format!(" and {added} more"),
    };
    let upright = scene.species.iter().filter(|species| species.upright).count();
    let turns = match upright {
        all if all == scene.species.len() => "plants that turn only about the vertical",
        0 => "plants as the scene turns them",
        _ => "plants as the scene turns them, or only about the vertical",
    };
    let sky = match (&scene.sky, scene.ambient == Some(0.0)) {
        (_, true) => ", no ambient light",
        (SceneSky::Even, false) => "",
        (SceneSky::Clear { .. } | SceneSky::Image(_), false) => ", an uneven sky",
    };
    format!("{suns}{added}, {turns}{sky}")
}

#[cfg(test)]
mod tests;
