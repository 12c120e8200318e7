//! A forest on a GPU: what its stages are given, and in which order they run.

mod sent_grids;

use flb_gpu::Gpu;
use flb_render::forest::{Around, Forest, MAX_RAYS, ModelSearch, Scenery, Search, View};
use flb_render::picture::if_finite;
use flb_render::{Lighting, Look, Picture};
use flb_runtime::gpu::GpuLight;
use flb_runtime::resident::Resident;
use flb_runtime::scene_light::SceneLightAtSun;

use crate::buffers::{empty, storage, uniform};
use crate::camera::view_words;
use crate::dome::Dome;
use crate::layout::{DAYLIGHT_WORDS, LIGHT_WORDS, Words};
use crate::light_set::LightSet;
use crate::light_words::DaylightOn;
use crate::models::Models;
use crate::neighbours::Neighbours;
use crate::show::Show;
use crate::stages::{self, Stages, Ways};
use crate::stand::Stand;
use crate::statics::Statics;
use crate::streamed::StreamedLights;
use crate::strips::{CameraHit, Dispatch, PIXEL_BYTES, Strips};
use crate::surroundings::GroundAndWater;
use crate::{ForestError, PictureRect};
use sent_grids::SentView;

/// Limits of a forest on a GPU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForestSettings {
    /// Largest number of rays that a dispatch serves. An operating system ends what takes seconds.
    pub rays_per_dispatch: u32,
    /// Largest amount of memory for fragments: 24 bytes a ray. By default of as many rays as the CPU takes.
    pub fragment_bytes: u64,
    /// Search structures for what a ray meets, whatever the forest itself uses. The default is what `cargo bench -p
    /// flb-render-gpu --bench forest` found the fastest on software, as the CPU does.
    pub search: Search,
}

impl Default for ForestSettings {
    fn default() -> ForestSettings {
        ForestSettings {
            rays_per_dispatch: 1 << 17,
            fragment_bytes: 24 * MAX_RAYS,
            search: Search::default(),
        }
    }
}

/// A forest on a GPU, what a camera sees of it, and the picture that came of it last.
pub struct GpuForest {
    gpu: Gpu,
    stages: Stages,
    settings: ForestSettings,
    around: Around,
    soil: GroundAndWater,
    statics: Statics,
    stand: Stand,
    scene: wgpu::BindGroup,
    lights: (wgpu::Buffer, wgpu::BindGroup),
    light: wgpu::BindGroupLayout,
    /// Made with the first shade.
    neighbours: Option<Neighbours>,
    view: wgpu::Buffer,
    daylight: wgpu::Buffer,
    dome: Dome,
    /// What of a view was sent last.
    sent_view: Option<SentView>,
    taken: Option<TracedView>,
    show: Show,
}

/// What a camera sees of a part of its picture.
struct TracedView {
    view: View,
    part: PictureRect,
    /// Of the view's uniform.
    words: Vec<u32>,
    strips: Strips,
    frame: wgpu::BindGroup,
    picture: wgpu::Buffer,
    picture_group: wgpu::BindGroup,
    is_lit: bool,
}

/// What a camera sees of a part, put aside.
pub(crate) struct Traced(TracedView);

impl GpuForest {
    /// Sends a forest. Light comes from `lights` later, which give the layout of their buffers now.
    ///
    /// # Errors
    /// [`ForestError::TooMany`], [`ForestError::TooLarge`], [`ForestError::Device`].
    pub fn new(
        gpu: &Gpu,
        forest: &Forest<'_>,
        lights: &LightSet,
        settings: ForestSettings,
    ) -> Result<GpuForest, ForestError> {
        GpuForest::with_light(gpu, forest, lights.light(), settings)
    }

    /// Puts a forest on a GPU for [`StreamedLights`], or any light: buffers of all have one layout.
    ///
    /// # Errors
    /// As [`GpuForest::new`].
    pub fn with_light(
        gpu: &Gpu,
        forest: &Forest<'_>,
        light: &GpuLight,
        settings: ForestSettings,
    ) -> Result<GpuForest, ForestError> {
        let mut models = Models::new();
        let mut grids = (settings.search.model == ModelSearch::Grid).then(|| forest.flat_grids());
        for model in forest.flat_models() {
            models.add(&model, grids.as_mut().and_then(Iterator::next).as_ref())?;
        }
        let soil = GroundAndWater::new(forest, &mut models.lookups.words);
        let ways = Ways { search: settings.search, has_water: forest.water().is_some() };
        let stages = stages::compile(&gpu.device, light.bind_group_layout(), ways);
        let stand = Stand::new(gpu, forest, models.depth)?;
        let statics = Statics::new(gpu, &models)?;
        let scene = statics.group(gpu, &stages, &stand);
        let light_group = light_buffer(gpu, &stages, stand.plants.len())?;
        let view = uniform(gpu, "flb view", &[0; 64]);
        let daylight = uniform(gpu, "flb daylight", &[0; DAYLIGHT_WORDS]);
        let dome = Dome::new(gpu, &stages);
        gpu.check()?;
        Ok(GpuForest {
            gpu: gpu.clone(),
            stages,
            settings,
            around: forest.around(),
            soil,
            statics,
            stand,
            scene,
            light: light.bind_group_layout().clone(),
            lights: light_group,
            neighbours: None,
            view,
            daylight,
            dome,
            sent_view: None,
            taken: None,
            show: Show::Picture,
        })
    }

    /// Sends other instances of the same species: those of `forest`, after [`Forest::set_instances`]. What was traced
    /// is forgotten, and so is their shade. Ground and water have to be the same.
    ///
    /// # Errors
    /// As [`GpuForest::new`]; the old instances stand then.
    pub fn set_instances(&mut self, forest: &Forest<'_>) -> Result<(), ForestError> {
        let stand = Stand::new(&self.gpu, forest, self.statics.depth)?;
        self.lights = light_buffer(&self.gpu, &self.stages, stand.plants.len())?;
        self.scene = self.statics.group(&self.gpu, &self.stages, &stand);
        self.stand = stand;
        self.around = forest.around();
        (self.taken, self.sent_view) = (None, None);
        self.neighbours.iter_mut().for_each(Neighbours::forget);
        Ok(self.gpu.check()?)
    }

    /// Sets what plants do to each other's light from the next relight on, until the next call: scene light under the
    /// sun of that relight, for the plants of the forest by their numbers; or nothing. It touches the light of files
    /// alone, not [`crate::LightSource::Even`].
    ///
    /// # Errors
    /// [`ForestError::Neighbours`] for another number of plants, which changes nothing; [`ForestError::TooLarge`],
    /// [`ForestError::Device`]: they do nothing then.
    pub fn set_scene_light(&mut self, shade: Option<&SceneLightAtSun<'_>>) -> Result<(), ForestError> {
        match shade {
            Some(shade) => {
                let new = || Neighbours::new(&self.gpu, &self.light, [&self.stages.frame, &self.stages.rays]);
                let neighbours = self.neighbours.get_or_insert_with(new);
                neighbours.send(&self.gpu, &shade.flat(), &self.stand.numbers, &self.lights.0)?;
            }
            None => self.neighbours.iter_mut().for_each(Neighbours::forget),
        }
        Ok(self.gpu.check()?)
    }

    /// Sets what the next relight shows.
    pub fn set_show(&mut self, show: Show) {
        self.show = show;
    }

    /// Finds what every ray of a picture meets first. Fragments stay on the GPU for any number of
    /// [`GpuForest::relight`].
    ///
    /// # Errors
    /// [`ForestError::Render`] for a view outside its limits; [`ForestError::TooLarge`]; [`ForestError::Device`].
    pub fn trace(&mut self, view: &View) -> Result<(), ForestError> {
        self.trace_part(view, PictureRect::whole(view))
    }

    /// Finds what the rays of a part of a picture meet first, which [`GpuForest::picture`] then is of.
    ///
    /// # Errors
    /// As [`GpuForest::trace`]; [`ForestError::Render`] for a part that is not within the picture.
    pub fn trace_part(&mut self, view: &View, part: PictureRect) -> Result<(), ForestError> {
        let first = self.send_view(view)?;
        let words = view_words(view, part, &self.stand, &self.soil, first)?;
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::cast_slice(&words));
        let size = [part.width, part.height, view.samples];
        match &mut self.taken {
            Some(taken) if taken.strips.size == size => {
                (taken.view, taken.part, taken.words) = (*view, part, words);
                taken.is_lit = false;
            }
            taken => {
                // Both at once may not fit.
                *taken = None;
                let uniforms = [&self.view, &self.daylight];
                *taken = Some(TracedView::new(
                    &self.gpu,
                    &self.stages,
                    (*view, part, words),
                    uniforms,
                    self.settings,
                )?);
            }
        }
        let Some(taken) = &self.taken else { return Err(ForestError::NotTraced) };
        for strip in &taken.strips.strips {
            for dispatch in &strip.per_ray {
                self.run(&self.stages.trace, taken, &[&self.scene, &strip.rays], *dispatch)?;
            }
        }
        Ok(self.gpu.check()?)
    }

    /// What was traced, for [`GpuForest::take_up`]; as if nothing was traced.
    pub(crate) fn put_aside(&mut self) -> Option<Traced> {
        self.taken.take().map(Traced)
    }

    /// Goes back to what was traced then: to light it, if it is of the view that was traced last and the same
    /// instances; else for its buffers alone.
    pub(crate) fn take_up(&mut self, Traced(taken): Traced) {
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::cast_slice(&taken.words));
        self.taken = Some(taken);
    }

    /// Lights what was traced: shadow rays, light of the sun and of `lights`, sky and ground. The picture is in
    /// [`GpuForest::picture_buffer`] once that is done.
    ///
    /// # Errors
    /// [`ForestError::NotTraced`]; [`ForestError::Render`] for a light or a look outside its limits;
    /// [`ForestError::NoBase`] for a sun that the lights have no light for; [`ForestError::Device`].
    pub fn relight(
        &mut self,
        lights: &mut LightSet,
        lighting: &Lighting,
        look: &Look,
    ) -> Result<(), ForestError> {
        let camera_m = self.camera_m()?;
        self.aim(lights, lighting, look, camera_m)?;
        self.light_aimed(lights.light())
    }

    /// Sends what every part of a picture shares under one light: for [`GpuForest::light_aimed`], of any part that a
    /// camera there sees.
    pub(crate) fn aim(
        &mut self,
        lights: &mut LightSet,
        lighting: &Lighting,
        look: &Look,
        camera_m: [f64; 3],
    ) -> Result<(), ForestError> {
        let scenery = self.scenery(lighting, look, camera_m)?;
        let words = lights.aim(&self.stand.plants, &DaylightOn::new(&scenery, lighting))?;
        self.send_light(&words, (lighting, look), &scenery, camera_m)
    }

    /// Lights the fragments with light that comes over time; `resident` is that of the streamer which `lights` follow.
    ///
    /// # Errors
    /// As [`GpuForest::relight`]; what is missing is no error.
    pub fn relight_streamed(
        &mut self,
        lights: &mut StreamedLights,
        resident: &Resident,
        lighting: &Lighting,
        look: &Look,
    ) -> Result<(), ForestError> {
        let camera_m = self.camera_m()?;
        let scenery = self.scenery(lighting, look, camera_m)?;
        let daylight = DaylightOn::new(&scenery, lighting);
        let words = lights.aim(resident, &self.stand.plants, &daylight)?;
        self.send_light(&words, (lighting, look), &scenery, camera_m)?;
        self.light_aimed(lights.light())
    }

    /// Where the camera of what was traced stands.
    fn camera_m(&self) -> Result<[f64; 3], ForestError> {
        let taken = self.taken.as_ref().ok_or(ForestError::NotTraced)?;
        Ok(taken.view.eye.position_m)
    }

    fn scenery(
        &mut self,
        lighting: &Lighting,
        look: &Look,
        camera_m: [f64; 3],
    ) -> Result<Scenery, ForestError> {
        let scenery = self.around.scenery(lighting, look, camera_m)?;
        if let Some(sky) = lighting.drawn_sky(scenery.sky_strength) {
            self.dome.send(&self.gpu, &self.stages, &sky);
        }
        Ok(scenery)
    }

    fn send_light(
        &mut self,
        words: &Words,
        (lighting, look): (&Lighting, &Look),
        scenery: &Scenery,
        camera_m: [f64; 3],
    ) -> Result<(), ForestError> {
        let cells = self.send_sun_grid(scenery.towards_sun)?;
        self.gpu.queue.write_buffer(&self.lights.0, 0, bytemuck::cast_slice(&words.0));
        let words = self.soil.daylight_words(
            (lighting, look),
            scenery,
            camera_m,
            self.around.units,
            self.show,
            cells,
        );
        self.gpu.queue.write_buffer(&self.daylight, 0, bytemuck::cast_slice(&words));
        Ok(())
    }

    /// Lights what was traced, as [`GpuForest::aim`] said last.
    pub(crate) fn light_aimed(&mut self, light: &GpuLight) -> Result<(), ForestError> {
        let Some(taken) = &self.taken else { return Err(ForestError::NotTraced) };
        let (light_stage, light_group) = self
            .neighbours
            .as_ref()
            .and_then(Neighbours::stage)
            .unwrap_or((&self.stages.light, &self.lights.1));
        for strip in &taken.strips.strips {
            for dispatch in &strip.per_ray {
                let groups = [&self.scene, &strip.rays, self.dome.group()];
                self.run(&self.stages.shade, taken, &groups, *dispatch)?;
            }
            for dispatch in &strip.per_ray {
                let groups = [light_group, &strip.rays, light.bind_group()];
                self.run(light_stage, taken, &groups, *dispatch)?;
            }
            for dispatch in &strip.per_pixel {
                self.run(&self.stages.resolve, taken, &[&taken.picture_group, &strip.rays], *dispatch)?;
            }
        }
        self.gpu.check()?;
        if let Some(taken) = &mut self.taken {
            taken.is_lit = true;
        }
        Ok(())
    }

    /// Waits until all that was asked for is done.
    ///
    /// # Errors
    /// [`ForestError::Device`].
    pub fn wait(&self) -> Result<(), ForestError> {
        Ok(self.gpu.wait()?)
    }

    /// The picture that [`GpuForest::relight`] makes: `[y][x]`, four floats a pixel, linear red, green and blue, and 1.
    /// Another with every other size of a view.
    pub fn picture_buffer(&self) -> Option<&wgpu::Buffer> {
        self.taken.as_ref().map(|taken| &taken.picture)
    }

    /// The picture, brought back.
    ///
    /// # Errors
    /// [`ForestError::NotTraced`] before the first relight; [`ForestError::Render`] for light that is not finite;
    /// [`ForestError::Device`].
    pub fn picture(&self) -> Result<Picture, ForestError> {
        let taken = self.taken.as_ref().filter(|taken| taken.is_lit).ok_or(ForestError::NotTraced)?;
        let bytes = self.gpu.read(&taken.picture)?;
        let values = bytes.as_chunks::<4>().0.iter().map(|value| f32::from_le_bytes(*value));
        let rgb = values.enumerate().filter(|(at, _)| at % 4 != 3).map(|(_, value)| value).collect();
        let (width, height) = (taken.part.width, taken.part.height);
        Ok(if_finite(Picture { width, height, rgb })?)
    }

    /// Reads back the first hit of every ray, `[y][x][sample]`.
    ///
    /// # Errors
    /// [`ForestError::NotTraced`], [`ForestError::Device`].
    pub fn fragments(&self) -> Result<Vec<CameraHit>, ForestError> {
        Ok(self.read()?.into_iter().map(|(met, _)| met).collect())
    }

    /// Reads back the hit of every ray that came to water by way of it, its distance counted from there; in the order
    /// of [`GpuForest::fragments`].
    ///
    /// # Errors
    /// [`ForestError::NotTraced`], [`ForestError::Device`].
    pub fn mirrored(&self) -> Result<Vec<Option<CameraHit>>, ForestError> {
        Ok(self.read()?.into_iter().map(|(_, mirrored)| mirrored).collect())
    }

    fn read(&self) -> Result<Vec<(CameraHit, Option<CameraHit>)>, ForestError> {
        let taken = self.taken.as_ref().ok_or(ForestError::NotTraced)?;
        taken.strips.read(&self.gpu, &self.stand.numbers, &self.statics.numbers)
    }

    /// Memory of the forest, and of fragments and picture, on the GPU.
    pub fn size_bytes(&self) -> [u64; 2] {
        let stand = self.stand.boxes.size() + self.stand.instances.size();
        let taken = self.taken.as_ref().map_or(0, |taken| taken.strips.size_bytes() + taken.picture.size());
        let neighbours = self.neighbours.as_ref().map_or(0, Neighbours::size_bytes);
        [self.statics.size_bytes() + stand + neighbours, taken]
    }

    fn run(
        &self,
        pipeline: &wgpu::ComputePipeline,
        taken: &TracedView,
        groups: &[&wgpu::BindGroup],
        dispatch: Dispatch,
    ) -> Result<(), ForestError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &taken.frame, &[dispatch.offset]);
            for (number, group) in (1..).zip(groups) {
                pass.set_bind_group(number, *group, &[]);
            }
            pass.dispatch_workgroups(dispatch.workgroups, 1, 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
        // Software would gather minutes of work, which no wait could tell from a driver that hangs.
        if self.gpu.is_software { Ok(self.gpu.wait()?) } else { Ok(()) }
    }
}

fn light_buffer(
    gpu: &Gpu,
    stages: &Stages,
    plants: usize,
) -> Result<(wgpu::Buffer, wgpu::BindGroup), ForestError> {
    let buffer = storage(gpu, "lights", &vec![0; plants * LIGHT_WORDS], "with fewer instances")?;
    let group = stages::group(&gpu.device, "flb lights", &stages.lights, &[buffer.as_entire_binding()]);
    Ok((buffer, group))
}

impl TracedView {
    fn new(
        gpu: &Gpu,
        stages: &Stages,
        (view, part, words): (View, PictureRect, Vec<u32>),
        [view_buffer, daylight]: [&wgpu::Buffer; 2],
        settings: ForestSettings,
    ) -> Result<TracedView, ForestError> {
        let size = [part.width, part.height, view.samples];
        let strips = Strips::new(gpu, stages, size, settings.fragment_bytes, settings.rays_per_dispatch)?;
        let strip = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &strips.uniforms,
            offset: 0,
            size: wgpu::BufferSize::new(16),
        });
        let buffers = [view_buffer.as_entire_binding(), daylight.as_entire_binding(), strip];
        let frame = stages::group(&gpu.device, "flb frame", &stages.frame, &buffers);
        let pixels = u64::from(part.width) * u64::from(part.height);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let picture = empty(gpu, "flb picture", pixels * PIXEL_BYTES, usage);
        let picture_group =
            stages::group(&gpu.device, "flb picture", &stages.picture, &[picture.as_entire_binding()]);
        Ok(TracedView { view, part, words, strips, frame, picture, picture_group, is_lit: false })
    }
}
