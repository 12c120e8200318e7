//! Light that the plants of a scene take from each other and give to each other: from the species' media and where they
//! stand to media on coarse lattices, ready to be solved.
//!
//! ```text
//! TurbidMedium of each species -grains-> points -alone-> the species by itself on coarse sites, calibrated
//!                                       points, instances, ground -stand-> the whole scene on one lattice
//! ```
//!
//! A species' fields know neither neighbours nor ground. What these change is found on sites far larger than a species'
//! own, twice: with all of the scene, and with the species alone. Both have the same faults (gaps that are filled,
//! edges that are blurred, beams that are cut in pieces), so their quotient and their difference have little of them. A
//! quotient by empty space, as the papers' kind of factor would be, counts a tree's own shade again.
//!
//! All is in one band, luminance. Matter of several species in one site scatters as the mean of it by area; where
//! leaves of different species send light, and how they are inclined, is the mean over the scene.
//!
//! The ground is matter: it stops what comes from below, lies in the shade of plants, and throws back what its
//! reflectance says. Beyond the lattice it is a plain in the open.

mod alone;
mod deposit;
mod digest;
mod entry;
mod error;
mod grains;
mod ground;
mod paper;
#[cfg(test)]
mod tests;

use flb_format::colors::color_bands;
use flb_format::matter::{
    BandSurfaces, INCLINATIONS, LeafAngles, LeafSurface, Surfaces, TurbidMedium, WoodSurface,
};
use flb_format::{Grid, Placement};

use crate::crown::{Crown, as_open_as};
use deposit::Sums;
use flb_transport::ordinates::Surroundings;
use flb_transport::turbid::BandScatter;
use flb_transport::turbid::scatter;
use grains::Grain;

pub use digest::{matter_digest, stand_digest};
pub use entry::{Entry, entry, paper_entry};
pub use error::SceneLightError;
pub use ground::Ground;
pub use paper::{coarse_medium, extinction, mean_optics, optics_in_luminance};

/// Luminance of linear R, G and B (ITU-R BT.709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// A grain stands for no more than this share of a site's edge.
const GRAIN: f64 = 0.5;

/// A species of a scene, as its own light was baked.
#[derive(Debug, Clone)]
pub struct Plant<'a> {
    /// Name of the species in the scene.
    pub name: &'a str,
    /// Fine medium of the species.
    pub turbid: &'a TurbidMedium,
}

/// Medium and surfaces on the lattice of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Stand {
    /// All plants and the ground (as wood), in the scene's frame.
    pub turbid: TurbidMedium,
    /// `[site][leaf, wood]` in the order of [`TurbidMedium::sites`].
    pub albedos: Vec<[f32; 2]>,
    /// `[site]` of the lattice.
    pub is_ground: Vec<bool>,
    /// Mean surfaces of its plants.
    pub surfaces: BandSurfaces,
    /// Light from below the horizon where nothing stands, relative to the sky's.
    pub below: f32,
}

impl Stand {
    /// Mean scattering of the stand's matter.
    pub fn scatter(&self) -> BandScatter {
        scatter(&self.surfaces)
    }

    /// Surroundings of the stand, which a solve has to know beside the medium.
    pub fn surroundings(&self) -> Surroundings<'_> {
        Surroundings {
            below: self.below,
            albedos: Some(std::slice::from_ref(&self.albedos)),
            ..Surroundings::NONE
        }
    }
}

/// Surfaces in the one band of a scene's light.
///
/// # Errors
/// [`SceneLightError::Bands`] unless red, green and blue are among them.
pub fn luminance(species: &str, surfaces: &Surfaces) -> Result<BandSurfaces, SceneLightError> {
    let colors = colors_of(species, surfaces.bands.iter().map(|band| band.name.as_str()))?;
    let mean = |of: &dyn Fn(&BandSurfaces) -> f64| -> f64 {
        colors.iter().zip(LUMINANCE).map(|(&band, weight)| weight * of(&surfaces.bands[band])).sum()
    };
    Ok(band(
        mean(&|band| band.leaf.reflectance),
        mean(&|band| band.leaf.transmittance),
        mean(&|band| band.wood.reflectance),
    ))
}

/// Places of red, green and blue among the bands of a species.
fn colors_of<'n>(
    species: &str,
    names: impl Iterator<Item = &'n str> + Clone,
) -> Result<[usize; 3], SceneLightError> {
    color_bands(names.clone()).ok_or_else(|| SceneLightError::Bands {
        species: species.to_owned(),
        found: names.collect::<Vec<_>>().join(", "),
    })
}

fn band(reflectance: f64, transmittance: f64, wood: f64) -> BandSurfaces {
    BandSurfaces {
        name: flb_format::scene_light::LUMINANCE.to_owned(),
        leaf: LeafSurface { reflectance, transmittance },
        wood: WoodSurface { reflectance: wood },
    }
}

/// A scene on its way to a lattice.
#[derive(Debug)]
pub struct Scenery<'a> {
    plants: &'a [Plant<'a>],
    instances: &'a [Placement],
    ground: Option<&'a Ground>,
    grid: Grid,
    /// Per species.
    usage: Vec<Usage>,
}

/// How a species stands in the scene.
#[derive(Debug)]
struct Usage {
    /// Mean scale of its instances; 1 without any.
    scale: f64,
    grains: Vec<Grain>,
    /// Optical area of the grains, m^2: leaf, wood.
    area_m2: [f64; 2],
}

impl<'a> Scenery<'a> {
    /// Lays a lattice of `lattice` sites along each edge over the plants.
    ///
    /// # Errors
    /// [`SceneLightError`] for a scene without instances, an instance of no species, a species without matter, a
    /// lattice out of range.
    pub fn new(
        plants: &'a [Plant<'a>],
        instances: &'a [Placement],
        ground: Option<&'a Ground>,
        lattice: u32,
    ) -> Result<Scenery<'a>, SceneLightError> {
        if !(lattice.is_power_of_two() && (16..=256).contains(&lattice)) {
            return Err(SceneLightError::Lattice { found: lattice });
        }
        if instances.is_empty() {
            return Err(SceneLightError::NoInstances);
        }
        if let Some(instance) = instances.iter().position(|instance| instance.species >= plants.len()) {
            let (found, most) = (instances[instance].species, plants.len().saturating_sub(1));
            return Err(SceneLightError::Species { instance, found, most });
        }
        let corners = plants.iter().map(corners).collect::<Result<Vec<_>, _>>()?;
        let extent = extent(instances, &corners);
        let grid = ground::grid_over(extent, tallest(instances, &corners), ground, lattice);
        let usage = (0..plants.len()).map(|species| {
            let mine = instances.iter().filter(|one| one.species == species);
            let (mut count, mut sum, mut largest) = (0.0, 0.0, 0.0_f64);
            for one in mine {
                (count, sum, largest) =
                    (count + 1.0, sum + one.transform.scale, largest.max(one.transform.scale));
            }
            let [scale, largest] = if count > 0.0 { [sum / count, largest] } else { [1.0; 2] };
            let grains = grains::grains(plants[species].turbid, GRAIN * grid.spacing_m / largest);
            let area_m2 = [0, 1].map(|kind| grains.iter().map(|grain| grain.area_m2[kind]).sum());
            Usage { scale, grains, area_m2 }
        });
        let usage = usage.collect();
        Ok(Scenery { plants, instances, ground, grid, usage })
    }

    /// The lattice over the scene, in its frame.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The matter of a species by itself, on sites as large as the scene's are beside its mean instance. It is less
    /// open than the plant: see [`Scenery::as_open`].
    ///
    /// # Errors
    /// [`SceneLightError::TooFine`].
    ///
    /// # Panics
    /// If there is no such species.
    pub fn coarse(&self, species: usize) -> Result<TurbidMedium, SceneLightError> {
        let Usage { scale, grains, .. } = &self.usage[species];
        alone::coarse(&self.plants[species], grains, self.grid.spacing_m / scale)
    }

    /// The species' [`Scenery::coarse`] matter times the factor that makes it as open as the plant is. Of the crown,
    /// the mesh is the fine medium.
    ///
    /// # Panics
    /// If there is no such species.
    pub fn as_open(&self, species: usize, coarse: TurbidMedium) -> Crown {
        as_open_as(self.plants[species].turbid, coarse)
    }

    /// All instances and the ground. `factors` are those of the species alone, `surfaces` theirs in luminance.
    ///
    /// # Panics
    /// If there are fewer factors or surfaces than species.
    pub fn stand(&self, factors: &[f64], surfaces: &[BandSurfaces]) -> Stand {
        let tops = self.ground.map(|ground| ground.tops(&self.grid));
        let mut sums = Sums::new(self.grid, tops);
        let mut mix = Mix::default();
        for instance in self.instances {
            let plant = &self.plants[instance.species];
            let surfaces = &surfaces[instance.species];
            let usage = &self.usage[instance.species];
            let LeafSurface { reflectance, transmittance } = surfaces.leaf;
            let (factor, albedo) =
                (factors[instance.species], [reflectance + transmittance, surfaces.wood.reflectance]);
            sums.add(instance, &usage.grains, factor, albedo);
            mix.add(plant, surfaces, usage.area_m2(factor, instance));
        }
        let soil = self.ground.map(Ground::soil);
        let (turbid, albedos, is_ground) = sums.finish(mix.angles(), soil);
        let below = self.ground.map_or(1.0, |ground| ground.reflectance as f32);
        Stand { turbid, albedos, is_ground, surfaces: mix.surfaces(), below }
    }

    /// Matter of all instances by itself, without the ground.
    ///
    /// # Panics
    /// If there are fewer factors than species.
    pub fn matter(&self, factors: &[f64]) -> TurbidMedium {
        let mut sums = Sums::new(self.grid, None);
        for instance in self.instances {
            let species = instance.species;
            sums.add(instance, &self.usage[species].grains, factors[species], [0.0; 2]);
        }
        sums.finish(LeafAngles::spherical(), None).0
    }

    /// Optical area of all instances, m^2: `[species][leaf, wood]`.
    ///
    /// # Panics
    /// If there are fewer factors than species.
    pub fn areas_m2(&self, factors: &[f64]) -> Vec<[f64; 2]> {
        let mut areas = vec![[0.0; 2]; self.plants.len()];
        for instance in self.instances {
            let species = instance.species;
            let more = self.usage[species].area_m2(factors[species], instance);
            areas[species].iter_mut().zip(more).for_each(|(area, more)| *area += more);
        }
        areas
    }
}

impl Usage {
    /// Optical area of an instance, m^2: leaf, wood. It grows with the square of its scale.
    fn area_m2(&self, factor: f64, instance: &Placement) -> [f64; 2] {
        let larger = factor * instance.transform.scale * instance.transform.scale;
        self.area_m2.map(|area| larger * area)
    }
}

/// Means over all matter of a scene, by area.
#[derive(Default)]
struct Mix {
    /// Leaf, wood.
    area_m2: [f64; 2],
    /// Reflectance and transmittance of leaves, reflectance of wood, times area.
    sums: [f64; 3],
    /// Shares of inclinations times area of leaves.
    inclined: [f64; INCLINATIONS],
}

impl Mix {
    fn add(&mut self, plant: &Plant, surfaces: &BandSurfaces, area: [f64; 2]) {
        self.sums[0] += area[0] * surfaces.leaf.reflectance;
        self.sums[1] += area[0] * surfaces.leaf.transmittance;
        self.sums[2] += area[1] * surfaces.wood.reflectance;
        (0..2).for_each(|kind| self.area_m2[kind] += area[kind]);
        let shares = plant.turbid.angles.shares();
        self.inclined.iter_mut().zip(shares).for_each(|(sum, share)| *sum += area[0] * share);
    }

    fn surfaces(&self) -> BandSurfaces {
        let [leaf, wood] = self.area_m2.map(|area| if area > 0.0 { 1.0 / area } else { 0.0 });
        band(self.sums[0] * leaf, self.sums[1] * leaf, self.sums[2] * wood)
    }

    fn angles(&self) -> LeafAngles {
        LeafAngles::from_areas(self.inclined).unwrap_or_else(LeafAngles::spherical)
    }
}

/// The box around a plant's matter, metres: lowest and highest coordinates.
fn corners(plant: &Plant) -> Result<[[f64; 3]; 2], SceneLightError> {
    let extent_m = plant.turbid.grid.extent_m(&plant.turbid.sites());
    extent_m.ok_or_else(|| SceneLightError::Empty { species: plant.name.to_owned() })
}

/// The box around all instances.
fn extent(instances: &[Placement], corners: &[[[f64; 3]; 2]]) -> [[f64; 3]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for instance in instances {
        let stands = instance.transform;
        for corner in 0..8 {
            let of = |axis: usize| corners[instance.species][corner >> axis & 1][axis];
            let point = stands.world_from_model_point(std::array::from_fn(of));
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
    }
    [low, high]
}

/// Height of the tallest instance.
fn tallest(instances: &[Placement], corners: &[[[f64; 3]; 2]]) -> f64 {
    let height =
        |one: &Placement| one.transform.scale * (corners[one.species][1][1] - corners[one.species][0][1]);
    instances.iter().map(height).fold(0.0, f64::max)
}
