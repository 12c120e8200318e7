//! A window with one plant, lit on the GPU: where a renderer on wgpu begins.
//!
//! `cargo run -p flb-examples --bin plant_in_a_window [FILE.flb] [--seconds N]`; without a file it takes the shrub of
//! the tests, whose light is made up. A real one: `flb grow shrub -o shrub.glb`, `flb bake shrub.glb -o shrub.flb`.
//!
//! Arrow keys move the sun, the space bar turns it off and on. `plant.rs` and `plant.wgsl` are what a
//! renderer does with flb; the rest is a window of winit and a pipeline of wgpu as any.
#![forbid(unsafe_code)]

mod leaves;
mod pipeline;
mod plant;

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

use plant::{Plant, Sun};

const SHRUB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../runtime-loader/golden/shrub.flb");

/// Of the window, before it is resized.
const SIZE: LogicalSize<u32> = LogicalSize::new(640, 480);

/// What a key moves the sun by.
const STEP_DEG: f64 = 15.0;

struct App {
    path: String,
    sun: Sun,
    /// When the window closes by itself.
    close: Option<Instant>,
    open: Option<Open>,
    failed: Option<Box<dyn Error>>,
}

/// A window that is open, and what is drawn into it.
struct Open {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    plant: Plant,
}

impl Open {
    fn new(events: &ActiveEventLoop, path: &str) -> Result<Open, Box<dyn Error>> {
        let wanted = Window::default_attributes().with_title(path).with_inner_size(SIZE);
        let window = Arc::new(events.create_window(wanted)?);
        let display = Box::new(events.owned_display_handle());
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle_from_env(display));
        let surface = instance.create_surface(Arc::clone(&window))?;
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            compatible_surface: Some(&surface),
            ..wgpu::RequestAdapterOptions::default()
        }))?;
        // WebGPU's default limits are enough.
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
        let size = window.inner_size();
        let mut configuration = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or("this GPU cannot draw into windows")?;
        // The shader writes linear light, the texture stores it as sRGB.
        let formats = surface.get_capabilities(&adapter).formats;
        configuration.format =
            formats.into_iter().find(wgpu::TextureFormat::is_srgb).ok_or("no format of sRGB")?;
        surface.configure(&device, &configuration);
        let plant = Plant::new(&device, &queue, configuration.format, path)?;
        Ok(Open { window, surface, configuration, device, queue, plant })
    }

    fn draw(&mut self, sun: Sun) -> Result<(), Box<dyn Error>> {
        use wgpu::CurrentSurfaceTexture::{Occluded, Suboptimal, Success, Timeout};
        let texture = match self.surface.get_current_texture() {
            Success(texture) | Suboptimal(texture) => texture,
            Timeout | Occluded => return Ok(()),
            // The window changed meanwhile.
            _ => {
                self.surface.configure(&self.device, &self.configuration);
                self.window.request_redraw();
                return Ok(());
            }
        };
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.plant.draw(&view, [self.configuration.width, self.configuration.height], sun)?;
        self.window.pre_present_notify();
        self.queue.present(texture);
        Ok(())
    }
}

impl App {
    /// Keeps the first error and ends the loop, whose handlers return none.
    fn check(&mut self, events: &ActiveEventLoop, result: Result<(), Box<dyn Error>>) {
        if let Err(error) = result {
            self.failed.get_or_insert(error);
            events.exit();
        }
    }

    fn press(&mut self, key: &Key) {
        match key {
            Key::Named(NamedKey::ArrowLeft) => self.sun.azimuth_deg -= STEP_DEG,
            Key::Named(NamedKey::ArrowRight) => self.sun.azimuth_deg += STEP_DEG,
            Key::Named(NamedKey::ArrowUp) => self.sun.elevation_deg += STEP_DEG,
            Key::Named(NamedKey::ArrowDown) => self.sun.elevation_deg -= STEP_DEG,
            Key::Named(NamedKey::Space) => self.sun.is_on = !self.sun.is_on,
            _ => return,
        }
        self.sun.elevation_deg = self.sun.elevation_deg.clamp(0.0, 90.0);
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none() {
            let opened = Open::new(events, &self.path).map(|open| self.open = Some(open));
            self.check(events, opened);
        }
    }

    fn new_events(&mut self, events: &ActiveEventLoop, _: winit::event::StartCause) {
        match self.close {
            Some(close) if Instant::now() >= close => events.exit(),
            Some(close) => events.set_control_flow(ControlFlow::WaitUntil(close)),
            None => {}
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::KeyboardInput { event, .. } if event.state.is_pressed() => {
                self.press(&event.logical_key);
            }
            WindowEvent::Resized(size) => {
                let Some(open) = &mut self.open else { return };
                let most = open.device.limits().max_texture_dimension_2d;
                open.configuration.width = size.width.clamp(1, most);
                open.configuration.height = size.height.clamp(1, most);
                open.surface.configure(&open.device, &open.configuration);
                open.window.request_redraw();
            }
            WindowEvent::RedrawRequested => {
                let sun = self.sun;
                let drawn = self.open.as_mut().map_or(Ok(()), |open| open.draw(sun));
                self.check(events, drawn);
            }
            _ => {}
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut path, mut close) = (SHRUB.to_owned(), None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--seconds" => {
                let seconds = words.next().ok_or("--seconds takes a number")?.parse()?;
                close = Instant::now().checked_add(Duration::try_from_secs_f64(seconds)?);
            }
            _ => path = word,
        }
    }
    let sun = Sun { azimuth_deg: 135.0, elevation_deg: 45.0, is_on: true };
    let mut app = App { path, sun, close, open: None, failed: None };
    EventLoop::new()?.run_app(&mut app)?;
    app.failed.map_or(Ok(()), Err)
}
