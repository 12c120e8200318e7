//! A picture in strips, rows of squares of 8 x 8 pixels, each as large as one buffer of fragments; and a strip in
//! dispatches, each as long as a driver's patience.

use flb_gpu::Gpu;

use crate::ForestError;
use crate::buffers::{empty, uniform};
use crate::layout::{BY_WATER, EDGE, FRAGMENT_BYTES, GROUND, LIT_BYTES, SKY, UNIFORM_STRIDE, WORKGROUP};
use crate::stages::{self, Stages};

/// First hit of a ray of the camera, as read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CameraHit {
    /// Nothing was hit.
    Sky,
    /// The ground.
    Ground {
        /// Distance from the camera, metres.
        distance_m: f32,
        /// Light of the sky by the cosine, as a share of that without plants.
        sky: f32,
    },
    /// An instance.
    Plant {
        /// Number of the instance in the scene.
        instance: u32,
        /// Index of the triangle in the instance's mesh.
        triangle: u32,
        /// Barycentric weights of the triangle's second and third vertex.
        weights: [f32; 2],
        /// Distance from the camera, metres.
        distance_m: f32,
    },
    /// Water.
    Water {
        /// Light of the sky by the cosine, as a share of that without plants.
        sky: f32,
    },
}

/// One dispatch of a stage: where its `Strip` lies among the uniforms, and its workgroups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dispatch {
    pub offset: u32,
    pub workgroups: u32,
}

/// Rows of squares that share a buffer of fragments.
pub(crate) struct Strip {
    pub fragments: wgpu::Buffer,
    pub rays: wgpu::BindGroup,
    /// Dispatches of stages that serve rays.
    pub per_ray: Vec<Dispatch>,
    /// Dispatches of stages that serve pixels.
    pub per_pixel: Vec<Dispatch>,
}

/// A picture's buffers.
pub(crate) struct Strips {
    /// Columns and rows of pixels, and rays of each.
    pub size: [u32; 3],
    pub strips: Vec<Strip>,
    pub uniforms: wgpu::Buffer,
}

/// How a picture is cut, before anything is allocated.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct StripPlan {
    /// Squares in a row.
    columns: u32,
    /// Rows of squares.
    rows: u32,
    /// Rows of squares of a strip, but for the last.
    rows_per_strip: u32,
    samples: u32,
}

impl StripPlan {
    /// For so many columns and rows of pixels and rays of each, with buffers of `buffer_bytes` at most, and all
    /// fragments within `budget_bytes`.
    pub(crate) fn new(
        [width, height, samples]: [u32; 3],
        buffer_bytes: u64,
        budget_bytes: u64,
    ) -> Result<StripPlan, ForestError> {
        let [columns, rows] = [width, height].map(|edge| edge.div_ceil(EDGE));
        let row_rays = u64::from(columns) * u64::from(WORKGROUP) * u64::from(samples);
        let limit = buffer_bytes / LIT_BYTES * LIT_BYTES;
        let per_strip = limit / (row_rays * LIT_BYTES);
        let too_large =
            |what, needed, limit, remedy| Err(ForestError::TooLarge { what, needed, limit, remedy });
        if per_strip == 0 {
            let what = "the rays of eight rows of pixels";
            return too_large(what, row_rays * LIT_BYTES, buffer_bytes, "with fewer pixels or samples");
        }
        let fragments = row_rays * u64::from(rows) * FRAGMENT_BYTES;
        if fragments > budget_bytes {
            return too_large(
                "the picture's fragments",
                fragments,
                budget_bytes,
                "with fewer pixels or samples",
            );
        }
        let picture = u64::from(width) * u64::from(height) * PIXEL_BYTES;
        if picture > buffer_bytes {
            return too_large("the picture's pixels", picture, buffer_bytes, "with fewer pixels");
        }
        let rows_per_strip = per_strip.min(u64::from(rows)) as u32;
        Ok(StripPlan { columns, rows, rows_per_strip, samples })
    }

    /// First row of squares and rows of each strip.
    fn strips(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        (0..self.rows)
            .step_by(self.rows_per_strip as usize)
            .map(|top| (top, self.rows_per_strip.min(self.rows - top)))
    }

    fn rays(&self, rows: u32) -> u64 {
        u64::from(rows * self.columns) * u64::from(self.samples) * u64::from(WORKGROUP)
    }
}

/// Bytes of a pixel of the picture's buffer.
pub(crate) const PIXEL_BYTES: u64 = 16;

impl Strips {
    pub(crate) fn new(
        gpu: &Gpu,
        stages: &Stages,
        size: [u32; 3],
        budget_bytes: u64,
        rays_per_dispatch: u32,
    ) -> Result<Strips, ForestError> {
        let plan = StripPlan::new(size, gpu.largest_buffer_bytes(), budget_bytes)?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        // One after the other goes through it.
        let lit = empty(gpu, "flb lit", plan.rays(plan.rows_per_strip) * LIT_BYTES, usage);
        let mut words: Vec<u32> = Vec::new();
        let mut strips = Vec::new();
        for (top, rows) in plan.strips() {
            let fragments = empty(gpu, "flb fragments", plan.rays(rows) * FRAGMENT_BYTES, usage);
            let buffers = [fragments.as_entire_binding(), lit.as_entire_binding()];
            let rays = stages::group(&gpu.device, "flb rays", &stages.rays, &buffers);
            let squares = rows * plan.columns;
            let most = (rays_per_dispatch / WORKGROUP).clamp(1, MAX_WORKGROUPS);
            let mut cut = |count: u32| -> Vec<Dispatch> {
                (0..count)
                    .step_by(most as usize)
                    .map(|first| {
                        let offset = 4 * words.len() as u32;
                        words.extend([top, plan.columns, first, 0]);
                        words.resize(words.len().next_multiple_of(UNIFORM_STRIDE as usize / 4), 0);
                        Dispatch { offset, workgroups: most.min(count - first) }
                    })
                    .collect()
            };
            let (per_ray, per_pixel) = (cut(squares * plan.samples), cut(squares));
            strips.push(Strip { fragments, rays, per_ray, per_pixel });
        }
        let uniforms = uniform(gpu, "flb strips", &words);
        Ok(Strips { size, strips, uniforms })
    }

    /// Memory of fragments.
    pub(crate) fn size_bytes(&self) -> u64 {
        self.strips.iter().map(|strip| strip.fragments.size()).sum()
    }

    /// What each ray met, and what by way of water, `[y][x][sample]`. `instances` and `triangles` are the numbers of
    /// what has a place in the trees' orders.
    pub(crate) fn read(
        &self,
        gpu: &Gpu,
        instances: &[u32],
        triangles: &[u32],
    ) -> Result<Vec<(CameraHit, Option<CameraHit>)>, ForestError> {
        let [width, height, samples] = self.size;
        let columns = width.div_ceil(EDGE) as usize;
        let mut met = vec![(CameraHit::Sky, None); width as usize * height as usize * samples as usize];
        let mut square = 0;
        for strip in &self.strips {
            let bytes = gpu.read(&strip.fragments)?;
            let word =
                |at: usize| u32::from_le_bytes(bytes[4 * at..4 * at + 4].try_into().expect("four bytes"));
            let per_square = (WORKGROUP * samples) as usize;
            let rays = bytes.len() / FRAGMENT_BYTES as usize;
            for ray in 0..rays {
                let (number, within) = (square + ray / per_square, ray % per_square);
                let (sample, local) = (within / WORKGROUP as usize, within % WORKGROUP as usize);
                let edge = EDGE as usize;
                let x = number % columns * edge + local % edge;
                let y = number / columns * edge + local / edge;
                if x < width as usize && y < height as usize {
                    let at = ray * FRAGMENT_BYTES as usize / 4;
                    let words = std::array::from_fn(|member| word(at + member));
                    met[(y * width as usize + x) * samples as usize + sample] =
                        met_of(words, instances, triangles);
                }
            }
            square += rays / per_square;
        }
        Ok(met)
    }
}

/// Most workgroups along an axis, that WebGPU allows everywhere.
const MAX_WORKGROUPS: u32 = 65_535;

fn met_of(
    [instance, triangle, u, v, distance, sky]: [u32; 6],
    instances: &[u32],
    triangles: &[u32],
) -> (CameraHit, Option<CameraHit>) {
    let distance_m = f32::from_bits(distance);
    let met = match instance {
        SKY => CameraHit::Sky,
        GROUND => CameraHit::Ground { distance_m, sky: f32::from_bits(sky) },
        place => CameraHit::Plant {
            instance: instances.get(place as usize).copied().unwrap_or(u32::MAX),
            triangle: triangles.get((triangle & !BY_WATER) as usize).copied().unwrap_or(u32::MAX),
            weights: [f32::from_bits(u), f32::from_bits(v)],
            distance_m,
        },
    };
    if triangle & BY_WATER == 0 {
        return (met, None);
    }
    let sky = f32::from_bits(if instance == GROUND { u } else { sky });
    (CameraHit::Water { sky }, Some(met))
}
