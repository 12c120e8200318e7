//! The window: events in, frames out, and the painter at work on a thread of its own.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use flb_gpu::Gpu;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use crate::screen::Screen;
use crate::{Controls, Shot, ViewError};
use flb_stage::stream::{Painted, Painter};

/// The first picture after something moved has so many times fewer pixels along each edge.
const DRAFT: u32 = 4;
/// How long nothing must have moved before a picture gets its full size.
const REST: Duration = Duration::from_millis(120);
/// How often a picture is painted anew while light is coming.
const COMING: Duration = Duration::from_millis(150);

/// What the painter is to paint.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Order {
    shot: Shot,
    size: [u32; 2],
}

/// Between the window and the painter.
#[derive(Default)]
struct Desk {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    order: Option<Order>,
    done: Option<Result<Painted, ViewError>>,
    is_over: bool,
}

impl Desk {
    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn order(&self, order: Order) {
        let mut state = self.state();
        if state.order != Some(order) {
            state.order = Some(order);
            self.changed.notify_all();
        }
    }

    fn end(&self) {
        self.state().is_over = true;
        self.changed.notify_all();
    }

    /// The order of now, after so long at most, or at once if it is another than `last`; nothing at the end.
    fn wait(&self, last: Option<Order>, most: Option<Duration>) -> Option<Order> {
        let end = most.map(|most| Instant::now() + most);
        let mut state = self.state();
        loop {
            if state.is_over {
                return None;
            }
            let left = end.map(|end| end.saturating_duration_since(Instant::now()));
            match state.order {
                Some(order) if Some(order) != last || left == Some(Duration::ZERO) => return Some(order),
                _ => {}
            }
            state = match left.filter(|_| last.is_some()) {
                Some(left) => {
                    self.changed.wait_timeout(state, left).map_or_else(|e| e.into_inner().0, |s| s.0)
                }
                None => self.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }
}

/// Paints orders until the end: first a draft, then in full, then again while light is coming.
fn paint(painter: &mut Painter, samples: u32, desk: &Desk, tell: &(dyn Fn() + Sync)) {
    let mut last: Option<Order> = None;
    // 0: a draft is there; 1: one ray a pixel; 2: all rays.
    let mut step = 0;
    let mut most = None;
    while let Some(order) = desk.wait(last, most) {
        step = if last == Some(order) { step + 1 } else { 0 };
        last = Some(order);
        let [width, height] = order.size;
        let (size, rays) = match step {
            0 => ([width.div_ceil(DRAFT), height.div_ceil(DRAFT)], 1),
            1 => (order.size, 1),
            _ => (order.size, samples),
        };
        let painted = painter.paint(&order.shot, size, rays).map_err(ViewError::from);
        let is_final = painted.as_ref().is_ok_and(|painted| painted.progress.is_final);
        most = match step {
            0 => Some(REST),
            1 => Some(Duration::ZERO),
            _ if is_final || painted.is_err() => None,
            _ => Some(COMING),
        };
        desk.state().done = Some(painted);
        tell();
    }
}

/// Opens a window on a scene, and comes back when it is closed, or by itself after a while: with the last picture that
/// it showed.
///
/// # Errors
/// [`ViewError::Window`] where there is none to be had; [`ViewError::Device`]; what the painter met.
pub fn run(
    title: &str,
    size_px: [u32; 2],
    samples: u32,
    close: Option<Duration>,
    controls: Controls,
    mut painter: Painter,
) -> Result<Option<Painted>, ViewError> {
    let refuse = |error: &dyn std::error::Error| ViewError::Window(error.to_string());
    let events = EventLoop::<()>::with_user_event().build().map_err(|error| refuse(&error))?;
    let proxy = events.create_proxy();
    let desk = Desk::default();
    let mut app = App {
        title: title.to_owned(),
        size_px,
        controls,
        bases: painter.bases(),
        desk: &desk,
        open: None,
        close: close.map(|close| Instant::now() + close),
        error: None,
    };
    std::thread::scope(|scope| {
        let ring = Ring(Mutex::new(proxy));
        let desk = &desk;
        scope.spawn(move || paint(&mut painter, samples, desk, &|| ring.ring()));
        let ran = events.run_app(&mut app);
        desk.end();
        let ran = app.error.take().map_or(ran.map_err(|error| refuse(&error)), Err);
        ran.map(|()| app.open.take().and_then(|open| open.screen.into_painted()))
    })
}

/// Wakes the window.
struct Ring(Mutex<EventLoopProxy<()>>);

impl Ring {
    fn ring(&self) {
        // A window that is gone needs not be woken.
        let _ = self.0.lock().unwrap_or_else(PoisonError::into_inner).send_event(());
    }
}

struct App<'d> {
    title: String,
    size_px: [u32; 2],
    controls: Controls,
    bases: u16,
    desk: &'d Desk,
    open: Option<Open>,
    /// When it closes by itself.
    close: Option<Instant>,
    error: Option<ViewError>,
}

/// A window that is open.
struct Open {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    gpu: Gpu,
    input: egui_winit::State,
    screen: Screen,
}

impl Open {
    fn new(events: &ActiveEventLoop, title: &str, [width, height]: [u32; 2]) -> Result<Open, ViewError> {
        let refuse = |error: &dyn std::error::Error| ViewError::Window(error.to_string());
        let attributes =
            Window::default_attributes().with_title(title).with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(events.create_window(attributes).map_err(|error| refuse(&error))?);
        let display = Box::new(events.owned_display_handle());
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle_from_env(display);
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance.create_surface(Arc::clone(&window)).map_err(|error| refuse(&error))?;
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..wgpu::RequestAdapterOptions::default()
        }))
        .map_err(|error| refuse(&error))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))
            .map_err(|error| refuse(&error))?;
        let gpu = Gpu::adopt(&adapter, device, queue);
        let size = window.inner_size();
        let configuration = surface.get_default_config(&adapter, size.width.max(1), size.height.max(1));
        let mut configuration = configuration
            .ok_or_else(|| ViewError::Window(format!("{} cannot draw into windows", gpu.name)))?;
        // The picture's bytes are sRGB already.
        configuration.format = configuration.format.remove_srgb_suffix();
        surface.configure(&gpu.device, &configuration);
        let screen = Screen::new(gpu.clone(), configuration.format);
        let input = egui_winit::State::new(
            screen.ui().clone(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            None,
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        Ok(Open { window, surface, configuration, gpu, input, screen })
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        let most = self.gpu.device.limits().max_texture_dimension_2d;
        (self.configuration.width, self.configuration.height) =
            (size.width.clamp(1, most), size.height.clamp(1, most));
        self.surface.configure(&self.gpu.device, &self.configuration);
        self.window.request_redraw();
    }

    /// A frame; tells how large its picture is and when the next one is due.
    fn draw(&mut self, controls: &mut Controls) -> Result<Option<([u32; 2], Duration)>, ViewError> {
        self.gpu.check()?;
        let texture = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) => texture,
            wgpu::CurrentSurfaceTexture::Suboptimal(texture) => texture,
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Occluded => return Ok(None),
            _ => {
                self.surface.configure(&self.gpu.device, &self.configuration);
                self.window.request_redraw();
                return Ok(None);
            }
        };
        let view = texture.texture.create_view(&Default::default());
        let input = self.input.take_egui_input(&self.window);
        let size = [self.configuration.width, self.configuration.height];
        let drawn = self.screen.draw(&view, size, input, controls);
        self.window.pre_present_notify();
        self.gpu.queue.present(texture);
        self.input.handle_platform_output(&self.window, drawn.platform);
        Ok(Some((drawn.picture_px, drawn.next)))
    }
}

impl App<'_> {
    fn fail(&mut self, events: &ActiveEventLoop, error: ViewError) {
        self.error.get_or_insert(error);
        events.exit();
    }

    /// Takes what was painted.
    fn take(&mut self) {
        let done = self.desk.state().done.take();
        let (Some(open), Some(done)) = (&mut self.open, done) else { return };
        open.screen.message = None;
        match done {
            Ok(painted) => open.screen.set(painted),
            Err(error) => open.screen.message = Some(error.to_string()),
        }
        open.window.request_redraw();
    }

    fn frame(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        match open.draw(&mut self.controls) {
            Ok(None) => {}
            Ok(Some((size, next))) => {
                self.desk.order(Order { shot: self.controls.shot, size });
                if next.is_zero() {
                    open.window.request_redraw();
                }
                let next = Instant::now().checked_add(next);
                events.set_control_flow(match next.into_iter().chain(self.close).min() {
                    Some(then) => ControlFlow::WaitUntil(then),
                    None => ControlFlow::Wait,
                });
            }
            Err(error) => self.fail(events, error),
        }
    }
}

impl ApplicationHandler<()> for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match Open::new(events, &self.title, self.size_px) {
            Ok(mut open) => {
                open.screen.bases = self.bases;
                open.window.request_redraw();
                self.open = Some(open);
            }
            Err(error) => self.fail(events, error),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, (): ()) {
        self.take();
    }

    fn new_events(&mut self, events: &ActiveEventLoop, cause: winit::event::StartCause) {
        if self.close.is_some_and(|close| Instant::now() >= close) {
            events.exit();
        }
        if let (winit::event::StartCause::ResumeTimeReached { .. }, Some(open)) = (cause, &self.open) {
            open.window.request_redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let response = open.input.on_window_event(&open.window, &event);
        if response.repaint {
            open.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => open.resize(size),
            WindowEvent::RedrawRequested => self.frame(events),
            _ => {}
        }
    }
}
