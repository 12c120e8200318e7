//! A plant of a `.flb` file on a GPU: what a renderer does with flb.
//!
//! ```text
//! Library -GpuSpecies::load-> GpuLight -bind group 1-> plant.wgsl -> picture
//!                  sun, sky -GpuSpecies::terms-^
//! ```

use std::error::Error;

use flb_format::sun;
use flb_runtime::Library;
use flb_runtime::extinction::Extinction;
use flb_runtime::gpu::{GpuLight, GpuSpecies, LightSettings, light_wgsl};
use glam::Vec3;
use glam::camera::rh::{proj::directx, view}; // WebGPU's clip space is that of DirectX.

use crate::leaves;
use crate::pipeline::Pipeline;

/// Fluence of the sky, that of the sun being 1: about a clear day's.
const SKY: f32 = 0.36;

/// Where the sun stands: azimuth clockwise from north as seen from above.
#[derive(Clone, Copy)]
pub(crate) struct Sun {
    pub azimuth_deg: f64,
    pub elevation_deg: f64,
    pub is_on: bool,
}

/// A species on the GPU, and one plant of it that stands where the model has it.
pub(crate) struct Plant {
    /// The buffers and the bind group of the light of all species; here of one.
    light: GpuLight,
    species: GpuSpecies,
    pipeline: Pipeline,
    /// Reflectance of leaves, transmittance of leaves, reflectance of wood; red, green and blue.
    surfaces: [[f32; 4]; 3],
    /// How far off a solid its light is sampled, metres.
    solid_offset_m: f32,
    /// Lowest and highest corner, metres.
    bounds_m: [Vec3; 2],
}

impl Plant {
    /// Reads the first species of a file, of the model `physical`, and sends it to the device.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        format: wgpu::TextureFormat,
        path: &str,
    ) -> Result<Plant, Box<dyn Error>> {
        let library = Library::open(path)?;
        let meta = &library.container().species()[0].meta;
        let names: Vec<&str> = meta.bands().collect();
        let rgb = meta.color_bands().ok_or(format!("bands {names:?}, expected R, G and B"))?;
        // Whatever their order in the file, and whatever bands are beside them.
        let library = library.with_bands(0, &rgb);
        let meta = &library.container().species()[0].meta;
        let (surfaces, stored) = meta.physical().ok_or("a file of the model `paper` has no surfaces")?;
        let [red, green, blue] = &surfaces.bands[..] else {
            unreachable!("three were chosen");
        };
        let rgb = |of: fn(&flb_format::matter::BandSurfaces) -> f64| {
            [red, green, blue, blue].map(|band| of(band) as f32)
        };

        // The light: all bases of the species, sent once. A forest streams them (`flb_runtime::gpu::Follower`).
        let mut light = GpuLight::new(device, queue, LightSettings::default())?;
        let species = GpuSpecies::load(&mut light, &library, 0)?;

        // A renderer has the mesh that was baked. A file knows how much leaf is where; that is drawn here.
        let turbid = library.container().read_turbid(library.source(), 0)?;
        // The marches of plant.wgsl need the extinction, which `load` sends for suns of harmonics alone.
        if !stored.suns.has_near_beam() {
            light.set_extinction(species.number(), &Extinction::of(&turbid), false)?;
        }

        // The functions that sample the light stand before the renderer's own shader, in a bind group that it chooses.
        let shader = light_wgsl(1) + include_str!("plant.wgsl");
        let vertices = leaves::vertices(&turbid);
        let pipeline = Pipeline::new(device, queue, format, &shader, light.bind_group_layout(), &vertices);
        Ok(Plant {
            light,
            species,
            pipeline,
            solid_offset_m: meta.solid_offset_m().unwrap_or(0.0) as f32,
            surfaces: [
                rgb(|band| band.leaf.reflectance),
                rgb(|band| band.leaf.transmittance),
                rgb(|band| band.wood.reflectance),
            ],
            bounds_m: [meta.bounds_m.min, meta.bounds_m.max]
                .map(|corner| Vec3::from_array(corner.map(|c| c as f32))),
        })
    }

    /// Draws the plant, seen from the south, into a texture.
    pub(crate) fn draw(
        &mut self,
        target: &wgpu::TextureView,
        size: [u32; 2],
        sun: Sun,
    ) -> Result<(), Box<dyn Error>> {
        // How much of each base is in the light of this plant: once per plant when the sun moves. The sun's direction
        // is that in the frame of the model; this plant is not turned.
        let towards_sun = sun::towards_sun(sun.azimuth_deg, sun.elevation_deg);
        let irradiance = f32::from(u8::from(sun.is_on));
        let mut terms = Vec::new();
        let near_count = self.species.terms(towards_sun, irradiance, SKY, &mut terms)?;
        self.light.set_terms(0, &terms)?;

        let [low, high] = self.bounds_m;
        let (middle, edge) = (0.5 * (low + high), (high - low).max_element());
        let eye = middle + Vec3::new(0.0, 0.15, 1.0) * 1.35 * edge;
        let aspect = size[0] as f32 / size[1] as f32;
        let [c0, c1, c2, c3] = (directx::perspective(0.8, aspect, 0.01 * edge, 10.0 * edge)
            * view::look_at_mat4(eye, middle, Vec3::Y))
        .to_cols_array_2d();
        let [x, y, z] = towards_sun.map(|c| c as f32);
        let counts =
            [self.species.number().word() as f32, terms.len() as f32, near_count as f32, self.solid_offset_m];
        let [leaf_reflectance, leaf_transmittance, wood_reflectance] = self.surfaces;
        // `Frame` of plant.wgsl.
        let frame = [
            c0,
            c1,
            c2,
            c3,
            [x, y, z, irradiance],
            eye.extend(0.0).to_array(),
            leaf_reflectance,
            leaf_transmittance,
            wood_reflectance,
            counts,
        ];
        self.pipeline.draw(target, size, &frame, self.light.bind_group());
        Ok(())
    }
}
