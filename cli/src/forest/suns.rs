//! The pictures of a scene: under which sun and from where each is taken.

use flb_render::forest::Eye;
use flb_scene::scene::{Camera, Instant, Scene, SunAt, SunHours, Suns, along};

use crate::args::RenderArgs;
use crate::exit::{Failure, USAGE};

/// One picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shot {
    /// Azimuth and elevation, degrees; `None` where an image of the sky alone lights the scene.
    pub sun: Option<[f64; 2]>,
    /// When the sun stands there, where that is known.
    pub instant: Option<Instant>,
    pub eye: Eye,
}

impl Shot {
    /// Its sun, as stages name it.
    pub(super) fn subject(&self) -> String {
        subject_of(self.sun)
    }
}

/// A sun, or none, as stages name it.
pub(crate) fn subject_of(sun: Option<[f64; 2]>) -> String {
    sun.map_or("no sun".to_owned(), |[azimuth, elevation]| format!("sun {azimuth},{elevation}"))
}

/// What the flags and the scene ask for, in order; `needs_sun` unless an image is the sky. Water is not looked through:
/// no shot is taken from below it.
pub(super) fn shots(scene: &Scene, args: &RenderArgs, needs_sun: bool) -> Result<Vec<Shot>, Failure> {
    let shots = all(scene, args, needs_sun)?;
    let Some(water) = &scene.water else { return Ok(shots) };
    match shots.iter().position(|shot| shot.eye.position_m[1] <= water.height_m) {
        None => Ok(shots),
        Some(sunk) => {
            let message = format!(
                "[camera] stands at a height of {} m in picture {} of {}, expected above the [water] at {} m",
                shots[sunk].eye.position_m[1],
                sunk + 1,
                shots.len(),
                water.height_m
            );
            Err(Failure::new(USAGE, message).at(&args.file))
        }
    }
}

fn all(scene: &Scene, args: &RenderArgs, needs_sun: bool) -> Result<Vec<Shot>, Failure> {
    let missing = |what: &str| Err(Failure::new(USAGE, what).at(&args.file));
    let Some(camera) = &scene.camera else {
        return missing("the scene has no [camera], which a picture needs");
    };
    let Some(look_at_m) = &camera.look_at_m else {
        return missing("[camera] has no look_at_m, which a picture needs");
    };
    let course = course(scene, args, needs_sun)?;
    let shot = |share: f64| {
        let (sun, instant) = course.at(share);
        Shot { sun, instant, eye: eye(camera, look_at_m, share) }
    };
    match (args.frames, &course) {
        (Some(frames), _) => {
            let last = f64::from(frames - 1).max(1.0);
            Ok((0..frames).map(|frame| shot(f64::from(frame) / last)).collect())
        }
        (None, Course::Between(suns)) => {
            let suns = if args.sun.is_empty() { &suns[..1] } else { suns };
            Ok(suns.iter().map(|sun| Shot { sun: Some(*sun), ..shot(0.0) }).collect())
        }
        (None, Course::NoSun) => Ok(vec![shot(0.0)]),
        (None, Course::Hours(_)) => missing(
            "the scene's sun has a path: take --frames N of it, or name one with --sun AZIMUTH,ELEVATION",
        ),
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

/// Of the flags, else of the scene.
fn course<'a>(scene: &'a Scene, args: &'a RenderArgs, needs_sun: bool) -> Result<Course<'a>, Failure> {
    let refuse = |message: String| Failure::new(USAGE, message).at(&args.file);
    match (&args.sun[..], args.sun_path, &scene.suns) {
        ([], Some(hours), _) => Ok(Course::Hours(hours)),
        ([], None, Suns::Fixed(suns)) => Ok(Course::Between(suns)),
        ([], None, Suns::Path(path)) => {
            let hours = SunHours::of_first_day(path);
            hours.map(Course::Hours).map_err(|message| refuse(format!("[sun] path: {message}")))
        }
        ([], None, Suns::Sky) if !needs_sun => Ok(Course::NoSun),
        ([], None, Suns::Sky) => {
            let message =
                "the scene has no suns of its own: name one with --sun AZIMUTH,ELEVATION, or --sun-path";
            Err(refuse(message.to_owned()))
        }
        (suns, _, _) => Ok(Course::Between(suns)),
    }
}

fn eye(camera: &Camera, look_at_m: &[[f64; 3]], share: f64) -> Eye {
    Eye {
        position_m: along(&camera.path_m, share),
        look_at_m: along(look_at_m, share),
        fov_deg: camera.fov_deg,
    }
}
