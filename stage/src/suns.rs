//! Suns of plants that many rays meet, prepared beforehand: their light is then that of a picture of one plant, without
//! grain. Others march, which costs less for few points.

use std::collections::BTreeMap;

use flb_format::Placement;
use flb_runtime::{InstanceLight, SpeciesLight};
use rayon::prelude::*;

/// Nanoseconds of a march from a point along the sun, and of a site: of the sums that all suns share, and of a sun.
/// Only their ratios count (`cargo bench -p flb-tests --bench rings -- oak 80000 128`).
const MARCH: u64 = 8_000;
const SUMS: u64 = 5_300;
const SUN: u64 = 750;
/// Most suns of a species, each with 16 bytes a site.
const MAX_SUNS: usize = 32;

/// Plants that see one sun, in the frame of their model.
#[derive(Default)]
struct Alike {
    plants: Vec<usize>,
    /// Rays that meet them.
    points: u64,
}

/// Prepares suns where that costs less than the marches of a picture of so many rays a pixel, of which `points[plant]`
/// meet each plant.
pub(crate) fn prepare<'l>(
    light: &'l [Option<SpeciesLight<'_>>],
    placements: &[Placement],
    mut lit: Vec<Option<InstanceLight<'l>>>,
    points: &[u32],
) -> Vec<Option<InstanceLight<'l>>> {
    for (number, species) in light.iter().enumerate() {
        let Some(species) = species else { continue };
        let mut suns = BTreeMap::<[u64; 3], Alike>::new();
        let mut looks = 0;
        // Of a million plants few are seen.
        let seen = |(plant, one): &(usize, &Placement)| one.species == number && points[*plant] > 0;
        for (plant, _) in placements.iter().enumerate().filter(seen) {
            let Some((sun, offsets)) = lit[plant].as_ref().and_then(InstanceLight::marches) else { continue };
            let alike = suns.entry(sun.map(f64::to_bits)).or_default();
            alike.plants.push(plant);
            alike.points += u64::from(points[plant]);
            looks = offsets as u64;
        }
        let worth = |alike: &Alike| alike.points * looks * MARCH;
        let mut chosen: Vec<Alike> = suns.into_values().collect();
        chosen.sort_by_key(|alike| std::cmp::Reverse(alike.points));
        chosen.truncate(MAX_SUNS);
        let of_sites = |cost: u64| species.near_sites() as u64 * cost;
        chosen.retain(|alike| worth(alike) > of_sites(SUN));
        let gain: u64 = chosen.iter().map(|alike| worth(alike) - of_sites(SUN)).sum();
        if gain <= of_sites(SUMS) {
            continue;
        }
        let near = species.near();
        let taken: Vec<Vec<(usize, InstanceLight)>> = chosen
            .iter()
            .map(|alike| {
                alike.plants.iter().filter_map(|plant| Some((*plant, lit[*plant].take()?))).collect()
            })
            .collect();
        let prepared: Vec<Vec<(usize, InstanceLight)>> = taken
            .into_par_iter()
            .map(|alike| {
                let mut found = None;
                let prepare = |(plant, lit): (usize, InstanceLight<'l>)| {
                    let lit = match &found {
                        Some(found) => lit.prepared_as(found),
                        None => lit.prepared_by(near.as_ref()),
                    };
                    found = lit.prepared_sun().cloned();
                    (plant, lit)
                };
                alike.into_iter().map(prepare).collect()
            })
            .collect();
        for (plant, one) in prepared.into_iter().flatten() {
            lit[plant] = Some(one);
        }
    }
    lit
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use flb_format::Transform;
    use flb_format::light::SunBasis;
    use flb_render::Lighting;

    use super::*;
    use crate::light::of_plants;
    use crate::tests::{SUN_DEG, stand_of};

    #[test]
    fn plants_that_many_rays_meet_have_the_light_of_a_plant_alone_and_others_march() {
        let stage = stand_of(&SunBasis::Harmonics { degree: 2, single: true });
        let load = |plant: &crate::plant::ScenePlant| {
            plant
                .library()
                .map(|(library, species)| SpeciesLight::load(library, species).expect("a sound file"))
        };
        let light: Vec<Option<SpeciesLight>> = stage.plants.iter().map(load).collect();
        let mut lighting = Lighting::default();
        lighting.daylight.towards_sun = flb_format::sun::towards_sun(SUN_DEG[0], SUN_DEG[1]);
        let stands =
            |species, yaw_deg| Placement { species, transform: Transform::from_yaw([0.0; 3], yaw_deg, 1.0) };
        // Two alike, one of another yaw that few rays meet, one of the other species.
        let placements = [stands(0, 40.0), stands(0, 40.0), stands(0, 70.0), stands(1, 0.0)];
        let lit = || of_plants(&light, None, &placements, &lighting, None, 1).expect("a sun");
        let marched = lit();
        let sites = light.iter().flatten().map(SpeciesLight::near_sites).max().expect("two species") as u32;
        assert!(sites > 0 && marched.iter().flatten().all(|one| one.marches().is_some()));
        let of = |points: [u32; 4]| prepare(&light, &placements, lit(), &points);
        let marching = |lit: &[Option<InstanceLight>]| -> Vec<bool> {
            lit.iter().flatten().map(|one| one.marches().is_some()).collect()
        };
        assert_eq!(marching(&of([1; 4])), [true; 4]);
        assert_eq!(marching(&of([sites, 0, 0, 0])), [false, true, true, true]);
        let some = of([sites, 1, 1, 1]);
        assert_eq!(marching(&some), [false, false, true, true]);
        let [Some(first), Some(second)] = &some[..2] else { panic!("they have light") };
        assert!(Arc::ptr_eq(first.prepared_sun().expect("a sun"), second.prepared_sun().expect("a sun")));
        assert_eq!(marching(&of([sites; 4])), [false; 4]);
        let alone = light[0].as_ref().expect("light").lit_by(&lighting.daylight, &placements[0].transform);
        let alone = alone.expect("a sun").prepared();
        for number in 0..50_u8 {
            let point = [0.02 * f32::from(number), 1.0 + 0.03 * f32::from(number), -0.1];
            let [mut found, mut expected] = [[0.0; 3]; 2];
            second.at(point, &mut found);
            alone.at(point, &mut expected);
            assert_eq!(found, expected);
        }
        lighting.daylight.sun = 0.0;
        let night = of_plants(&light, None, &placements, &lighting, None, 1).expect("no sun");
        assert_eq!(marching(&prepare(&light, &placements, night, &[sites; 4])), [false; 4]);
    }
}
