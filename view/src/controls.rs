//! Where the camera stands, where the sun does, and what is shown: changed by keys and mouse, known by no window.

use flb_stage::stream::Shot;
use glam::{DQuat, DVec3};

/// Degrees that the camera turns for a pixel of the mouse.
const TURN_DEG_PER_PX: f64 = 0.25;
/// Factor on the distance for a step of the wheel.
const ZOOM: f64 = 1.1;
/// The camera stays so far from straight up and down.
const STEEPEST_DEG: f64 = 89.0;
/// Nearest that it comes to what it looks at.
const NEAREST_M: f64 = 0.05;

/// The state of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct Controls {
    /// Shot that is painted.
    pub shot: Shot,
    /// Exposure, stops.
    pub exposure: f32,
    /// Speed of the sun by itself, degrees of azimuth a second; 0 while it stands.
    pub sun_speed: f64,
    /// Whether the panel is shown.
    pub has_panel: bool,
    /// Where it all began.
    start: Shot,
}

impl Controls {
    /// Makes the controls of a start.
    pub fn new(start: Shot, exposure: f32) -> Controls {
        Controls { shot: start, exposure, sun_speed: 0.0, has_panel: true, start }
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        self.shot = Shot { show: self.shot.show, ..self.start };
    }

    fn position(&self) -> DVec3 {
        self.shot.eye.position_m.into()
    }

    fn target(&self) -> DVec3 {
        self.shot.eye.look_at_m.into()
    }

    /// Turns the camera around what it looks at, by pixels of the mouse to the right and down.
    pub fn orbit(&mut self, [right_px, down_px]: [f64; 2]) {
        let offset = turned(self.position() - self.target(), [-right_px, down_px]);
        self.shot.eye.position_m = (self.target() + offset).to_array();
    }

    /// Turns the camera where it stands.
    pub fn look(&mut self, [right_px, down_px]: [f64; 2]) {
        let forward = turned(self.target() - self.position(), [-right_px, -down_px]);
        self.shot.eye.look_at_m = (self.position() + forward).to_array();
    }

    /// Moves the camera and what it looks at across the picture, as if the picture were held by the mouse.
    pub fn pan(&mut self, [right_px, down_px]: [f64; 2], height_px: f64) {
        let [right, up, _] = self.axes();
        let distance = (self.target() - self.position()).length();
        let metres_per_px =
            2.0 * distance * libm::tan(self.shot.eye.fov_deg.to_radians() / 2.0) / height_px.max(1.0);
        self.shift((up * down_px - right * right_px) * metres_per_px);
    }

    /// Goes nearer, or with a negative number of steps farther off.
    pub fn zoom(&mut self, steps: f64) {
        let offset = self.position() - self.target();
        let length = (offset.length() / libm::pow(ZOOM, steps.clamp(-50.0, 50.0))).clamp(NEAREST_M, 1e6);
        self.shot.eye.position_m = (self.target() + offset.normalize_or(DVec3::Z) * length).to_array();
    }

    /// Flies: metres to the right, up and forward.
    pub fn fly(&mut self, [right_m, up_m, forward_m]: [f64; 3]) {
        let [right, _, forward] = self.axes();
        self.shift(right * right_m + DVec3::Y * up_m + forward * forward_m);
    }

    /// Speed of flight, metres a second: the whole distance to what is looked at in two seconds.
    pub fn flying_m_per_s(&self) -> f64 {
        ((self.target() - self.position()).length() / 2.0).max(0.1)
    }

    /// Turns the sun; the azimuth goes round, the elevation stays from -90 to 90.
    pub fn turn_sun(&mut self, [azimuth_deg, elevation_deg]: [f64; 2]) {
        let [azimuth, elevation] = self.shot.sun_deg;
        self.shot.sun_deg =
            [(azimuth + azimuth_deg).rem_euclid(360.0), (elevation + elevation_deg).clamp(-90.0, 90.0)];
    }

    /// Lets time go by.
    pub fn pass(&mut self, seconds: f64) {
        if self.sun_speed != 0.0 {
            self.turn_sun([self.sun_speed * seconds.clamp(0.0, 1.0), 0.0]);
        }
    }

    fn shift(&mut self, by: DVec3) {
        if by.is_finite() {
            self.shot.eye.position_m = (self.position() + by).to_array();
            self.shot.eye.look_at_m = (self.target() + by).to_array();
        }
    }

    /// Right, up and forward.
    fn axes(&self) -> [DVec3; 3] {
        let forward = (self.target() - self.position()).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(DVec3::Y).normalize_or(DVec3::X);
        [right, right.cross(forward), forward]
    }
}

/// Turns an offset about the vertical, and up or down as far as it may.
fn turned(offset: DVec3, [about_px, up_px]: [f64; 2]) -> DVec3 {
    let length = offset.length();
    let level = libm::sqrt(offset.x * offset.x + offset.z * offset.z);
    let elevation_deg = libm::atan2(offset.y, level).to_degrees();
    let azimuth = libm::atan2(offset.x, offset.z) + (about_px * TURN_DEG_PER_PX).to_radians();
    let elevation = (elevation_deg + up_px * TURN_DEG_PER_PX).clamp(-STEEPEST_DEG, STEEPEST_DEG).to_radians();
    let turned = DQuat::from_rotation_y(azimuth) * DQuat::from_rotation_x(-elevation) * DVec3::Z;
    if turned.is_finite() { turned * length } else { offset }
}

#[cfg(test)]
mod tests {
    use flb_format::eye::Eye;
    use flb_stage::stream::Show;

    use super::*;

    fn controls() -> Controls {
        let eye = Eye { position_m: [3.0, 4.0, 12.0], look_at_m: [3.0, 1.0, 2.0], fov_deg: 40.0 };
        Controls::new(Shot { eye, sun_deg: [350.0, 40.0], show: Show::Whole }, 0.0)
    }

    fn distance(controls: &Controls) -> f64 {
        (controls.target() - controls.position()).length()
    }

    #[test]
    fn an_orbit_keeps_what_is_looked_at_and_how_far_it_is() {
        let (start, mut moved) = (controls(), controls());
        moved.orbit([120.0, -40.0]);
        assert_eq!(moved.shot.eye.look_at_m, start.shot.eye.look_at_m);
        assert!((distance(&moved) - distance(&start)).abs() < 1e-9);
        assert!((moved.position() - start.position()).length() > 1.0);
        moved.orbit([-120.0, 40.0]);
        assert!((moved.position() - start.position()).length() < 1e-9, "and back");
        // Dragged to the right, the scene turns to the right: the camera goes to the left.
        moved.orbit([10.0, 0.0]);
        assert!(moved.position().x < start.position().x);
        for _ in 0..1000 {
            moved.orbit([0.0, 7.0]);
        }
        let offset = moved.position() - moved.target();
        let steepest = libm::sin(STEEPEST_DEG.to_radians()) * offset.length();
        assert!((offset.y - steepest).abs() < 1e-9, "it stops short of the zenith: {offset}");
    }

    #[test]
    fn a_look_keeps_where_the_camera_stands() {
        let (start, mut moved) = (controls(), controls());
        moved.look([50.0, 20.0]);
        assert_eq!(moved.shot.eye.position_m, start.shot.eye.position_m);
        assert!((distance(&moved) - distance(&start)).abs() < 1e-9);
        // To the right is east of where it looked (north); down is down.
        assert!(moved.target().x > start.target().x && moved.target().y < start.target().y);
    }

    #[test]
    fn the_wheel_goes_nearer_and_never_through() {
        let mut moved = controls();
        let before = distance(&moved);
        moved.zoom(1.0);
        assert!((distance(&moved) - before / ZOOM).abs() < 1e-9);
        for _ in 0..100 {
            moved.zoom(40.0);
        }
        assert!((distance(&moved) - NEAREST_M).abs() < 1e-9);
        (0..100).for_each(|_| moved.zoom(f64::NEG_INFINITY));
        assert!(distance(&moved) <= 1.000_001e6);
    }

    #[test]
    fn flying_and_panning_move_both_ends_alike() {
        let start = controls();
        for step in [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 3.0]] {
            let mut moved = controls();
            moved.fly(step);
            let by = moved.position() - start.position();
            assert!((by - (moved.target() - start.target())).length() < 1e-9);
            let length: f64 = step.iter().sum();
            assert!((by.length() - length).abs() < 1e-9);
        }
        let mut moved = controls();
        moved.pan([0.0, 240.0], 480.0);
        // Half of the picture's height at that distance, upwards.
        let half = distance(&start) * libm::tan(20f64.to_radians());
        assert!(((moved.position() - start.position()).length() - half).abs() < 1e-9);
        assert!(moved.position().y > start.position().y);
        moved.fly([f64::NAN, 0.0, 0.0]);
        assert!(moved.position().is_finite());
    }

    #[test]
    fn the_sun_goes_round_and_stays_between_the_poles() {
        let mut turned = controls();
        turned.turn_sun([20.0, 80.0]);
        assert_eq!(turned.shot.sun_deg, [10.0, 90.0]);
        turned.sun_speed = -30.0;
        turned.pass(0.5);
        assert_eq!(turned.shot.sun_deg, [355.0, 90.0]);
        turned.shot.show = Show::Level;
        turned.reset();
        assert_eq!(turned.shot, Shot { show: Show::Level, ..controls().shot });
    }
}
