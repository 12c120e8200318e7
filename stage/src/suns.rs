//! Suns of plants that many rays meet, prepared beforehand: their light is then that of a picture of one plant, without
//! grain. Others march, which costs less for few points.

use std::collections::BTreeMap;

use flb_format::Placement;
use flb_format::beam::{Near, single};
use flb_render::Lighting;
use flb_render::forest::Fragments;
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::{InstanceLight, RuntimeError, SpeciesLight};
use rayon::prelude::*;

use crate::light::{Skies, of_plants};

/// Nanoseconds of a march from a point along the sun, and of a site: of the sums that all suns share, and of a sun.
/// Only their ratios count.
struct Costs {
    march: u64,
    sums: u64,
    sun: u64,
}

impl Costs {
    /// By the rays that cross an edge of a site: one of large lattices (`cargo bench -p flb-tests --bench rings -- oak
    /// 80000 128`), two of others (`-- oak 80000 64`).
    fn of(species: &SpeciesLight<'_>) -> Costs {
        match single::rays(species.grid().lattice) {
            1 => Costs { march: 8_000, sums: 5_300, sun: 750 },
            _ => Costs { march: 6_000, sums: 15_000, sun: 2_000 },
        }
    }
}

/// Most suns of a species, and most memory of all suns of a picture, of 16 bytes a site each.
const MAX_SUNS: usize = 32;
const MAX_BYTES: usize = 512 << 20;
const SITE_BYTES: usize = 16;
/// By how much sums must pay: one thread makes those of a species, where all of them march.
const GAIN: u64 = 2;

/// Plants that see one sun, in the frame of their model.
#[derive(Default)]
struct Alike {
    plants: Vec<usize>,
    /// Rays that meet them.
    points: u64,
}

/// A plant and its light.
type Plant<'l> = (usize, InstanceLight<'l>);

/// `[plant]`: its light by day ([`of_plants`]) in a picture of fragments.
pub(crate) fn of_picture<'l>(
    light: &'l [Option<SpeciesLight<'_>>],
    skies: Option<&'l Skies<'l>>,
    placements: &[Placement],
    lighting: &Lighting,
    shade: Option<&'l SceneLightAtSun<'l>>,
    fragments: &Fragments,
) -> Result<Vec<Option<InstanceLight<'l>>>, RuntimeError> {
    let lit = of_plants(light, skies, placements, lighting, shade, fragments.view().samples)?;
    Ok(prepare(light, placements, lit, &fragments.on_plants(placements.len())))
}

/// Prepares suns where that costs less than the marches of a picture, of whose rays `points[plant]` meet each plant.
fn prepare<'l>(
    light: &'l [Option<SpeciesLight<'_>>],
    placements: &[Placement],
    mut lit: Vec<Option<InstanceLight<'l>>>,
    points: &[u32],
) -> Vec<Option<InstanceLight<'l>>> {
    // Of a million plants few are seen.
    let mut seen: Vec<Vec<usize>> = light.iter().map(|_| Vec::new()).collect();
    for (plant, one) in placements.iter().enumerate().filter(|(plant, _)| points[*plant] > 0) {
        seen[one.species].push(plant);
    }
    let mut left = MAX_BYTES;
    let mut taken: Vec<(&SpeciesLight<'_>, Vec<Vec<Plant<'l>>>)> = Vec::new();
    for (species, plants) in light.iter().zip(seen) {
        let Some(species) = species else { continue };
        let chosen = choose(species, &plants, &lit, points, &mut left);
        if !chosen.is_empty() {
            let mut take = |plant: usize| Some((plant, lit[plant].take()?));
            let suns = chosen.into_iter().map(|sun| sun.plants.into_iter().filter_map(&mut take).collect());
            taken.push((species, suns.collect()));
        }
    }
    let prepared: Vec<Vec<Vec<Plant<'l>>>> = taken
        .into_par_iter()
        .map(|(species, suns)| {
            let near = species.near();
            suns.into_par_iter().map(|alike| one_sun(alike, near.as_ref())).collect()
        })
        .collect();
    for (plant, one) in prepared.into_iter().flatten().flatten() {
        lit[plant] = Some(one);
    }
    lit
}

/// Suns of a species that are worth it, those that most rays meet first; none where sums of all suns are not. Takes
/// their memory from what is left.
fn choose(
    species: &SpeciesLight<'_>,
    plants: &[usize],
    lit: &[Option<InstanceLight<'_>>],
    points: &[u32],
    left: &mut usize,
) -> Vec<Alike> {
    let mut suns = BTreeMap::<[u64; 3], Alike>::new();
    let mut looks = 0;
    for &plant in plants {
        let Some((sun, offsets)) = lit[plant].as_ref().and_then(InstanceLight::marches) else { continue };
        let alike = suns.entry(sun.map(f64::to_bits)).or_default();
        alike.plants.push(plant);
        alike.points += u64::from(points[plant]);
        looks = offsets as u64;
    }
    let (sites, costs) = (species.near_sites(), Costs::of(species));
    let of_sites = |cost: u64| sites as u64 * cost;
    let gain = |alike: &Alike| (alike.points * looks * costs.march).saturating_sub(of_sites(costs.sun));
    let mut chosen: Vec<Alike> = suns.into_values().filter(|alike| gain(alike) > 0).collect();
    chosen.sort_by_key(|alike| std::cmp::Reverse(alike.points));
    chosen.truncate(MAX_SUNS.min(*left / (sites * SITE_BYTES).max(1)));
    if chosen.iter().map(gain).sum::<u64>() <= GAIN * of_sites(costs.sums) {
        return Vec::new();
    }
    *left -= chosen.len() * sites * SITE_BYTES;
    chosen
}

/// Plants that see one sun, which is prepared once.
fn one_sun<'l>(alike: Vec<Plant<'l>>, near: Option<&Near<'_>>) -> Vec<Plant<'l>> {
    let mut found = None;
    let prepare = |(plant, lit): Plant<'l>| {
        let lit = match &found {
            Some(found) => lit.prepared_as(found),
            None => lit.prepared_by(near),
        };
        found = lit.prepared_sun().cloned();
        (plant, lit)
    };
    alike.into_iter().map(prepare).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use flb_format::Transform;
    use flb_format::light::SunBasis;

    use super::*;
    use crate::tests::{SUN_DEG, stand_of};

    #[test]
    fn plants_that_many_rays_meet_have_the_light_of_a_plant_alone_and_others_march() {
        let stage = stand_of(&SunBasis::Harmonics { degree: 2, single: true, leaning: true });
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
        // Sums pay by some rays a site.
        let many = 6 * sites;
        assert!(sites > 0 && marched.iter().flatten().all(|one| one.marches().is_some()));
        let of = |points: [u32; 4]| prepare(&light, &placements, lit(), &points);
        let marching = |lit: &[Option<InstanceLight>]| -> Vec<bool> {
            lit.iter().flatten().map(|one| one.marches().is_some()).collect()
        };
        assert_eq!(marching(&of([1; 4])), [true; 4]);
        assert_eq!(marching(&of([many, 0, 0, 0])), [false, true, true, true]);
        let some = of([many, 1, 1, 1]);
        assert_eq!(marching(&some), [false, false, true, true]);
        let [Some(first), Some(second)] = &some[..2] else { panic!("they have light") };
        assert!(Arc::ptr_eq(first.prepared_sun().expect("a sun"), second.prepared_sun().expect("a sun")));
        assert_eq!(marching(&of([many; 4])), [false; 4]);
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
        assert_eq!(marching(&prepare(&light, &placements, night, &[many; 4])), [false; 4]);
    }
}
