//! Rays through the whole scene: what they meet first, and whether anything stands before the sun.

use glam::{DVec3, Vec3};

use super::{Forest, placed::WorldRay, sun_grid::SunGrid, view_grid::ViewGrid};
use crate::lens::Lens;
use crate::scene::{Hit, Ray, TriangleHit};

/// The nearest plant along a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlantHit {
    pub distance_m: f64,
    pub instance: u32,
    pub found: TriangleHit,
}

impl Forest<'_> {
    /// The nearest plant along any ray, by the tree over all instances.
    pub(crate) fn nearest(&self, ray: &WorldRay) -> Option<PlantHit> {
        let mut best = None;
        self.tree.visit(ray, |instance| {
            self.meet(instance, ray, &mut best);
            best.as_ref().map_or(f64::INFINITY, |met: &PlantHit| met.distance_m)
        });
        best
    }

    /// The same for the ray through a point of the picture.
    pub(crate) fn nearest_in_view(&self, grid: &ViewGrid, lens: &Lens, x: f64, y: f64) -> Option<PlantHit> {
        let ray = lens.ray(x, y);
        let mut best: Option<PlantHit> = None;
        for &(distance_m, instance) in grid.list(x, y) {
            if best.as_ref().is_some_and(|met| met.distance_m < distance_m) {
                break;
            }
            self.meet(instance, &ray, &mut best);
        }
        best
    }

    /// Whether anything stands between the sun and a point on one side of a plant's surface. `towards` is a unit vector
    /// of the world.
    pub(crate) fn is_shaded(&self, sun: &SunWay, instance: u32, hit: &Hit, side: Vec3) -> bool {
        let placed = &self.instances[instance as usize];
        let model = &self.models[placed.placement.species];
        let origin = model.off(hit.point, side);
        let own = Ray { origin, direction: placed.model_direction(sun.towards).as_vec3() };
        // The plant itself is the likeliest to stand in the way.
        if model.is_blocked(own, Some(hit.triangle)) {
            return true;
        }
        let ray = WorldRay { origin: placed.world_point(origin.as_dvec3()), direction: sun.towards };
        self.is_blocked(sun, &ray, Some(instance))
    }

    /// Whether a plant or the ground blocks a ray towards the sun, the instance `except` and what the ray leaves aside.
    pub(crate) fn is_blocked(&self, sun: &SunWay, ray: &WorldRay, except: Option<u32>) -> bool {
        if self.soil.as_ref().is_some_and(|soil| soil.is_blocking(ray)) {
            return true;
        }
        let blocks = |instance: u32| Some(instance) != except && self.blocks(instance, ray);
        match &sun.grid {
            None => self.tree.any(ray, blocks),
            Some(grid) => grid.ahead(ray).any(blocks),
        }
    }

    /// Whether any plant stands in the way of a ray.
    pub(crate) fn is_hidden(&self, ray: &WorldRay) -> bool {
        self.tree.any(ray, |instance| self.blocks(instance, ray))
    }

    fn blocks(&self, instance: u32, ray: &WorldRay) -> bool {
        let placed = &self.instances[instance as usize];
        let model = &self.models[placed.placement.species];
        placed.enter(ray, &model.hull).is_some_and(|inside| model.is_blocked(inside.ray, None))
    }

    /// Puts the instance into `best` if the ray meets it nearer. Of two at the same distance the one with the lower
    /// number is taken, so that the order of a search cannot show.
    fn meet(&self, instance: u32, ray: &WorldRay, best: &mut Option<PlantHit>) {
        let placed = &self.instances[instance as usize];
        let model = &self.models[placed.placement.species];
        let Some(inside) = placed.enter(ray, &model.hull) else { return };
        let far = best.as_ref().map_or(f32::INFINITY, |met| placed.model_distance(&inside, met.distance_m));
        if far < 0.0 {
            return;
        }
        let Some(found) = model.find(inside.ray, far) else { return };
        let distance_m = placed.world_distance(&inside, found.distance);
        let is_nearer = best.as_ref().is_none_or(|met| {
            distance_m < met.distance_m || (distance_m == met.distance_m && instance < met.instance)
        });
        if is_nearer {
            *best = Some(PlantHit { distance_m, instance, found });
        }
    }
}

/// A sun, and how its shadow rays find instances.
pub(crate) struct SunWay {
    /// Unit, of the world.
    pub towards: DVec3,
    pub grid: Option<SunGrid>,
}
