//! The triangles of a plant that stop light, and the rays of a view that they stop.

use crate::voxelise::VoxelError;
use flb_scene::alpha::{Coverage, Cut, TexelBox, index};
use flb_scene::{MaterialClass, Mesh};

use super::view::View;

/// Snapped units per pixel: edges shared by two triangles are the same line to the bit.
const UNITS: f64 = 4096.0;

/// The leaf and wood triangles of a mesh, what is cut away left out.
pub(super) struct Facets<'a> {
    mesh: &'a Mesh,
    /// Per material that counts: whether it is wood, and what of it is there.
    surfaces: Vec<Option<(bool, Coverage)>>,
    /// Triangles that count.
    triangles: Vec<u32>,
}

/// A point where a ray meets a facet.
pub(super) struct Hit {
    /// The ray.
    pub ray: usize,
    /// Metres along the axis.
    pub depth_m: f64,
    pub wood: bool,
    /// Whether the triangle stands for one side of a leaf alone.
    pub one_sided: bool,
}

impl<'a> Facets<'a> {
    /// The facets of a mesh; `classes` has one entry per material.
    pub(super) fn new(
        mesh: &'a Mesh,
        classes: &[MaterialClass],
        ignore_alpha: bool,
    ) -> Result<Facets<'a>, VoxelError> {
        if classes.len() != mesh.materials.len() {
            return Err(VoxelError::Classes { found: classes.len(), expected: mesh.materials.len() });
        }
        if let Some(vertex) = mesh.positions.iter().position(|at| !at.iter().all(|c| c.is_finite())) {
            return Err(VoxelError::NotFinite { vertex, position: mesh.positions[vertex] });
        }
        let surface = |(material, class): (usize, &MaterialClass)| {
            if *class == MaterialClass::Neither {
                return Ok(None);
            }
            let coverage = if ignore_alpha { Coverage::Full } else { Coverage::of(mesh, material)? };
            Ok((coverage != Coverage::Nothing).then_some((*class == MaterialClass::Wood, coverage)))
        };
        let surfaces = classes.iter().enumerate().map(surface).collect::<Result<Vec<_>, VoxelError>>()?;
        let counts = |&triangle: &u32| surfaces[mesh.triangle_material[triangle as usize] as usize].is_some();
        let triangles = (0..mesh.triangles.len() as u32).filter(counts).collect();
        Ok(Facets { mesh, surfaces, triangles })
    }

    /// The triangles, to be shared out.
    pub(super) fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Corners of a triangle, metres.
    pub(super) fn corners(&self, triangle: u32) -> [[f64; 3]; 3] {
        self.mesh.triangles[triangle as usize].map(|v| self.mesh.positions[v as usize].map(f64::from))
    }

    /// Twice the area of a triangle, times its normal.
    pub(super) fn normal_m2(&self, triangle: u32) -> [f64; 3] {
        let [a, b, c] = self.corners(triangle);
        let side = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| p[k] - a[k]) };
        let (b, c) = (side(b), side(c));
        [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]]
    }

    /// Area of a triangle, nothing cut away.
    pub(super) fn area_m2(&self, triangle: u32) -> f64 {
        libm::sqrt(self.normal_m2(triangle).iter().map(|c| c * c).sum()) / 2.0
    }

    /// Share of it that counts: half of a triangle that stands for one side of a leaf.
    pub(super) fn counted(&self, triangle: u32) -> f64 {
        self.mesh.sheets.side(triangle as usize).share()
    }

    /// Whether a triangle is wood, and the share of it that is there.
    pub(super) fn kind(&self, triangle: u32) -> (bool, f64) {
        let (wood, coverage) = self.surface(triangle);
        let Coverage::Cut(cut) = coverage else { return (*wood, 1.0) };
        let texels = self.texels(cut, triangle);
        let end = |pick: fn(f64, f64) -> f64| {
            std::array::from_fn(|axis| pick(pick(texels[0][axis], texels[1][axis]), texels[2][axis]))
        };
        (*wood, cut.share(&texels, &TexelBox::of(end(f64::min), end(f64::max))))
    }

    fn surface(&self, triangle: u32) -> &(bool, Coverage) {
        let material = self.mesh.triangle_material[triangle as usize] as usize;
        self.surfaces[material].as_ref().expect("only triangles that count are listed")
    }

    fn texels(&self, cut: &Cut, triangle: u32) -> [[f64; 2]; 3] {
        let uv_of = |v: u32| cut.texel_from_uv(self.mesh.uvs[v as usize]);
        let mut texels = self.mesh.triangles[triangle as usize].map(uv_of);
        cut.near_origin(&mut texels);
        texels
    }

    /// Visits every ray of a view that meets what is there of a triangle. A ray through an edge that two triangles
    /// share meets one of them.
    pub(super) fn for_each_hit(&self, view: &View, triangle: u32, mut visit: impl FnMut(Hit)) {
        let (wood, coverage) = self.surface(triangle);
        let projected = self.corners(triangle).map(|corner| view.project(corner));
        let mut corner: [[i64; 2]; 3] = projected.map(|[x, y, _]| [x, y].map(|c| index(c * UNITS + 0.5)));
        let mut order = [0, 1, 2];
        let cross = |[a, b, c]: [[i64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let mut area = cross(corner);
        if area < 0 {
            corner.swap(1, 2);
            order.swap(1, 2);
            area = -area;
        }
        if area == 0 {
            return;
        }
        let one_sided = self.counted(triangle) < 1.0;
        let depth = PlaneDepth::of(order.map(|i| projected[i]));
        let texels = match coverage {
            Coverage::Cut(cut) => {
                let texels = self.texels(cut, triangle);
                Some((cut, order.map(|i| texels[i])))
            }
            _ => None,
        };
        let half = UNITS as i64 / 2;
        // Rays whose centre lies in [low, high], clipped to the view.
        let ends = |k: usize| {
            let all = corner.map(|c| c[k]);
            let (low, high) = (all[0].min(all[1]).min(all[2]), all[0].max(all[1]).max(all[2]));
            let first = (low - half + UNITS as i64 - 1).div_euclid(UNITS as i64).max(0);
            let last = (high - half).div_euclid(UNITS as i64).min(view.size[k] as i64 - 1);
            (first, last)
        };
        let ((left, right), (top, bottom)) = (ends(0), ends(1));
        for j in top..=bottom {
            let y = j * UNITS as i64 + half;
            let (mut first, mut last) = (left, right);
            // Per edge: value(x) = slope x + offset, inside where >= 0 (edges owned) or > 0.
            let mut lines = [(0i64, 0i64); 3];
            for e in 0..3 {
                let (a, b) = (corner[(e + 1) % 3], corner[(e + 2) % 3]);
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let owned = dy > 0 || (dy == 0 && dx < 0);
                let slope = -dy;
                let offset = dx * (y - a[1]) + dy * a[0];
                lines[e] = (slope, offset);
                let needed = if owned { 0 } else { 1 };
                // slope (i UNITS + half) + offset >= needed
                let rest = needed - offset - slope * half;
                let per_step = slope * UNITS as i64;
                match per_step {
                    0 if rest > 0 => last = first - 1,
                    0 => {}
                    up if up > 0 => first = first.max(-((-rest).div_euclid(up))),
                    down => last = last.min((-rest).div_euclid(-down)),
                }
            }
            for i in first..=last {
                let x = i * UNITS as i64 + half;
                let weight = lines.map(|(slope, offset)| (slope * x + offset) as f64 / area as f64);
                if let Some((cut, texels)) = &texels {
                    let at = |k: usize| (0..3).map(|c| weight[c] * texels[c][k]).sum::<f64>();
                    if !cut.present([index(at(0)), index(at(1))]) {
                        continue;
                    }
                }
                let depth_m = depth.at([i, j].map(|c| c as f64 + 0.5), weight);
                visit(Hit { ray: j as usize * view.size[0] + i as usize, depth_m, wood: *wood, one_sided });
            }
        }
    }
}

/// Largest slope of a plane, metres per pixel: what is steeper is seen on its edge, and its area is that of rounding.
const STEEPEST: f64 = 1e9;

/// Depth of the plane of a triangle over pixel coordinates. Rays meet the triangle whose corners are rounded to
/// sub-pixels. A depth between its corners would be off by a sub-pixel times the slope. So a sheet in a face between
/// two sites would lie partly in each.
struct PlaneDepth {
    corners: [[f64; 3]; 3],
    /// Per pixel. `None` for what is seen on its edge.
    slope: Option<[f64; 2]>,
    /// Least and largest depth of the corners.
    range: [f64; 2],
}

impl PlaneDepth {
    fn of(corners: [[f64; 3]; 3]) -> PlaneDepth {
        let [first, second, third] = corners;
        let [a, b] = [second, third].map(|corner| std::array::from_fn::<f64, 3, _>(|k| corner[k] - first[k]));
        let area = a[0] * b[1] - a[1] * b[0];
        let slope = [(a[2] * b[1] - a[1] * b[2]) / area, (a[0] * b[2] - a[2] * b[0]) / area];
        let slope = Some(slope).filter(|slope| slope.iter().all(|c| c.abs() < STEEPEST));
        let range = [f64::min, f64::max].map(|of| of(of(first[2], second[2]), third[2]));
        PlaneDepth { corners, slope, range }
    }

    /// At a pixel with barycentric weights in the rounded triangle: within the depths of the corners.
    fn at(&self, pixel: [f64; 2], weight: [f64; 3]) -> f64 {
        let Some(slope) = self.slope else { return (0..3).map(|c| weight[c] * self.corners[c][2]).sum() };
        let first = self.corners[0];
        let plane = first[2] + slope[0] * (pixel[0] - first[0]) + slope[1] * (pixel[1] - first[1]);
        plane.clamp(self.range[0], self.range[1])
    }
}
