//! What the plants stand on: rays to points of a plane or of a height field.

use flb_scene::scene::Heights;
use glam::{DVec3, Vec3};

use super::placed::{Extent, WorldRay};
use crate::RenderError;

/// A matt ground. It sends plants no light: neither does the lattice have one.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// Shape of the ground.
    pub land: Land,
    /// Linear reflectance R, G, B, each 0 to 1.
    pub color: [f32; 3],
    /// Distance from the middle of the stand, on level ground, at which the ground has faded into the haze, metres;
    /// `None` where the stand's size and the camera say.
    pub fades_at_m: Option<f64>,
}

/// The shape of a ground.
#[derive(Debug, Clone, PartialEq)]
pub enum Land {
    /// Level and without end.
    Plane {
        /// Height of the plane (y), metres.
        height_m: f64,
    },
    /// A height field; beyond its edges there is nothing.
    Heights(Heights),
}

impl Ground {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let refuse = |found: String, expected: &str| {
            Err(RenderError::Setting { name: "ground", found, expected: expected.into() })
        };
        if !self.color.iter().all(|share| (0.0..=1.0).contains(share)) {
            return refuse(format!("colour {:?}", self.color), "0..=1 in every band");
        }
        if let Some(fades_at_m) =
            self.fades_at_m.filter(|fades_at_m| !(fades_at_m.is_finite() && *fades_at_m > 0.0))
        {
            return refuse(format!("fades_at_m {fades_at_m}"), "a finite distance above 0");
        }
        match &self.land {
            Land::Plane { height_m } if height_m.is_finite() => Ok(()),
            Land::Plane { height_m } => refuse(format!("height_m {height_m}"), "a finite height"),
            Land::Heights(heights) => {
                let points = u64::from(heights.columns) * u64::from(heights.rows);
                if heights.columns < 2 || heights.rows < 2 || points != heights.height_m.len() as u64 {
                    let found = format!(
                        "{} x {} points, {} heights",
                        heights.columns,
                        heights.rows,
                        heights.height_m.len()
                    );
                    return refuse(found, "2 x 2 or more, and a height for each");
                }
                if !heights.size_m.iter().all(|edge| edge.is_finite() && *edge > 0.0) {
                    return refuse(format!("size_m {:?}", heights.size_m), "edges above 0");
                }
                match heights.height_m.iter().find(|height| !height.is_finite()) {
                    Some(height) => refuse(format!("a height of {height}"), "finite heights"),
                    None => Ok(()),
                }
            }
        }
    }
}

/// A ground made ready for rays.
pub(crate) struct GroundSurface {
    pub ground: Ground,
    /// Extent of a height field.
    pub extent: Extent,
}

impl GroundSurface {
    pub(super) fn new(ground: Ground) -> GroundSurface {
        let extent = match &ground.land {
            Land::Plane { .. } => Extent::EMPTY,
            Land::Heights(heights) => {
                let ([x, z], [width, depth]) = (heights.origin_m, heights.size_m);
                let of = |fold: fn(f32, f32) -> f32, start| {
                    f64::from(heights.height_m.iter().copied().fold(start, fold))
                };
                let (low, high) = (of(f32::min, f32::INFINITY), of(f32::max, f32::NEG_INFINITY));
                let extent =
                    Extent { min: DVec3::new(x, low, z), max: DVec3::new(x + width, high, z + depth) };
                extent.padded((extent.max - extent.min).length() * 1e-9)
            }
        };
        GroundSurface { ground, extent }
    }

    pub(super) fn color(&self) -> Vec3 {
        Vec3::from(self.ground.color)
    }

    /// Distance at which a ray comes through the ground, from above or, with a height field, from below.
    pub(super) fn along(&self, ray: &WorldRay) -> Option<f64> {
        match &self.ground.land {
            Land::Plane { height_m } => {
                let above = ray.origin.y - height_m;
                (above > 0.0 && ray.direction.y < 0.0).then(|| above / -ray.direction.y)
            }
            Land::Heights(heights) => along_heights(heights, &self.extent, ray),
        }
    }

    /// Unit normal, upwards; of a height field smooth from square to square.
    pub(super) fn normal(&self, point: DVec3) -> Vec3 {
        let Land::Heights(heights) = &self.ground.land else { return Vec3::Y };
        // By what the ground rises over a square's edge around the point.
        let [along_x, along_z] = heights.spacing_m();
        let rise = |dx: f64, dz: f64| {
            heights.at_m(point.x + dx, point.z + dz) - heights.at_m(point.x - dx, point.z - dz)
        };
        let slope = [rise(along_x, 0.0) / (2.0 * along_x), rise(0.0, along_z) / (2.0 * along_z)];
        DVec3::new(-slope[0], 1.0, -slope[1]).normalize().as_vec3()
    }

    /// Where a ray starts that leaves the ground.
    pub(super) fn off(&self, point: DVec3) -> DVec3 {
        point + DVec3::Y * self.lift_m()
    }

    /// How far above the ground that is.
    pub(super) fn lift_m(&self) -> f64 {
        match &self.ground.land {
            Land::Plane { .. } => 0.0,
            Land::Heights(_) => (self.extent.max - self.extent.min).length() * 1e-6,
        }
    }

    /// Whether a ray from above the ground is stopped by it.
    pub(super) fn is_blocking(&self, ray: &WorldRay) -> bool {
        match &self.ground.land {
            // What stands below a plane is seen through it, so it is lit through it too.
            Land::Plane { .. } => ray.direction.y <= 0.0,
            Land::Heights(heights) => along_heights(heights, &self.extent, ray).is_some(),
        }
    }
}

/// Walks the squares under a ray. Within a square the ground is two triangles, so that the ray's height above it
/// changes in two straight pieces: where its sign changes the ray comes through. Pieces share their ends, so nothing
/// slips between them.
fn along_heights(heights: &Heights, extent: &Extent, ray: &WorldRay) -> Option<f64> {
    let [start, end] = extent.along(ray)?;
    let spacing = heights.spacing_m();
    let origin = [ray.origin.x - heights.origin_m[0], ray.origin.z - heights.origin_m[1]];
    let origin = [origin[0] / spacing[0], origin[1] / spacing[1]];
    let slope = [ray.direction.x / spacing[0], ray.direction.z / spacing[1]];
    let last = [heights.columns - 2, heights.rows - 2];
    let mut square: [i64; 2] = std::array::from_fn(|axis| {
        (origin[axis] + slope[axis] * start).floor().clamp(0.0, f64::from(last[axis])) as i64
    });
    let above = |square: [i64; 2], distance: f64| {
        let shares: [f64; 2] = std::array::from_fn(|axis| {
            (origin[axis] + slope[axis] * distance - square[axis] as f64).clamp(0.0, 1.0)
        });
        ray.origin.y + ray.direction.y * distance - heights.within_m(square.map(|at| at as u32), shares)
    };
    let mut from = start;
    loop {
        // Where the ray leaves the square, and where it crosses its diagonal.
        let leaves: [f64; 2] = std::array::from_fn(|axis| match slope[axis] {
            0.0 => f64::INFINITY,
            slope => ((square[axis] + i64::from(slope > 0.0)) as f64 - origin[axis]) / slope,
        });
        let axis = usize::from(leaves[1] < leaves[0]);
        let to = leaves[axis].min(end).max(from);
        let diagonal = ((square[0] + square[1] + 1) as f64 - origin[0] - origin[1]) / (slope[0] + slope[1]);
        let middle = if diagonal > from && diagonal < to { diagonal } else { to };
        let mut before = (from, above(square, from));
        for distance in [middle, to] {
            let height = above(square, distance);
            if (before.1 > 0.0) != (height > 0.0) {
                return Some(before.0 + (distance - before.0) * (before.1 / (before.1 - height)));
            }
            before = (distance, height);
        }
        if leaves[axis] >= end {
            return None;
        }
        from = to;
        square[axis] += if slope[axis] > 0.0 { 1 } else { -1 };
        if square[axis] < 0 || square[axis] > i64::from(last[axis]) {
            return None;
        }
    }
}
