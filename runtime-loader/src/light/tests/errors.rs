//! What is refused, and by which words.

use super::*;

fn left_out() -> SpeciesFields {
    let mut fields = plant("oak", Some(&SunBasis::Lattice18), LATTICE, 3);
    fields.bases.retain(|(base, _)| ![0, 4].contains(base));
    let reason = "a test".to_owned();
    fields.meta.left_out = Some(LeftOut { bases: [0].into_iter().collect(), bands: vec![], reason });
    fields
}

fn refusal<T>(outcome: Result<T, RuntimeError>) -> RuntimeError {
    outcome.map(|_| ()).expect_err("it is refused")
}

#[test]
fn a_sun_without_a_direction_is_refused_unless_it_is_night() {
    for suns in kinds() {
        let library = library(&plant("oak", suns.as_ref(), LATTICE, 3), Codec::Classed);
        let resident = resident(&library);
        for species in
            [SpeciesLight::load(&library, 0).expect("it loads"), SpeciesLight::streamed(resident.species(0))]
        {
            for towards_sun in [[0.0; 3], [f64::NAN, 1.0, 0.0], [0.0, f64::INFINITY, 0.0]] {
                let day = Daylight { towards_sun, ..days()[0] };
                let error = refusal(species.lit_by(&day, &Transform::IDENTITY));
                assert!(matches!(error, RuntimeError::NoDirection { .. }), "{suns:?}: {error}");
                species
                    .lit_by(&Daylight { sun: 0.0, ..day }, &Transform::IDENTITY)
                    .expect("by night there is none");
            }
        }
    }
    let library = library(&plant("oak", None, LATTICE, 3), Codec::Classed);
    let error = refusal(SpeciesLight::load_for(&library, 0, [[0.0; 3]], true));
    assert!(error.to_string().starts_with("the direction towards the sun is [0.0, 0.0, 0.0]"), "{error}");
}

#[test]
fn a_light_that_is_no_number_is_refused() {
    let library = library(&plant("oak", None, LATTICE, 3), Codec::Classed);
    let species = SpeciesLight::load(&library, 0).expect("it loads");
    let refused = |daylight: Daylight| refusal(species.lit_by_in_model(&daylight)).to_string();
    let day = days()[0];
    assert_eq!(
        refused(Daylight { sun: f32::NAN, ..day }),
        "the light of the sun is NaN, expected a finite number"
    );
    assert_eq!(
        refused(Daylight { sky: f32::INFINITY, ..day }),
        "the light of the sky is inf, expected a finite number"
    );
}

#[test]
fn a_base_that_is_missing_is_refused_once_and_by_its_reason() {
    let library = library(&left_out(), Codec::Classed);
    let species = SpeciesLight::load(&library, 0).expect("it loads");
    assert!(!species.has_sky());
    let day = Daylight { towards_sun: [0.3, -1.0, 0.1], ..days()[0] };
    let error = refusal(species.lit_by_in_model(&day)).to_string();
    assert_eq!(
        error,
        "plants.flb: species \"oak\" has no base 0, which the light needs: it was left out (a test)"
    );
    species.lit_by_in_model(&Daylight { sky: 0.0, ..day }).expect("the others are there");
    let above = Daylight { towards_sun: [0.0, 1.0, 0.0], sky: 0.0, ..day };
    let error = refusal(species.lit_by_in_model(&above));
    assert!(matches!(error, RuntimeError::MissingBase { base: 4, .. }), "{error}");
}

#[test]
fn a_base_that_was_not_loaded_is_told_from_one_that_is_missing() {
    let library = library(&plant("oak", None, LATTICE, 3), Codec::Classed);
    let species = SpeciesLight::load_for(&library, 0, [[0.0, 1.0, 0.0]], false).expect("it loads");
    let below = Daylight { towards_sun: [0.0, -1.0, 0.0], sun: 1.0, sky: 0.0 };
    let error = refusal(species.lit_by_in_model(&below)).to_string();
    let expected =
        "plants.flb: base 3 of species \"oak\" was not loaded: the light was loaded for other suns";
    assert_eq!(error, expected);
    let sky = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 1.0, sky: 0.1 };
    let error = refusal(species.lit_by_in_model(&sky));
    assert!(matches!(error, RuntimeError::NotLoaded { base: 0, .. }), "{error}");
}

#[test]
fn other_numbers_of_bands_than_a_picture_has_are_refused() {
    let library = plants::library(&[coarse(&alone(), 0.5)], Codec::RawF32);
    let species = SpeciesLight::load(&library, 0).expect("it loads");
    assert_eq!(species.bands(), 1);
    species.check_bands(1).expect("it has one");
    let error = refusal(species.check_bands(3)).to_string();
    assert_eq!(error, "the light has 1 bands, expected 3");
    let placed = [Placement { species: 0, transform: Transform::IDENTITY }];
    let scene_light = scene_light(0.2);
    let prepared = scene_light.prepare(["oak"]);
    let shade = shade(&prepared, &placed);
    let lit = species.lit_by_in_model(&days()[0]).expect("a sun");
    let error = refusal(lit.with_neighbours(&shade, 0));
    assert!(matches!(error, RuntimeError::Bands { found: 1, expected: 3 }), "{error}");
}

#[test]
fn a_species_that_is_not_there_is_refused() {
    let library = library(&plant("oak", None, LATTICE, 3), Codec::Classed);
    for error in
        [refusal(SpeciesLight::load(&library, 1)), refusal(SpeciesLight::load_for(&library, 1, [], true))]
    {
        assert_eq!(error.to_string(), "plants.flb: asked for species 1, the library holds 1");
    }
}
