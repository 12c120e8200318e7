//! What a library must hold to be scene light, and the rules by which two lights become one. Laws of the light itself
//! are tested with all rooms together (`tests/tests/it/scene_light.rs`).

use flb_format::light::SunBasis;
use flb_format::model::Model;
use flb_format::scene_light::{LUMINANCE, Role};
use flb_format::{Codec, Field, Placement, SpeciesFields, Transform};

use super::*;
use crate::plants;

/// A plant in a role, all of whose light in the luminance band is `light`.
pub(crate) fn coarse(role: &Role, light: f32) -> SpeciesFields {
    let mut fields = plants::plant(&role.name(), Some(&SunBasis::Lattice18), 16, 1);
    let (key, value) = role.setting();
    fields.meta.settings.insert(key, value);
    if let Model::Physical { surfaces, .. } = &mut fields.meta.model {
        surfaces.bands.truncate(1);
        surfaces.bands[0].name = LUMINANCE.to_owned();
    }
    let lattice = fields.meta.grid.lattice;
    let field = Field::new(lattice, 1, vec![light; fields.meta.grid.sites()]);
    fields.bases.iter_mut().for_each(|(_, base)| *base = field.clone());
    fields
}

pub(crate) fn scene() -> Role {
    Role::Scene { digest: "d1".to_owned() }
}

pub(crate) fn alone() -> Role {
    Role::Alone { species: "oak".to_owned() }
}

/// A plant at home.
const HOME: Placement = Placement { species: 0, transform: Transform::IDENTITY };

fn load(fields: &[SpeciesFields]) -> Result<SceneLight, RuntimeError> {
    SceneLight::load(&plants::library(fields, Codec::RawF32))
}

#[test]
fn a_library_of_anything_else_is_refused_by_what_it_lacks() {
    let refused = |fields: &[SpeciesFields], found: &str| {
        let message = load(fields).map(|_| ()).unwrap_err().to_string();
        assert_eq!(
            message,
            format!("plants.flb: found {found}, expected the light of a scene (`flb bake-scene`)")
        );
    };
    let ordinary = plants::plant("oak", Some(&SunBasis::Lattice18), 16, 1);
    refused(std::slice::from_ref(&ordinary), "species \"oak\", which is an ordinary one");
    refused(&[coarse(&alone(), 1.0), ordinary.clone()], "species \"oak\", which is an ordinary one");
    refused(&[coarse(&alone(), 1.0)], "no entry of a scene");
    let mut colored = ordinary;
    colored.meta.settings.extend([scene().setting()]);
    refused(&[colored], "species \"oak\" of 3 bands, which has to have one");
    let mut dark = coarse(&scene(), 1.0);
    dark.bases.retain(|(base, _)| *base != 0);
    refused(&[dark], "species \"scene\" without base 0, the sky's");
}

#[test]
fn neighbours_that_take_light_leave_a_share_and_those_that_bring_some_add_it() {
    let modulation = |of_scene: f32, of_alone: f32| {
        let light = load(&[coarse(&alone(), of_alone), coarse(&scene(), of_scene)]).expect("scene light");
        assert_eq!(
            (light.digest(), light.find_species("oak"), light.find_species("ash")),
            ("d1", Some(0), None)
        );
        assert!(light.size_bytes() > 0);
        let (prepared, placed) = (light.prepare(["oak", "ash"]), [HOME, Placement { species: 1, ..HOME }]);
        let shade = prepared.at_sun(Some([0.3, 0.8, 0.1]), &placed).expect("a sun");
        assert_eq!(shade.at(1, [0.0, 2.0, 0.0]), Modulations::UNCHANGED);
        let at = shade.at(0, [0.0, 2.0, 0.0]);
        // Three bases of a third each are not the sky's one to the last bit.
        let off = [at.sun.scale - at.sky.scale, at.sun.add - at.sky.add];
        assert!(off.iter().all(|off| off.abs() < 1e-6), "{at:?}");
        // No plant is out there.
        assert_eq!(shade.at(0, [90.0, 2.0, 0.0]), Modulations::UNCHANGED);
        let night = prepared.at_sun(None, &placed).expect("no sun");
        assert_eq!(
            (night.at(0, [0.0, 2.0, 0.0]).sun, night.at(0, [0.0, 2.0, 0.0]).sky),
            (Modulation::UNCHANGED, at.sky)
        );
        at.sun
    };
    let near = |share: Modulation, scale: f32, add: f32| {
        assert!((share.scale - scale).abs() < 0.02 && (share.add - add).abs() < 1e-6, "{share:?}");
    };
    near(modulation(0.5, 0.5), 1.0, 0.0);
    near(modulation(0.2, 0.5), 0.4, 0.0);
    near(modulation(0.8, 0.5), 1.0, 0.3);
    near(modulation(0.0, 0.5), 0.0, 0.0);
    near(modulation(0.3, 0.0), 1.0, 0.3);
}

#[test]
fn compared_with_an_empty_scene_the_scene_s_light_is_the_factor_whatever_a_plant_has_alone() {
    let light = load(&[coarse(&alone(), 0.5), coarse(&scene(), 0.3)]).expect("scene light");
    // What is scattered at single suns has no beam, of which an empty scene's light is made.
    let error = light.compared_with(SceneFactor::Empty).map(|_| ()).unwrap_err().to_string();
    assert!(error.starts_with("fields of light scattered at single suns lack the sun's own beam"), "{error}");
    let with_beam = |role: &Role, light: f32| {
        let mut fields = coarse(role, light);
        if let Model::Physical { light, .. } = &mut fields.meta.model {
            light.field = FieldKind::Total;
        }
        fields
    };
    for of_alone in [0.1, 0.9] {
        let light = load(&[with_beam(&alone(), of_alone), with_beam(&scene(), 1.3)]).expect("scene light");
        let light = light.compared_with(SceneFactor::Empty).expect("fields with the beam");
        let (prepared, placed) = (light.prepare(["oak", "ash"]), [HOME, Placement { species: 1, ..HOME }]);
        let shade = prepared.at_sun(Some([0.3, 0.8, 0.1]), &placed).expect("a sun");
        let at = shade.at(0, [0.0, 2.0, 0.0]);
        for share in [at.sun, at.sky] {
            assert!((share.scale - 1.3).abs() < 1e-6 && share.add == 0.0, "{at:?}");
        }
        for unchanged in [shade.at(1, [0.0, 2.0, 0.0]), shade.at(0, [90.0, 2.0, 0.0])] {
            assert_eq!(unchanged, Modulations::UNCHANGED);
        }
        assert_eq!(shade.flat().empty, Some([1.0; 2]));
        let night = prepared.at_sun(None, &placed).expect("no sun");
        assert_eq!(
            (night.at(0, [0.0, 2.0, 0.0]).sun, night.at(0, [0.0, 2.0, 0.0]).sky),
            (Modulation::UNCHANGED, at.sky)
        );
    }
}

#[test]
fn what_is_added_has_the_colour_of_what_is_there() {
    let added =
        Modulations { sun: Modulation { scale: 1.0, add: 0.1 }, sky: Modulation { scale: 1.0, add: 0.05 } };
    let mut phi = [0.1, 0.4, 0.05];
    added.add(2.0, 1.0, &mut phi);
    let luminance = |phi: [f32; 3]| 0.2126 * phi[0] + 0.7152 * phi[1] + 0.0722 * phi[2];
    assert!((luminance(phi) - luminance([0.1, 0.4, 0.05]) - 0.25).abs() < 1e-6, "{phi:?}");
    assert!((phi[1] / phi[0] - 4.0).abs() < 1e-5 && (phi[0] / phi[2] - 2.0).abs() < 1e-5, "{phi:?}");
    let mut dark = [0.0; 3];
    added.add(1.0, 0.0, &mut dark);
    assert_eq!(dark, [0.1; 3]);
    let mut same = [0.1, 0.4, 0.05];
    Modulations::UNCHANGED.add(1.0, 1.0, &mut same);
    assert_eq!(same, [0.1, 0.4, 0.05]);
}

#[test]
fn a_sun_that_a_library_cannot_show_is_an_error() {
    let light = load(&[coarse(&alone(), 1.0), coarse(&scene(), 1.0)]).expect("scene light");
    let prepared = light.prepare(["oak"]);
    let nowhere = prepared.at_sun(Some([0.0; 3]), &[HOME]).map(|_| ()).unwrap_err();
    assert!(nowhere.to_string().starts_with("the direction towards the sun is [0.0, 0.0, 0.0]"), "{nowhere}");
}
