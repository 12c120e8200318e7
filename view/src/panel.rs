//! What a user sees and turns: the picture, which mouse and keys move, and a panel beside it.

use egui::{Key, PointerButton, Sense, Slider, Ui};

use crate::{Controls, Show};
use flb_stage::stream::Painted;

/// Width of the panel, points.
const WIDTH: f32 = 250.0;
/// Degrees that the sun's keys turn it in a second.
const SUN_DEG_PER_S: f64 = 30.0;
/// Points of scrolling that are a step of the wheel.
const STEP_POINTS: f64 = 40.0;
/// Times as fast with shift.
const FAST: f64 = 4.0;

/// What the panel tells.
pub(crate) struct Told<'t> {
    /// The picture's texture and size in texels, once there is one.
    pub texture: Option<egui::TextureId>,
    /// Result of the last painting.
    pub painted: Option<&'t Painted>,
    /// Bases of the species that has most.
    pub bases: u16,
    /// A message that stands over the picture, as an error.
    pub message: Option<&'t str>,
}

/// Lays out a frame and lets it change the controls. Gives back the size of the picture's place in points.
pub(crate) fn show(ui: &mut Ui, controls: &mut Controls, told: &Told) -> [f32; 2] {
    keys(ui, controls);
    if controls.has_panel {
        egui::Panel::right("flb").resizable(false).exact_size(WIDTH).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| panel(ui, controls, told));
        });
    }
    let central = egui::CentralPanel::default().frame(egui::Frame::NONE.fill(egui::Color32::BLACK));
    central.show(ui, |ui| picture(ui, controls, told)).inner
}

fn picture(ui: &mut Ui, controls: &mut Controls, told: &Told) -> [f32; 2] {
    let area = ui.max_rect();
    let response = ui.interact(area, ui.scope_id().with("picture"), Sense::click_and_drag());
    if let Some(texture) = told.texture {
        let whole = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
        ui.painter().image(texture, area, whole, egui::Color32::WHITE);
    }
    if let Some(message) = told.message {
        let place = area.center();
        let font = egui::FontId::proportional(16.0);
        ui.painter().text(place, egui::Align2::CENTER_CENTER, message, font, egui::Color32::LIGHT_RED);
    }
    let drag = response.drag_delta();
    let drag = [f64::from(drag.x), f64::from(drag.y)];
    let is_shifted = ui.input(|input| input.modifiers.shift);
    if response.dragged_by(PointerButton::Primary) && !is_shifted {
        controls.orbit(drag);
    } else if response.dragged_by(PointerButton::Secondary) {
        controls.look(drag);
    } else if response.dragged_by(PointerButton::Middle) || response.dragged_by(PointerButton::Primary) {
        controls.pan(drag, f64::from(area.height()));
    }
    if response.hovered() {
        let scrolled = ui.input(|input| input.smooth_scroll_delta.y);
        if scrolled != 0.0 {
            controls.zoom(f64::from(scrolled) / STEP_POINTS);
        }
    }
    area.size().into()
}

/// Keys that are held down or were pressed, unless a text field has them.
fn keys(ui: &mut Ui, controls: &mut Controls) {
    if ui.ctx().egui_wants_keyboard_input() {
        return;
    }
    let (seconds, is_fast) = ui.input(|input| (f64::from(input.stable_dt).min(0.1), input.modifiers.shift));
    let factor = seconds * if is_fast { FAST } else { 1.0 };
    let axis = |ui: &Ui, less: Key, more: Key| {
        ui.input(|input| f64::from(i8::from(input.key_down(more)) - i8::from(input.key_down(less))))
    };
    let flown = [axis(ui, Key::A, Key::D), axis(ui, Key::Q, Key::E), axis(ui, Key::S, Key::W)];
    let sun = [axis(ui, Key::ArrowLeft, Key::ArrowRight), axis(ui, Key::ArrowDown, Key::ArrowUp)];
    if flown != [0.0; 3] {
        let metres = controls.flying_m_per_s() * factor;
        controls.fly(flown.map(|way| way * metres));
        ui.ctx().request_repaint();
    }
    if sun != [0.0; 2] {
        controls.turn_sun(sun.map(|way| way * SUN_DEG_PER_S * factor));
        ui.ctx().request_repaint();
    }
    if controls.sun_speed != 0.0 {
        controls.pass(seconds);
        ui.ctx().request_repaint();
    }
    let pressed = |key| ui.input(|input| input.key_pressed(key));
    let shows = [
        (Key::Num1, Show::Whole),
        (Key::Num2, Show::Indirect),
        (Key::Num3, Show::Direct),
        (Key::Num4, Show::Base(0)),
        (Key::Num5, Show::Level),
        (Key::Num6, Show::Residency),
        (Key::Num7, Show::Error),
    ];
    if let Some((_, show)) = shows.into_iter().find(|(key, _)| pressed(*key)) {
        controls.shot.show = show;
    }
    if pressed(Key::R) {
        controls.reset();
    }
    if pressed(Key::Tab) || pressed(Key::H) {
        controls.has_panel = !controls.has_panel;
    }
    if pressed(Key::Space) {
        controls.sun_speed = if controls.sun_speed == 0.0 { 10.0 } else { 0.0 };
    }
}

fn panel(ui: &mut Ui, controls: &mut Controls, told: &Told) {
    ui.add_space(6.0);
    ui.heading("Sun");
    let [azimuth, elevation] = &mut controls.shot.sun_deg;
    ui.add(Slider::new(azimuth, 0.0..=360.0).suffix("°").fixed_decimals(1).text("azimuth"));
    ui.add(Slider::new(elevation, -10.0..=90.0).suffix("°").fixed_decimals(1).text("elevation"));
    ui.add(Slider::new(&mut controls.sun_speed, -60.0..=60.0).suffix("°/s").fixed_decimals(0).text("moves"));
    ui.separator();
    ui.heading("Picture");
    ui.add(Slider::new(&mut controls.exposure, -8.0..=8.0).suffix(" EV").fixed_decimals(1).text("exposure"));
    let base = if let Show::Base(base) = controls.shot.show { base } else { 0 };
    for (show, name) in [
        (Show::Whole, "all light (1)"),
        (Show::Indirect, "indirect only (2)"),
        (Show::Direct, "direct only (3)"),
        (Show::Base(base), "one base (4)"),
        (Show::Level, "level (5)"),
        (Show::Residency, "residency (6)"),
        (Show::Error, "error (7)"),
    ] {
        ui.radio_value(&mut controls.shot.show, show, name);
    }
    if let Show::Base(base) = &mut controls.shot.show {
        ui.add(Slider::new(base, 0..=told.bases.saturating_sub(1)).text("base"));
    }
    ui.separator();
    ui.heading("Light");
    if let Some(painted) = told.painted {
        progress(ui, painted);
    }
    ui.separator();
    ui.small("drag: orbit, right: look, middle or shift: pan, wheel: zoom");
    ui.small("W A S D Q E: fly, shift: faster");
    ui.small("arrows: sun, space: let it go round");
    ui.small("R: back to the start, H: this panel");
}

fn progress(ui: &mut Ui, painted: &Painted) {
    let progress = &painted.progress;
    let megabytes = |bytes: u64| bytes as f64 / 1e6;
    ui.add(egui::ProgressBar::new(progress.quality.clamp(0.0, 1.0)).show_percentage());
    ui.label(format!(
        "{:.1} of {:.0} MB{}",
        megabytes(progress.loaded_bytes),
        megabytes(progress.budget_bytes),
        if progress.is_final { "" } else { ", loading" }
    ));
    let Painted { picture, samples, seconds, .. } = painted;
    ui.label(format!("{} x {}, {samples} rays a pixel", picture.width, picture.height));
    ui.label(format!("trace {:.2} s, light {:.2} s", seconds[0], seconds[1]));
    for failure in progress.failures.iter().chain(&progress.lacks) {
        ui.colored_label(egui::Color32::LIGHT_RED, failure);
    }
}
