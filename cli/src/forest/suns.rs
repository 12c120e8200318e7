//! The pictures of a scene: under which sun and from where each is taken.

use flb_baker::scene::{Camera, Scene, Suns, along};
use flb_render::forest::Eye;

use crate::args::RenderArgs;
use crate::exit::{Failure, USAGE};

/// One picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// Azimuth and elevation, degrees.
    pub sun: [f64; 2],
    pub eye: Eye,
}

impl Shot {
    /// Its sun, as stages name it.
    pub fn subject(&self) -> String {
        format!("sun {},{}", self.sun[0], self.sun[1])
    }
}

/// What the flags and the scene ask for, in order.
pub fn shots(scene: &Scene, args: &RenderArgs) -> Result<Vec<Shot>, Failure> {
    let missing = |what: &str| Err(Failure::new(USAGE, what).at(&args.file));
    let Some(camera) = &scene.camera else {
        return missing("the scene has no [camera], which a picture needs");
    };
    let Some(look_at_m) = &camera.look_at_m else {
        return missing("[camera] has no look_at_m, which a picture needs");
    };
    let suns = match (&args.sun[..], &scene.suns) {
        ([], Suns::Fixed(suns)) => &suns[..],
        ([], _) => return missing("the scene has no fixed suns: name one with --sun AZIMUTH,ELEVATION"),
        (suns, _) => suns,
    };
    let Some(frames) = args.frames else {
        let suns = if args.sun.is_empty() { &suns[..1] } else { suns };
        return Ok(suns.iter().map(|sun| Shot { sun: *sun, eye: eye(camera, look_at_m, 0.0) }).collect());
    };
    let last = f64::from(frames - 1).max(1.0);
    Ok((0..frames)
        .map(|frame| {
            let share = f64::from(frame) / last;
            Shot { sun: along(suns, share), eye: eye(camera, look_at_m, share) }
        })
        .collect())
}

fn eye(camera: &Camera, look_at_m: &[[f64; 3]], share: f64) -> Eye {
    Eye {
        position_m: along(&camera.path_m, share),
        look_at_m: along(look_at_m, share),
        fov_deg: camera.fov_deg,
    }
}
