//! A stand of a few plants, its light found in two ways: by one fine lattice that holds all of them, and by the fine
//! light of each plant alone with scene light.
//!
//! Instances stand where their sites fall on sites of the fine lattice, turned by quarters, so that both ways have the
//! same matter at the same places and all of the difference is the scene light's.

use std::sync::Arc;

use flb_baker::bake::{BakeSettings, ModelSettings, NoStore, PhysicalSettings, SunChoice, bake};
use flb_baker::crown::LeafAngleChoice;
use flb_baker::scene_light::{Entry, Ground, Plant, Scenery, entry, luminance};
use flb_fixtures::PlantKind;
use flb_format::light::{Light, LightError};
use flb_format::matter::{BandSurfaces, Optics, TurbidMedium};
use flb_format::scene_light::{Role, SceneFactor};
use flb_format::sun::directions::SunDirections;
use flb_format::{Codec, Grid, Placement, SpeciesFields, Transform};
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use flb_runtime::scene_light::{Modulations, SceneLight};
use flb_runtime::{Library, RuntimeError};
use flb_scene::Unobserved;
use flb_scene::leaf::knapp_carter;
use flb_transport::ordinates::{self, Ordinates, OrdinatesSettings, SunBasis};
use flb_transport::turbid::scatter;

use crate::default_bake::grown;

mod paper;

/// Fluence of the sky, the sun's being 1: as `flb render` has it.
pub const SKY: f32 = 0.36;

/// Turns about the vertical by quarters, clockwise seen from above.
pub const QUARTERS: [[[f64; 3]; 3]; 4] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
    [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
];

/// A species with its medium.
pub struct Kind {
    /// Of the species.
    pub name: String,
    /// Fine.
    pub turbid: TurbidMedium,
    /// In luminance.
    pub surfaces: BandSurfaces,
    /// Of a plant of the model `paper`, whose surfaces do not count.
    pub optics: Option<Optics>,
}

impl Kind {
    /// A built-in plant on a lattice, its leaves those of Knapp and Carter.
    pub fn grown(kind: PlantKind, triangles: u32, lattice: u32) -> Kind {
        // Its own light is not looked at here, and is solved as coarsely as it can be.
        let model = PhysicalSettings {
            suns: SunChoice::Fixed(SunBasis::Lattice18),
            ordinates: Ordinates::Lattice18,
            rays: Some(1),
            leaf_angles: LeafAngleChoice::Spherical,
            max_passes: 1,
            ..PhysicalSettings::default()
        };
        let model = ModelSettings::Physical(model);
        let settings = BakeSettings { lattice, voxels: 8 * lattice, model, ..BakeSettings::default() };
        let baked = bake(grown(kind, triangles), &settings, &NoStore, &Unobserved).expect("a good plant");
        Kind::of(&baked.fields)
    }

    /// A plant that was baked.
    ///
    /// # Panics
    /// If it is of the other model, or of other bands than R, G and B.
    pub fn of(fields: &SpeciesFields) -> Kind {
        let name = fields.meta.name.clone();
        let (surfaces, _) = fields.meta.physical().expect("the default model");
        let surfaces = luminance(&name, surfaces).expect("three bands");
        let turbid = fields.turbid.clone().expect("the default model has one");
        Kind { name, turbid, surfaces, optics: None }
    }

    /// A ball of leaves, its lowest point the origin.
    pub fn ball(name: &str, lattice: u32, radius_m: f64, per_m: f32) -> Kind {
        let spacing_m = 2.0 * radius_m / f64::from(lattice - 6);
        let half = spacing_m * f64::from(lattice) / 2.0;
        let grid = Grid { lattice, origin_m: [-half, radius_m - half, -half], spacing_m };
        let per_m = |site: u32| {
            let at = grid.site(site as usize).map(|c| (f64::from(c) + 0.5) * spacing_m - half);
            let is_inside = at.iter().map(|c| c * c).sum::<f64>() < radius_m * radius_m;
            if is_inside { per_m } else { 0.0 }
        };
        let leaf_per_m = (0..grid.sites() as u32).map(per_m).collect();
        let wood_per_m = vec![0.0; grid.sites()];
        let turbid = TurbidMedium {
            grid,
            leaf_per_m,
            wood_per_m,
            angles: flb_format::matter::LeafAngles::spherical(),
        };
        Kind { name: name.to_owned(), ..Kind::of_turbid(turbid) }
    }

    /// A plant of no name, its leaves those of Knapp and Carter.
    fn of_turbid(turbid: TurbidMedium) -> Kind {
        let surfaces = luminance("", &knapp_carter()).expect("three bands");
        Kind { name: String::new(), turbid, surfaces, optics: None }
    }

    /// Light at every site of a medium that scatters as the plant does, under one sun.
    pub fn light_at_sites(&self, turbid: &TurbidMedium, sun: [f64; 3]) -> Vec<SunAndSky> {
        match &self.optics {
            Some(optics) => paper::light_at_sites(&self.name, turbid, optics, sun),
            None => light_at_sites(turbid, &self.surfaces, sun),
        }
    }

    fn as_plant(&self) -> Plant<'_> {
        Plant { name: &self.name, turbid: &self.turbid }
    }

    /// The box around its matter, metres.
    pub fn extent_m(&self) -> [[f64; 3]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for site in self.turbid.sites() {
            let middle = self.turbid.grid.middle_m(self.turbid.grid.site(site as usize));
            for (axis, middle) in middle.into_iter().enumerate() {
                low[axis] = low[axis].min(middle - self.turbid.grid.spacing_m / 2.0);
                high[axis] = high[axis].max(middle + self.turbid.grid.spacing_m / 2.0);
            }
        }
        [low, high]
    }
}

/// Plants of a few kinds and where they stand.
pub struct Stand {
    /// Species.
    pub kinds: Vec<Kind>,
    /// Of them.
    pub instances: Vec<Placement>,
    /// Below them.
    pub ground: Option<Ground>,
}

impl Stand {
    /// Instances (kind, quarter turns, x and z) of sizes as they are, on no ground, moved by less than a site so that
    /// their sites fall on those of the first.
    pub fn in_step(kinds: Vec<Kind>, places: &[(usize, usize, [f64; 2])]) -> Stand {
        let first = kinds[places[0].0].turbid.grid;
        let instances = places.iter().map(|&(species, quarters, [x, z])| {
            let rotation = QUARTERS[quarters];
            let mut one =
                Placement { species, transform: Transform { rotation, position_m: [x, 0.0, z], scale: 1.0 } };
            let grid = &kinds[species].turbid.grid;
            assert!((grid.spacing_m / first.spacing_m - 1.0).abs() < 1e-9, "kinds on sites of one size");
            let middle =
                first.lattice_from_model(one.transform.world_from_model_point(grid.middle_m([0; 3])));
            for (position_m, middle) in one.transform.position_m.iter_mut().zip(middle) {
                let off = middle - 0.5 - (middle - 0.5).round();
                *position_m -= off * first.spacing_m;
            }
            one
        });
        let instances = instances.collect();
        Stand { kinds, instances, ground: None }
    }

    fn plants(&self) -> Vec<Plant<'_>> {
        self.kinds.iter().map(Kind::as_plant).collect()
    }

    /// The library of its scene light, as `flb bake-scene` makes it but for the codec.
    pub fn library(&self, lattice: u32, suns: &SunBasis) -> Library {
        let plants = self.plants();
        let scenery =
            Scenery::new(&plants, &self.instances, self.ground.as_ref(), lattice).expect("a good scene");
        let mut entries = Vec::new();
        let mut solve = |role: Role,
                         turbid: &TurbidMedium,
                         is_ground: &[bool],
                         surfaces: &BandSurfaces,
                         surroundings| {
            let settings = OrdinatesSettings {
                ordinates: Ordinates::Lebedev50,
                rays: ordinates::rays_for(turbid.grid.lattice, 1),
                suns: suns.clone(),
                ..OrdinatesSettings::default()
            };
            let solution =
                ordinates::solve_among(turbid, &[scatter(surfaces)], surroundings, &settings, &|_| Ok(()))
                    .expect("a good medium");
            let Entry { meta, medium } =
                entry(&role, turbid, is_ground, surfaces.clone(), light(&settings), []);
            let fields = SpeciesFields { meta, medium, turbid: Some(turbid.clone()), bases: solution.fields };
            entries.push(fields);
        };
        let mut factors = Vec::new();
        for (index, kind) in self.kinds.iter().enumerate() {
            let crown = scenery.as_open(index, scenery.coarse(index).expect("a plant that is not too large"));
            let role = Role::Alone { species: kind.name.clone() };
            solve(role, &crown.turbid, &[], &kind.surfaces, &ordinates::Surroundings::NONE);
            factors.push(crown.factor);
        }
        let surfaces: Vec<BandSurfaces> = self.kinds.iter().map(|kind| kind.surfaces.clone()).collect();
        let stand = scenery.stand(&factors, &surfaces);
        let role = Role::Scene { digest: "a stand of the tests".to_owned() };
        solve(role, &stand.turbid, &stand.is_ground, &stand.surfaces, &stand.surroundings());
        in_memory(&entries)
    }

    /// Names of its kinds.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.kinds.iter().map(|kind| kind.name.as_str())
    }

    /// What others do at points of instances, under a sun.
    ///
    /// # Errors
    /// As of [`flb_runtime::scene_light::PreparedSceneLight::at_sun`].
    pub fn modulations(
        &self,
        library: &Library,
        sun: [f64; 3],
        points: &[(u32, [f32; 3])],
    ) -> Result<Vec<Modulations>, RuntimeError> {
        self.modulations_by(library, SceneFactor::Alone, sun, points)
    }

    /// What others do at points of instances, under a sun, by what the scene's light is compared with.
    ///
    /// # Errors
    /// As [`Stand::modulations`], and of [`SceneLight::compared_with`].
    pub fn modulations_by(
        &self,
        library: &Library,
        factor: SceneFactor,
        sun: [f64; 3],
        points: &[(u32, [f32; 3])],
    ) -> Result<Vec<Modulations>, RuntimeError> {
        let light = SceneLight::load(library)?.compared_with(factor)?;
        let prepared = light.prepare(self.names());
        let shade = prepared.at_sun(Some(sun), &self.instances)?;
        Ok(points.iter().map(|&(instance, point)| shade.at(instance, point)).collect())
    }

    /// All plants on one lattice of sites as fine as their own, and where each site of an instance is.
    pub fn merged(&self, lattice: u32) -> (TurbidMedium, Vec<ComparedPoint>) {
        let spacing_m = self.kinds[0].turbid.grid.spacing_m;
        let first = self.kinds[0].turbid.grid.middle_m([0; 3]);
        let mut places = Vec::new();
        for (instance, one) in (0u32..).zip(&self.instances) {
            let turbid = &self.kinds[one.species].turbid;
            for site in turbid.sites() {
                let point_m = turbid.grid.middle_m(turbid.grid.site(site as usize));
                let world = one.transform.world_from_model_point(point_m);
                let at = [0, 1, 2].map(|axis| {
                    let steps = (world[axis] - first[axis]) / spacing_m;
                    assert!((steps - steps.round()).abs() < 1e-6, "sites in step");
                    steps.round() as i64
                });
                places.push((instance, site, point_m, at));
            }
        }
        let lowest = |axis: usize| places.iter().map(|place| place.3[axis]).min().unwrap_or(0);
        let low = [0, 1, 2].map(lowest);
        let origin_m = std::array::from_fn(|axis| first[axis] + (low[axis] as f64 - 2.5) * spacing_m);
        let grid = Grid { lattice, origin_m, spacing_m };
        let mut merged = TurbidMedium {
            grid,
            leaf_per_m: vec![0.0; grid.sites()],
            wood_per_m: vec![0.0; grid.sites()],
            angles: self.kinds[0].turbid.angles.clone(),
        };
        let place = |(instance, own, point_m, at): (u32, u32, [f64; 3], [i64; 3])| {
            let [x, y, z] = [0, 1, 2].map(|axis| (at[axis] - low[axis] + 2) as u32);
            assert!([x, y, z].iter().all(|c| *c < lattice - 2), "the stand is larger than the lattice");
            let all = grid.index(x, y, z);
            let turbid = &self.kinds[self.instances[instance as usize].species].turbid;
            merged.leaf_per_m[all] += turbid.leaf_per_m[own as usize];
            merged.wood_per_m[all] += turbid.wood_per_m[own as usize];
            ComparedPoint { instance, own, all: all as u32, point_m: point_m.map(|c| c as f32) }
        };
        let places = places.into_iter().map(place).collect();
        (merged, places)
    }
}

/// A library of entries, uncoded.
fn in_memory<'f>(entries: impl IntoIterator<Item = &'f SpeciesFields>) -> Library {
    let coding = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
    let encode = |fields| encode_species(fields, &coding, &|_| Ok(())).expect("fields of a solve");
    let coded: Vec<_> = entries.into_iter().map(encode).collect();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &coded.iter().collect::<Vec<_>>()).expect("memory takes it");
    Library::from_source("stand.flb", Box::new(bytes)).expect("it opens")
}

/// A site of an instance.
#[derive(Debug, Clone, Copy)]
pub struct ComparedPoint {
    /// Whose.
    pub instance: u32,
    /// In the lattice of its species.
    pub own: u32,
    /// In the lattice of all.
    pub all: u32,
    /// Its middle, model space.
    pub point_m: [f32; 3],
}

/// Light at a site, in luminance: of a sun of fluence 1 (scattered), and of a sky of fluence 1 (all).
pub type SunAndSky = [f32; 2];

/// Light at every site of a lattice under one sun, without any blending of suns.
pub fn light_at_sites(turbid: &TurbidMedium, surfaces: &BandSurfaces, sun: [f64; 3]) -> Vec<SunAndSky> {
    let settings = OrdinatesSettings {
        ordinates: Ordinates::Lebedev110,
        rays: ordinates::rays_for(turbid.grid.lattice, 1),
        suns: SunBasis::Directions(Arc::new(tetrahedron(sun))),
        ..OrdinatesSettings::default()
    };
    let solution =
        ordinates::solve(turbid, &[scatter(surfaces)], &settings, &|_| Ok(())).expect("a good medium");
    let [sky, of_sun] = [0, 1].map(|item: usize| solution.fields[item].1.values());
    of_sun.iter().zip(sky.iter()).map(|(sun, sky)| [*sun, *sky]).collect()
}

/// Four suns, the first of which is this one.
fn tetrahedron(sun: [f64; 3]) -> SunDirections {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let unit = |v: [f64; 3]| {
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    };
    let sun = unit(sun);
    let aside = unit(cross(sun, if sun[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] }));
    let other = cross(sun, aside);
    let corner = |cos: f64, sin: f64| {
        std::array::from_fn(|axis| {
            -sun[axis] / 3.0 + (8.0_f64 / 9.0).sqrt() * (cos * aside[axis] + sin * other[axis])
        })
    };
    let half = 0.75_f64.sqrt();
    let corners = vec![sun, corner(1.0, 0.0), corner(-0.5, half), corner(-0.5, -half)];
    SunDirections::new(corners, vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).expect("a tetrahedron")
}

/// A site's light by both ways.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// By the lattice of all.
    pub truth: SunAndSky,
    /// Of the plant alone.
    pub own: SunAndSky,
    /// The plant's own with what others do.
    pub whole: SunAndSky,
    /// Area that the site stands for, in any unit.
    pub weight: f32,
    /// Whose.
    pub instance: u32,
}

/// The light of a stand by both ways. `truth` is that of its merged lattice.
pub fn pairs(
    stand: &Stand,
    (places, truth): (&[ComparedPoint], &[SunAndSky]),
    library: (&Library, SceneFactor),
    sun: [f64; 3],
) -> Vec<Pair> {
    let of_instance = |one: &Placement| {
        let towards = one.transform.model_from_world_direction(sun);
        let kind = &stand.kinds[one.species];
        kind.light_at_sites(&kind.turbid, towards)
    };
    let alone: Vec<Vec<SunAndSky>> = stand.instances.iter().map(of_instance).collect();
    let points: Vec<(u32, [f32; 3])> = places.iter().map(|place| (place.instance, place.point_m)).collect();
    let (library, factor) = library;
    let modulations = stand.modulations_by(library, factor, sun, &points).expect("a sun");
    places
        .iter()
        .zip(modulations)
        .map(|(place, modulation)| {
            let own = alone[place.instance as usize][place.own as usize];
            let whole = [
                own[0] * modulation.sun.scale + modulation.sun.add,
                own[1] * modulation.sky.scale + modulation.sky.add,
            ];
            let species = stand.instances[place.instance as usize].species;
            let weight = stand.kinds[species].turbid.extinction(place.own as usize);
            Pair { truth: truth[place.all as usize], own, whole, weight, instance: place.instance }
        })
        .collect()
}

/// Root mean square error and mean error over matter, both of the mean of the truth.
pub fn error(pairs: &[Pair], truth: impl Fn(&Pair) -> f32, found: impl Fn(&Pair) -> f32) -> [f64; 2] {
    let (mut square, mut off, mut sum, mut weights) = (0.0, 0.0, 0.0, 0.0);
    for pair in pairs {
        let (weight, truth) = (f64::from(pair.weight), f64::from(truth(pair)));
        let difference = f64::from(found(pair)) - truth;
        square += weight * difference * difference;
        off += weight * difference;
        sum += weight * truth;
        weights += weight;
    }
    [(square / weights).sqrt() / (sum / weights), off / sum]
}

/// Sun and sky together, as a picture has them.
pub fn day([sun, sky]: SunAndSky) -> f32 {
    sun + SKY * sky
}

fn light(settings: &OrdinatesSettings) -> Light {
    Light {
        field: settings.field,
        ordinates: settings.ordinates.count(),
        rays: settings.rays,
        suns: settings.suns.clone(),
        leaf_angles: flb_format::matter::LeafAngles::spherical(),
        error: LightError { suns_rms: 0.0, held_out: 0, solver: 0.0, monte_carlo: None },
        solid_offset: None,
    }
}
