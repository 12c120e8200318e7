//! Puts picture and panel into a texture: a window's, or one that is read back.

use flb_gpu::Gpu;
use flb_stage::stream::Painted;

use crate::panel::{self, Told};
use crate::{Controls, Show, ViewError};

/// What a screen that is read back is made of: bytes that are sRGB already.
const OFFSCREEN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Screen that draws frames into textures of a GPU.
pub struct Screen {
    gpu: Gpu,
    ui: egui::Context,
    renderer: egui_wgpu::Renderer,
    painted: Option<Painted>,
    texture: Option<egui::TextureHandle>,
    /// What the texture was made for.
    exposure: f32,
    /// Bases of the species that has most.
    pub bases: u16,
    /// Stands over the picture.
    pub message: Option<String>,
}

/// Requests of a frame to its window.
pub struct Drawn {
    /// Cursor, clipboard and the like.
    pub platform: egui::PlatformOutput,
    /// Time to the next frame, if nothing happens.
    pub next: std::time::Duration,
    /// Size of the picture's place.
    pub picture_px: [u32; 2],
}

impl Screen {
    /// Makes a screen for textures of a format.
    pub fn new(gpu: Gpu, format: wgpu::TextureFormat) -> Screen {
        // No dithering, no filtering by hardware: the same picture everywhere.
        let options = egui_wgpu::RendererOptions::PREDICTABLE;
        let renderer = egui_wgpu::Renderer::new(&gpu.device, format, options);
        Screen {
            gpu,
            ui: egui::Context::default(),
            renderer,
            painted: None,
            texture: None,
            exposure: f32::NAN,
            bases: 0,
            message: None,
        }
    }

    /// Makes a screen for [`Screen::shot`].
    pub fn offscreen(gpu: Gpu) -> Screen {
        Screen::new(gpu, OFFSCREEN)
    }

    /// The state of the panel, for who feeds it with a window's events.
    pub fn ui(&self) -> &egui::Context {
        &self.ui
    }

    /// A new picture to be shown from now on.
    pub fn set(&mut self, painted: Painted) {
        self.painted = Some(painted);
        self.exposure = f32::NAN;
    }

    /// Returns the last picture that the screen was given.
    pub fn into_painted(self) -> Option<Painted> {
        self.painted
    }

    /// Draws a frame of a size into a texture, of input, which changes the controls.
    pub fn draw(
        &mut self,
        target: &wgpu::TextureView,
        size_px: [u32; 2],
        input: egui::RawInput,
        controls: &mut Controls,
    ) -> Drawn {
        self.develop(controls);
        let told = Told {
            texture: self.texture.as_ref().map(egui::TextureHandle::id),
            painted: self.painted.as_ref(),
            bases: self.bases,
            message: self.message.as_deref(),
        };
        let mut points = [0.0; 2];
        let output = self.ui.run_ui(input, |ui| points = panel::show(ui, controls, &told));
        let pixels_per_point = output.pixels_per_point;
        let shapes = self.ui.tessellate(output.shapes, pixels_per_point);
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut textures = output.textures_delta;
        for (id, deltas) in textures.set.drain() {
            deltas.iter().for_each(|delta| self.renderer.update_texture(device, queue, id, delta));
        }
        let screen = egui_wgpu::ScreenDescriptor { size_in_pixels: size_px, pixels_per_point };
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut commands = self.renderer.update_buffers(device, queue, &mut encoder, &shapes, &screen);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("flb view"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                resolve_target: None,
                depth_slice: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        self.renderer.render(&mut pass.forget_lifetime(), &shapes, &screen);
        commands.push(encoder.finish());
        queue.submit(commands);
        textures.free.drain().for_each(|id| self.renderer.free_texture(&id));
        let next = output.viewport_output.values().map(|viewport| viewport.repaint_delay).min();
        Drawn {
            platform: output.platform_output,
            next: next.unwrap_or(std::time::Duration::MAX),
            picture_px: points.map(|points| (points * pixels_per_point).max(1.0) as u32),
        }
    }

    /// Makes the texture of the picture anew, where it or the exposure has changed.
    fn develop(&mut self, controls: &Controls) {
        let Some(painted) = &self.painted else { return };
        let is_mark = matches!(painted.shot.show, Show::Level | Show::Residency | Show::Error);
        let exposure = if is_mark { 0.0 } else { controls.exposure };
        if self.exposure == exposure {
            return;
        }
        self.exposure = exposure;
        let size = [painted.picture.width as usize, painted.picture.height as usize];
        let image = egui::ColorImage::from_rgb(size, &painted.picture.tone_mapped(exposure));
        match &mut self.texture {
            Some(texture) => texture.set(image, egui::TextureOptions::LINEAR),
            none => *none = Some(self.ui.load_texture("picture", image, egui::TextureOptions::LINEAR)),
        }
    }

    /// Draws what a window of a size would show: RGB, row 0 on top. Events come first, and are followed by a frame
    /// without any, as a layout is only known once it was made.
    ///
    /// # Errors
    /// [`ViewError::Size`], [`ViewError::Device`].
    pub fn shot(
        &mut self,
        size_px: [u32; 2],
        events: Vec<egui::Event>,
        controls: &mut Controls,
    ) -> Result<(Vec<u8>, Drawn), ViewError> {
        let [width, height] = size_px;
        let most = self.gpu.device.limits().max_texture_dimension_2d;
        if !(1..=most).contains(&width) || !(1..=most).contains(&height) {
            return Err(ViewError::Size { width, height, most });
        }
        let device = &self.gpu.device;
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("flb view"),
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: OFFSCREEN,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("flb view"),
            size: u64::from(row_bytes) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let view = texture.create_view(&Default::default());
        let area = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width as f32, height as f32));
        let input = |events| egui::RawInput {
            screen_rect: Some(area),
            events,
            focused: true,
            ..egui::RawInput::default()
        };
        self.draw(&view, size_px, input(events), controls);
        let drawn = self.draw(&view, size_px, input(Vec::new()), controls);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row_bytes),
                    rows_per_image: None,
                },
            },
            extent,
        );
        self.gpu.queue.submit([encoder.finish()]);
        let bytes = self.gpu.read(&buffer)?;
        let rgb = bytes
            .chunks_exact(row_bytes as usize)
            .flat_map(|row| row[..4 * width as usize].chunks_exact(4))
            .flat_map(|texel| [texel[0], texel[1], texel[2]])
            .collect();
        Ok((rgb, drawn))
    }
}
