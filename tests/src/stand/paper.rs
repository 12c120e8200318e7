//! Stands of plants of the model `paper`.

use flb_baker::bake::{
    BakeSettings, ModelSettings, NoStore, PaperSettings, PlantedScene, ScenePlant, SceneSettings, bake,
    bake_scene,
};
use flb_baker::scene_light::{coarse_medium, extinction, optics_in_luminance};
use flb_fixtures::PlantKind;
use flb_format::direction::MOVING;
use flb_format::matter::{Optics, TurbidMedium};
use flb_format::sun;
use flb_runtime::Library;
use flb_scene::Unobserved;
use flb_transport::lattice::{SolveSettings, solve};

use super::{Kind, Stand, SunAndSky, in_memory};
use crate::default_bake::grown;

/// Light of the ambient base where nothing stands.
const OPEN_SKY: f32 = MOVING as f32;

impl Kind {
    /// A built-in plant on a lattice, with the papers' optics.
    pub fn grown_of_paper(kind: PlantKind, triangles: u32, lattice: u32) -> Kind {
        // Its own light is not looked at here.
        let model = ModelSettings::Paper(PaperSettings { max_sweeps: 1, ..PaperSettings::default() });
        let settings = BakeSettings { lattice, voxels: 8 * lattice, model, ..BakeSettings::default() };
        let baked = bake(grown(kind, triangles), &settings, &NoStore, &Unobserved).expect("a good plant");
        let optics = baked.fields.meta.optics().expect("the model paper").clone();
        let turbid = extinction(&baked.fields.medium);
        Kind { name: baked.fields.meta.name.clone(), optics: Some(optics), ..Kind::of_turbid(turbid) }
    }
}

impl Stand {
    /// The library of its scene light, of plants of the model `paper`, as `flb bake-scene` makes it but for the codec.
    ///
    /// # Panics
    /// If a plant is of the other model.
    pub fn paper_library(&self, lattice: u32) -> Library {
        let plant = |kind: &Kind| {
            let optics = kind.optics.as_ref().expect("the model paper");
            ScenePlant::of_paper(&kind.name, &coarse_medium(&kind.turbid), optics).expect("three bands")
        };
        let scene = PlantedScene {
            plants: self.kinds.iter().map(plant).collect(),
            instances: self.instances.clone(),
            ground: None,
            digest: "a stand of the tests".to_owned(),
        };
        let settings = SceneSettings { lattice, ..SceneSettings::default() };
        let baked = bake_scene(&scene, &settings, &NoStore, &Unobserved).expect("a good scene");
        in_memory(baked.entries())
    }
}

/// Light at every site of the lattice whose densities stop what the extinction does, under one sun: the papers' blend
/// of three bases.
pub(super) fn light_at_sites(
    name: &str,
    turbid: &TurbidMedium,
    optics: &Optics,
    sun: [f64; 3],
) -> Vec<SunAndSky> {
    let bands = Optics { bands: vec![optics_in_luminance(name, optics).expect("three bands")] };
    let solution =
        solve(&coarse_medium(turbid), &bands, &SolveSettings::default(), &|_| Ok(())).expect("a good medium");
    let blend = sun::blend(sun).expect("a direction");
    let base = |item: u8| {
        let (_, field) = solution.bases.iter().find(|(base, _)| *base == item).expect("all are solved");
        field.values()
    };
    let (sky, suns) = (base(0), blend.bases.map(base));
    let of_sun = |site: usize| (0..3).map(|k| blend.weights[k] * suns[k][site]).sum::<f32>();
    (0..turbid.grid.sites()).map(|site| [of_sun(site), sky[site] / OPEN_SKY]).collect()
}
