//! Fragments: the same instance and triangle as the CPU finds, but for rays that graze an edge.

use flb_fixtures::PlantKind;
use flb_format::Placement;
use flb_gpu::Gpu;
use flb_render::forest::{Forest, Fragment, Ground, Search, View};
use flb_render::{Shading, Species};
use flb_scene::Mesh;
use flb_scene::mesh::sides::Side;
use flb_scene::mesh::{AlphaMode, Filter, Texture, Wrap};
use flb_testkit::scenes::{self, CLASSES, hills, plane, plant, stand, view};

use super::gpu;
use crate::{CameraHit, ForestSettings, GpuForest, LightSet, LightSource};

/// Rays that may meet something else than on the CPU: those near the edge of a triangle, of a texel of a cut or of a
/// shadow's ray.
const DIFFERENT: f64 = 5e-4;
/// Nearer to an edge than this share of a triangle, a ray may fall on either side: what f32 leaves of a place some tens
/// of metres off, over the size of a leaf's card.
const EDGE: f32 = 2e-3;
/// The same in texels of a cut, of which a card has some hundreds.
const TEXEL_EDGE: f32 = 0.3;
/// Of the distance, that places may be off by; and at least so many metres.
const DISTANCE: f64 = 2e-6;
/// Between weights of the same triangle.
const WEIGHTS: f32 = 5e-3;
/// Rays whose ground sees another sky: one of its rays grazes a leaf.
const OTHER_SKY: f64 = 0.02;

/// What came of a comparison.
#[derive(Debug, Default)]
pub(super) struct Agreement {
    rays: usize,
    plants: usize,
    grounds: usize,
    /// Of them, not the same.
    different: usize,
    /// Of these, away from any edge.
    unexplained: usize,
    other_sky: usize,
    worst_weight: f32,
    worst_distance: f64,
}

pub(super) fn dark(gpu: &Gpu, species: usize) -> LightSet {
    let sources: Vec<LightSource> = (0..species).map(|_| LightSource::Even([0.0; 3])).collect();
    LightSet::load(gpu, &sources, 1).expect("nothing is loaded")
}

fn compare(forest: &Forest, meshes: &[&Mesh], instances: &[Placement], view: &View) -> Agreement {
    compare_by(settings(), forest, meshes, instances, view)
}

pub(super) fn compare_by(
    settings: ForestSettings,
    forest: &Forest,
    meshes: &[&Mesh],
    instances: &[Placement],
    view: &View,
) -> Agreement {
    let gpu = gpu();
    let mut on_gpu = GpuForest::new(&gpu, forest, &dark(&gpu, meshes.len()), settings).unwrap();
    on_gpu.trace(view).unwrap();
    let found = on_gpu.fragments().unwrap();
    let expected = forest.trace(view, &|_| Ok(())).unwrap();
    let mut agreement = Agreement::default();
    let at_edge = |instance: u32, triangle: u32, weights: [f32; 2]| {
        let mesh = meshes[instances[instance as usize].species];
        is_at_edge(mesh, triangle, weights)
    };
    for (ray, met) in found.iter().enumerate() {
        let samples = view.samples as usize;
        let (pixel, sample) = (ray / samples, (ray % samples) as u32);
        let [x, y] = [pixel as u32 % view.width, pixel as u32 / view.width];
        let twin = expected.at(x, y, sample).expect("inside the picture");
        agreement.rays += 1;
        match (*met, twin) {
            (CameraHit::Sky, Fragment::Sky) => {}
            (
                CameraHit::Ground { distance_m, sky },
                Fragment::Ground { distance_m: of_twin, sky: sky_of_twin },
            ) => {
                agreement.grounds += 1;
                let off = (f64::from(distance_m) - of_twin).abs() / of_twin.max(1.0);
                agreement.worst_distance = agreement.worst_distance.max(off);
                agreement.other_sky += usize::from((sky - sky_of_twin).abs() > 1e-5);
            }
            (
                CameraHit::Plant { instance, triangle, weights, .. },
                Fragment::Plant { instance: of_twin, found },
            ) if instance == of_twin && triangle == found.triangle => {
                agreement.plants += 1;
                for (a, b) in weights.iter().zip(found.weights) {
                    agreement.worst_weight = agreement.worst_weight.max((a - b).abs());
                }
            }
            (met, twin) => {
                agreement.different += 1;
                let here = match met {
                    CameraHit::Plant { instance, triangle, weights, .. } => {
                        at_edge(instance, triangle, weights)
                    }
                    _ => false,
                };
                let there = match twin {
                    Fragment::Plant { instance, found } => at_edge(instance, found.triangle, found.weights),
                    _ => false,
                };
                agreement.unexplained += usize::from(!here && !there);
            }
        }
    }
    println!("{agreement:?}");
    agreement
}

fn is_at_edge(mesh: &Mesh, triangle: u32, [u, v]: [f32; 2]) -> bool {
    if u.min(v).min(1.0 - u - v) < EDGE {
        return true;
    }
    let material = &mesh.materials[mesh.triangle_material[triangle as usize] as usize];
    let (Some(texture), AlphaMode::Cut { .. }) = (material.color_texture, material.alpha_mode) else {
        return false;
    };
    let image = &mesh.images[texture.image as usize];
    let [a, b, c] = mesh.triangles[triangle as usize].map(|vertex| mesh.uvs[vertex as usize]);
    [image.width, image.height].into_iter().enumerate().any(|(axis, texels)| {
        let texel = (a[axis] * (1.0 - u - v) + b[axis] * u + c[axis] * v) * texels as f32;
        (texel - texel.round()).abs() < TEXEL_EDGE
    })
}

#[track_caller]
pub(super) fn assert_agrees(agreement: &Agreement) {
    let most = |share: f64, of: usize| (share * of as f64) as usize;
    assert!(agreement.different <= most(DIFFERENT, agreement.rays), "{agreement:?}");
    assert!(agreement.unexplained <= most(DIFFERENT / 10.0, agreement.rays), "{agreement:?}");
    assert!(agreement.other_sky <= most(OTHER_SKY, agreement.grounds), "{agreement:?}");
    assert!(agreement.worst_weight < WEIGHTS && agreement.worst_distance < DISTANCE, "{agreement:?}");
    assert!(agreement.plants > agreement.rays / 20, "{agreement:?}");
}

/// Dispatches and strips of odd sizes.
pub(super) fn settings() -> ForestSettings {
    ForestSettings { rays_per_dispatch: 5_000, ..ForestSettings::default() }
}

pub(super) fn two<'a>(
    meshes: &'a [Mesh; 2],
    shading: Shading,
    instances: &[Placement],
    ground: Option<Ground>,
) -> Forest<'a> {
    let species = [0, 1].map(|index| Species { mesh: &meshes[index], classes: &CLASSES, shading });
    Forest::prepare(&species, instances, ground, Search::default()).unwrap()
}

pub(super) fn meshes() -> [Mesh; 2] {
    [plant(PlantKind::Oak, 20_000), plant(PlantKind::Spruce, 8_000)]
}

#[test]
fn a_triangle_of_one_side_is_met_from_that_side_alone_as_on_the_cpu() {
    let mut meshes = meshes();
    for mesh in &mut meshes {
        let sides = [Side::Front, Side::Both, Side::Back, Side::Back];
        mesh.sheets.sides = (0..mesh.triangles.len()).map(|triangle| sides[triangle % 4]).collect();
    }
    let instances = stand(17, 30.0, [0.0; 3]);
    let forest = two(&meshes, Shading::Paper, &instances, Some(plane()));
    let both = [&meshes[0], &meshes[1]];
    assert_agrees(&compare(&forest, &both, &instances, &view([160, 90], 1, 30.0)));
}

#[test]
fn rays_meet_what_they_meet_on_the_cpu() {
    let meshes = meshes();
    let instances = stand(17, 30.0, [0.0; 3]);
    let both = [&meshes[0], &meshes[1]];
    // Sizes that are no multiples of a square, one and four rays a pixel.
    for (size, samples, ground) in [([203, 117], 1, Some(plane())), ([90, 61], 4, Some(hills(60.0)))] {
        let forest = two(&meshes, Shading::Paper, &instances, ground);
        let agreement = compare(&forest, &both, &instances, &view(size, samples, 30.0));
        assert_agrees(&agreement);
        assert!(agreement.grounds > agreement.rays / 20, "{agreement:?}");
    }
}

#[test]
fn a_stand_a_thousand_kilometres_off_is_met_as_well() {
    let meshes = meshes();
    let middle = [1_048_576.3, 211.7, -734_003.9];
    let instances = stand(9, 20.0, middle);
    let forest = two(&meshes, Shading::Paper, &instances, None);
    let mut view = view([120, 90], 1, 25.0);
    let moved = |point: [f64; 3]| std::array::from_fn(|axis| point[axis] + middle[axis]);
    view.eye.position_m = moved(view.eye.position_m);
    view.eye.look_at_m = moved(view.eye.look_at_m);
    assert_agrees(&compare(&forest, &[&meshes[0], &meshes[1]], &instances, &view));
}

#[test]
fn cuts_wrap_and_turn_as_on_the_cpu() {
    let mut mesh = plant(PlantKind::Shrub, 2_000);
    let transform = [[2.7, 0.4, -0.3], [-0.2, 1.9, 0.45]];
    for wrap in [[Wrap::Repeat, Wrap::Mirror], [Wrap::Mirror, Wrap::Clamp]] {
        mesh.materials[1].color_texture = Some(Texture { image: 1, wrap, transform, filter: Filter::Linear });
        let instances = [Placement { species: 0, transform: stand(1, 1.0, [0.0; 3])[0].transform }];
        let species = [Species { mesh: &mesh, classes: &CLASSES, shading: Shading::Paper }];
        let forest = Forest::prepare(&species, &instances, None, Search::default()).unwrap();
        let mut view = view([96, 96], 1, 4.0);
        view.eye.look_at_m = [0.0, 0.6, 0.0];
        let agreement = compare(&forest, &[&mesh], &instances, &view);
        assert!(agreement.different <= agreement.rays / 300, "{agreement:?}");
        assert!(agreement.plants > agreement.rays / 50, "{agreement:?}");
    }
}

#[test]
fn other_instances_are_met_once_they_are_set() {
    let meshes = meshes();
    let (before, after) = (stand(3, 8.0, [0.0; 3]), stand(11, 20.0, [1.0, 0.5, -2.0]));
    let mut forest = two(&meshes, Shading::Paper, &before, None);
    let gpu = gpu();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &dark(&gpu, 2), settings()).unwrap();
    let view = view([64, 64], 1, 25.0);
    on_gpu.trace(&view).unwrap();
    let old = on_gpu.fragments().unwrap();
    forest.set_instances(&after).unwrap();
    on_gpu.set_instances(&forest).unwrap();
    assert!(matches!(on_gpu.fragments(), Err(crate::ForestError::NotTraced)));
    on_gpu.trace(&view).unwrap();
    let new = on_gpu.fragments().unwrap();
    let fresh = two(&meshes, Shading::Paper, &after, None);
    let mut of_fresh = GpuForest::new(&gpu, &fresh, &dark(&gpu, 2), settings()).unwrap();
    of_fresh.trace(&view).unwrap();
    assert!(new == of_fresh.fragments().unwrap() && new != old);
}

#[test]
fn a_planted_difference_is_found() {
    let meshes = meshes();
    let instances = stand(5, 12.0, [0.0; 3]);
    let mut moved = instances.clone();
    moved[2].transform.position_m[0] += 0.05;
    let forest = two(&meshes, Shading::Paper, &moved, Some(plane()));
    let truth = two(&meshes, Shading::Paper, &instances, Some(plane()));
    let gpu = gpu();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &dark(&gpu, 2), settings()).unwrap();
    let view = scenes::view([128, 96], 1, 20.0);
    on_gpu.trace(&view).unwrap();
    let expected = truth.trace(&view, &|_| Ok(())).unwrap();
    let found = on_gpu.fragments().unwrap();
    let differ = found.iter().enumerate().filter(|(ray, met)| {
        let twin = expected.at(*ray as u32 % 128, *ray as u32 / 128, 0);
        match (met, twin) {
            (CameraHit::Plant { triangle, .. }, Some(Fragment::Plant { found, .. })) => {
                *triangle != found.triangle
            }
            (CameraHit::Sky, Some(Fragment::Sky))
            | (CameraHit::Ground { .. }, Some(Fragment::Ground { .. })) => false,
            _ => true,
        }
    });
    assert!(differ.count() > found.len() / 100);
}
