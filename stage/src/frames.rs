//! The frames of a scene: from where and under which sun each is taken.

use flb_format::eye::Eye;
use flb_runtime::view::WaterPlane;
use flb_scene::scene::{Camera, Instant, MovingWaves, Scene, SunAt, SunHours, Suns, along};

use crate::StageError;

/// Eye, sun and time of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneFrame {
    /// Position and direction of the camera.
    pub eye: Eye,
    /// Azimuth and elevation of the sun, degrees; `None` where an image of the sky alone lights the scene.
    pub sun_deg: Option<[f64; 2]>,
    /// Time at which the sun stands there, where that is known.
    pub instant: Option<Instant>,
    /// Time of the waves on water, seconds.
    pub time_s: f64,
}

/// Suns, hours and number of the frames that are taken; what is empty or `None` is as the scene has it.
#[derive(Debug, Clone, Default)]
pub struct FrameSettings {
    /// Azimuths and elevations of suns, degrees, in place of the scene's.
    pub suns_deg: Vec<[f64; 2]>,
    /// Hours of a day that the sun goes through, in place of the scene's.
    pub sun_path: Option<SunHours>,
    /// Frames along the paths of camera and sun; `None`: one for each sun that was named, from where the camera's path
    /// begins, else one under the scene's first sun.
    pub count: Option<u32>,
    /// Whether a scene without a sun is refused.
    pub needs_sun: bool,
}

/// The water of a scene, as it counts what may be mirrored: waves turn it by twice their own slope, and slopes of more
/// than 2.5 standard deviations along an axis are rare.
pub fn water_plane(scene: &Scene) -> Option<WaterPlane> {
    let water = scene.water.as_ref()?;
    let of_waves = |moving: MovingWaves| 2.0 * 2.5 * moving.waves.rms_slope() / 2f64.sqrt();
    let spread_deg = water.waves.map_or(0.0, of_waves).to_degrees().min(90.0) as f32;
    Some(WaterPlane { height_m: water.height_m as f32, spread_deg })
}

/// A sun, or none, as steps name it.
pub(crate) fn subject(sun_deg: Option<[f64; 2]>) -> String {
    sun_deg.map_or("no sun".to_owned(), |[azimuth, elevation]| format!("sun {azimuth},{elevation}"))
}

/// The frames of a scene, in order. Water is not looked through: no frame is taken from below it.
///
/// # Errors
/// [`StageError::Scene`] for a scene that lacks what frames need, or whose camera stands under water.
pub fn frames(scene: &Scene, settings: &FrameSettings) -> Result<Vec<SceneFrame>, StageError> {
    let mut frames = all(scene, settings)?;
    let Some(water) = &scene.water else { return Ok(frames) };
    let step_s = water.waves.map_or(0.0, |waves| waves.step_s);
    frames.iter_mut().zip(0..).for_each(|(frame, number)| frame.time_s += f64::from(number) * step_s);
    match frames.iter().position(|frame| frame.eye.position_m[1] <= water.height_m) {
        None => Ok(frames),
        Some(sunk) => Err(StageError::Scene(format!(
            "[camera] stands at a height of {} m in picture {} of {}, expected above the [water] at {} m",
            frames[sunk].eye.position_m[1],
            sunk + 1,
            frames.len(),
            water.height_m
        ))),
    }
}

fn all(scene: &Scene, settings: &FrameSettings) -> Result<Vec<SceneFrame>, StageError> {
    let path = FramePath::of(scene, settings)?;
    match (settings.count, &path.course) {
        (Some(count), _) => {
            let last = f64::from(count.max(1) - 1).max(1.0);
            Ok((0..count).map(|number| path.at(f64::from(number) / last)).collect())
        }
        (None, Course::Between(suns)) => {
            let count = if settings.suns_deg.is_empty() { 1 } else { suns.len() };
            let suns = suns.iter().take(count);
            Ok(suns.map(|sun_deg| SceneFrame { sun_deg: Some(*sun_deg), ..path.at(0.0) }).collect())
        }
        (None, Course::NoSun) => Ok(vec![path.at(0.0)]),
        (None, Course::Hours(_)) => Err(StageError::WholeSunPath),
    }
}

/// Paths of camera and sun from the first frame to the last.
pub struct FramePath<'a> {
    camera: &'a Camera,
    look_at_m: &'a [[f64; 3]],
    course: Course<'a>,
    /// Of the first frame.
    time_s: f64,
}

impl<'a> FramePath<'a> {
    /// Reads the paths of a scene; the number of frames does not count.
    ///
    /// # Errors
    /// [`StageError::Scene`] without a camera that looks at something, [`StageError::NoSun`].
    pub fn of(scene: &'a Scene, settings: &'a FrameSettings) -> Result<FramePath<'a>, StageError> {
        let missing = |what: &str| Err(StageError::Scene(what.to_owned()));
        let Some(camera) = &scene.camera else {
            return missing("the scene has no [camera], which a picture needs");
        };
        let Some(look_at_m) = &camera.look_at_m else {
            return missing("[camera] has no look_at_m, which a picture needs");
        };
        Ok(FramePath { camera, look_at_m, course: course(scene, settings)?, time_s: scene.start_s() })
    }

    /// The frame at a share of the way, 0..=1.
    pub fn at(&self, share: f64) -> SceneFrame {
        let (sun_deg, instant) = self.course.at(share);
        let eye = Eye {
            position_m: along(&self.camera.path_m, share),
            look_at_m: along(self.look_at_m, share),
            fov_deg: self.camera.fov_deg,
        };
        SceneFrame { eye, sun_deg, instant, time_s: self.time_s }
    }
}

/// How the sun goes.
enum Course<'a> {
    /// From each of these to the next; not none.
    Between(&'a [[f64; 2]]),
    Hours(SunHours),
    NoSun,
}

impl Course<'_> {
    fn at(&self, share: f64) -> (Option<[f64; 2]>, Option<Instant>) {
        match self {
            Course::Between(suns) => (Some(along(suns, share)), None),
            Course::NoSun => (None, None),
            Course::Hours(hours) => {
                let SunAt { instant, sun_deg } = hours.at(share);
                (Some(sun_deg), Some(instant))
            }
        }
    }
}

/// Of the settings, else of the scene.
fn course<'a>(scene: &'a Scene, settings: &'a FrameSettings) -> Result<Course<'a>, StageError> {
    match (&settings.suns_deg[..], settings.sun_path, &scene.suns) {
        ([], Some(hours), _) => Ok(Course::Hours(hours)),
        ([], None, Suns::Fixed(suns)) if suns.is_empty() => Err(StageError::NoSun),
        ([], None, Suns::Fixed(suns)) => Ok(Course::Between(suns)),
        ([], None, Suns::Path(path)) => {
            let hours = SunHours::of_first_day(path);
            hours.map(Course::Hours).map_err(|message| StageError::Scene(format!("[sun] path: {message}")))
        }
        ([], None, Suns::Sky) if !settings.needs_sun => Ok(Course::NoSun),
        ([], None, Suns::Sky) => Err(StageError::NoSun),
        (suns, _, _) => Ok(Course::Between(suns)),
    }
}

#[cfg(test)]
mod tests {
    use flb_scene::scene::Water;
    use flb_scene::waves::Waves;

    use super::*;
    use crate::tests::stand;

    fn over(waves: Option<MovingWaves>) -> Scene {
        let ground = None;
        let water = Some(Water { height_m: 0.25, color: [0.1; 3], waves });
        Scene { ground, water, ..stand().scene }
    }

    #[test]
    fn waves_move_from_frame_to_frame_and_turn_what_is_mirrored() {
        let times = |waves: Option<MovingWaves>| -> Vec<f64> {
            let settings = FrameSettings { count: Some(3), ..FrameSettings::default() };
            let frames = frames(&over(waves), &settings).expect("camera and sun");
            frames.iter().map(|frame| frame.time_s).collect()
        };
        let moving = |step_s| Some(MovingWaves { waves: Waves::default(), time_s: 4.0, step_s });
        assert_eq!(times(None), [0.0; 3]);
        assert_eq!(times(moving(0.0)), [4.0; 3]);
        assert_eq!(times(moving(-0.5)), [4.0, 3.5, 3.0]);
        let spread = |waves| water_plane(&over(waves)).expect("it has water").spread_deg;
        assert_eq!(spread(None), 0.0);
        let [breeze, wind] = [3.0, 12.0].map(|wind_m_s| {
            let waves = Waves { wind_m_s, ..Waves::default() };
            spread(Some(MovingWaves { waves, time_s: 0.0, step_s: 0.0 }))
        });
        assert!(10.0 < breeze && breeze < wind && wind < 90.0, "{breeze} and {wind} degrees");
        assert_eq!(water_plane(&stand().scene), None);
    }
}
