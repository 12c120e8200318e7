//! A bounding volume hierarchy over the boxes of all instances: for rays of any kind.

use std::time::Duration;

use glam::{DVec3, Vec3};
use obvhs::{
    BvhBuildParams,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray as BoxRay, RayHit},
};

use super::placed::{Extent, Placed, WorldRay};
use crate::scene::PaddedBox;

/// Padding, as a share of the stand's size: some tens of the last place of an f32.
const PAD: f64 = 4e-6;

pub(crate) struct InstanceTree {
    pub tree: Bvh2,
    /// Box around all instances, padded.
    pub extent: Extent,
    /// Origin of the tree's coordinates, so that f32 does for a stand that lies far off.
    pub center: DVec3,
}

impl InstanceTree {
    pub(super) fn over(instances: &[Placed]) -> InstanceTree {
        let all = instances.iter().fold(Extent::EMPTY, |all, placed| all.union(&placed.extent));
        let pad = (all.max - all.min).length().max(1e-6) * PAD;
        let center = all.center();
        let relative = |point: DVec3| (point - center).as_vec3();
        let boxes: Vec<PaddedBox> = (0..)
            .zip(instances)
            .map(|(index, placed)| {
                let (min, max) = (relative(placed.extent.min), relative(placed.extent.max));
                PaddedBox::around([min, max, max], index, pad as f32)
            })
            .collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        InstanceTree { tree, extent: all.padded(4.0 * pad), center }
    }

    /// Offers instances near a ray to `meet`, the nearer ones more or less first, which gives the distance in metres
    /// beyond which nothing counts any more.
    pub(super) fn visit(&self, ray: &WorldRay, mut meet: impl FnMut(u32) -> f64) {
        let Some((start, inside)) = self.enter(ray) else { return };
        self.tree.ray_traverse(inside, &mut RayHit::none(), |_, at| {
            let beyond = meet(self.tree.primitive_indices[at]) - start;
            (beyond + beyond.abs() * 1e-6) as f32
        });
    }

    /// Whether `meets` says so of any instance near a ray.
    pub(super) fn any(&self, ray: &WorldRay, mut meets: impl FnMut(u32) -> bool) -> bool {
        let Some((_, inside)) = self.enter(ray) else { return false };
        !self.tree.ray_traverse_miss(inside, |_, at| match meets(self.tree.primitive_indices[at]) {
            true => 0.0,
            false => f32::INFINITY,
        })
    }

    /// The ray from where it enters the box around all, and how far that is.
    fn enter(&self, ray: &WorldRay) -> Option<(f64, BoxRay)> {
        let [start, _] = self.extent.along(ray)?;
        let origin: Vec3 = (ray.origin + ray.direction * start - self.center).as_vec3();
        Some((start, BoxRay::new(origin.into(), ray.direction.as_vec3().into(), 0.0, f32::MAX)))
    }
}
