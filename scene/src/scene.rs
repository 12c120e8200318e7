//! A scene: which plants stand where and how they are turned, under which suns, seen from where.
//!
//! ```toml
//! bands = ["R", "G", "B"]        # default: all that the species have
//! light = "forest.flb"           # what `flb bake-scene` made of this scene; default: plants do not know of each other
//!
//! [sky]
//! ambient = 0.02                 # factor on the ambient base; 0: no ambient light; this is the default, of `physical`
//!                                # species 0.36
//! # clear = { turbidity = 3.0 }  # blue, with the colours of its sun, ambient times as bright (default: 1); or
//! # image = "sky.hdr"            # of the whole sphere, .exr or .hdr, relative to this file, of the fluence `ambient`
//! # backdrop = "clouds.exr"      # an image that is drawn in its place, and lights nothing
//!
//! [sun]                          # default: every sun above the horizon; else one of
//! fixed = [[135.0, 40.0]]        # azimuth and elevation, degrees, as `flb render --sun`
//! # path = { latitude_deg = 52.5, longitude_deg = 13.4, from = 2026-06-01, to = 2026-08-31 }  # whole days;
//!                                # `flb render --frames` takes the first from sunrise to sunset
//! # irradiance = [1.0, 0.9, 0.7] # R, G, B, or one number for all; 1 is the default
//! # added = [{ at = [250.0, 20.0], irradiance = 0.1 }]  # further suns in the same picture, which stand still
//!
//! [camera]                       # default: none; then no lattice is chosen
//! position_m = [0.0, 1.7, 12.0]  # or path_m = [[...], [...]]: straight lines between these
//! fov_deg = 40.0                 # vertical
//! height_px = 1080               # of the picture
//! pixels_per_site = 4.0          # most pixels that a site may cover; this is the default
//! look_at_m = [0.0, 5.0, 0.0]    # default: none; a plan does without, a picture does not
//! # look_at_path_m = [[...], [...]]: a point for each of path_m, straight lines between these
//!
//! [ground]                       # default: none
//! height_m = 0.0                 # a plane without end; this is the default
//! colour = [0.23, 0.22, 0.15]    # linear reflectance, R, G, B; this is the default
//! # height_map = "hills.png"     # in place of the plane: a grey PNG, 8 or 16 bits, relative to this file
//! # origin_m = [-50.0, 0.0, -50.0]  # where the middle of its upper left pixel stands; columns run to +X, rows to +Z
//! # size_m = [100.0, 100.0]      # from there to the middle of the lower right one
//! # height_m = [0.0, 8.0]        # of black and of white, above origin_m
//!
//! [water]                        # default: none
//! height_m = 0.6                 # a surface without end, hidden where ground is higher; cameras stand above
//! colour = [0.01, 0.035, 0.04]   # share of the light within it that comes out again, R, G, B; this is the default
//! # waves = { wind_m_s = 3.0 }   # default: level; see [`crate::waves::Waves`]. Beside the wind, with their defaults:
//! #                              # from_deg = 270.0, fetch_m = 300.0, steepness = 1.0, seed = 1, time_s = 0.0 and
//! #                              # step_s = 0.0, from one picture to the next
//!
//! [highlight]                    # of `paper` species: strength k and exponent s of the sun's k (v.r)^s
//! leaf = [0.08, 6.0]             # this is the default
//! wood = [0.0, 1.0]              # none; this is the default, of water too
//! water = [0.0, 1.0]
//!
//! [[species]]
//! name = "oak"
//! file = "oak.glb"               # mesh, or .flb; a plan uses its size alone, and only with a camera
//! gltf_mesh = "Oak"              # the one mesh of a glTF file, by name or as "#3"; default: all of the file
//! species_file = "oak.toml"      # default: none
//! light = "oak.flb"              # library with its baked light; default: none, for a picture without
//! light_species = "oak"          # name in that library; default: the name above
//! upright = false                # true: any instance may turn freely about the vertical
//!
//! [[instance]]
//! species = "oak"
//! position_m = [3.0, 0.0, -4.0]
//! yaw_deg = 30.0                 # clockwise seen from above, as azimuth; or rotation = [x, y, z, w]
//! scale = 1.0
//! ```
//!
//! At most 64 MiB and 2^20 instances. Instances are read one by one, whether as tables or as the elements of one
//! top-level `instance = [...]`; what is beside them, and each of them, has at most 8 MiB and 262,144 words and signs
//! of TOML.

mod camera;
mod digest;
mod ground;
mod heights;
mod highlight;
mod parts;
mod read;
mod reading;
pub mod scatter;
mod sky;
mod sun;
mod sun_hours;
mod sunlight;
mod syntax;
mod water;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use flb_format::Placement;

use toml::value::Datetime;

pub use crate::import::MAX_SPECIES;
pub use camera::MAX_CAMERA_POINTS;
pub use digest::light_digest;
pub use ground::{Ground, HeightMap, Terrain};
pub use heights::{Grey, Heights, MAX_GREY_BYTES, MAX_GREY_EDGE, MAX_GREY_PIXELS};
pub use highlight::{HIGHLIGHT_EXPONENTS, HighlightChoice, MAX_HIGHLIGHT};
pub(crate) use read::SCALES;
pub use read::{MAX_INSTANCES, MAX_SCENE_BYTES};
pub(crate) use reading::MAX_COORDINATE_M;
pub use sky::SceneSky;
pub use sun::MAX_FIXED_SUNS;
pub use sun_hours::{Instant, SunAt, SunHours};
pub use sunlight::{AddedSun, MAX_ADDED_SUNS, MAX_IRRADIANCE, Sunlight, irradiance};
pub use water::{MovingWaves, Water};

/// A scene whose every value is in its range.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Names of the bands that it is drawn in; `None`: all.
    pub bands: Option<Vec<String>>,
    /// Library of what its plants do to each other's light, a relative path made relative to the scene's folder.
    pub light: Option<PathBuf>,
    /// Factor on the ambient base, or on a clear sky, or fluence of a sky's image; from 0. `None`: what the model of
    /// its species has by default, which is not 0; of a clear sky 1.
    pub ambient: Option<f64>,
    /// Source of the light of the sky.
    pub sky: SceneSky,
    /// Image of a sky that is drawn in its place and lights nothing, a relative path made relative to the scene's
    /// folder.
    pub backdrop: Option<PathBuf>,
    /// Suns that may shine on the scene.
    pub suns: Suns,
    /// Light of each of these suns, and further suns beside it.
    pub sunlight: Sunlight,
    /// Highlights of the sun, on plants of the model `paper` alone.
    pub highlight: HighlightChoice,
    /// Camera that looks at the scene.
    pub camera: Option<Camera>,
    /// Ground on which the plants stand.
    pub ground: Option<Ground>,
    /// Water that mirrors the plants. It changes no light of theirs, so that plans and scene light do not know of it.
    pub water: Option<Water>,
    /// Species of the scene, names unique.
    pub species: Vec<SceneSpecies>,
    /// Plants of the scene.
    pub instances: Vec<Placement>,
}

impl Scene {
    /// Time at which the first picture shows the waves on its water, seconds.
    pub fn start_s(&self) -> f64 {
        self.water.and_then(|water| water.waves).map_or(0.0, |waves| waves.time_s)
    }

    /// Every file that it names, but its light; whether it is there or not.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let of_species = self.species.iter().flat_map(|s| [&s.file, &s.species_file, &s.light]);
        let height_map = match self.ground.as_ref().map(|ground| &ground.terrain) {
            Some(Terrain::Map(map)) => Some(map.file.as_path()),
            _ => None,
        };
        let image = match &self.sky {
            SceneSky::Image(file) => Some(file.as_path()),
            _ => None,
        };
        of_species
            .flatten()
            .map(PathBuf::as_path)
            .chain(height_map)
            .chain(image)
            .chain(self.backdrop.as_deref())
    }
}

/// The suns of a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum Suns {
    /// Every sun above the horizon.
    Sky,
    /// Azimuths and elevations, degrees; not none.
    Fixed(Vec<[f64; 2]>),
    /// Suns of whole days.
    Path(SunPath),
}

/// The suns of whole days (UTC) at a place; both days count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunPath {
    /// North is positive, -90 to 90.
    pub latitude_deg: f64,
    /// East is positive, -180 to 180. Over whole days it changes nothing that a plan needs.
    pub longitude_deg: f64,
    /// First day.
    pub from: Day,
    /// Last day, not before the first.
    pub to: Day,
}

/// A day of the Gregorian calendar, 1900 to 2100.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Day {
    year: u16,
    month: u8,
    day: u8,
}

/// Camera that looks at a scene. A plan lets it look in any direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Points of the camera's path, which it follows along straight lines, metres; one or more.
    pub path_m: Vec<[f64; 3]>,
    /// Point that the camera looks at from each point of the path, metres; none is the point itself.
    pub look_at_m: Option<Vec<[f64; 3]>>,
    /// Vertical field of view, above 0, below 180.
    pub fov_deg: f64,
    /// Height of the picture.
    pub height_px: u32,
    /// Largest number of pixels that a site may cover.
    pub pixels_per_site: f64,
}

/// A species of a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SceneSpecies {
    /// Unique in the scene.
    pub name: String,
    /// Mesh or library, relative paths made relative to the scene's folder.
    pub file: Option<PathBuf>,
    /// The one mesh of a glTF file that it is.
    pub gltf_mesh: Option<String>,
    /// Species file of a mesh, as above.
    pub species_file: Option<PathBuf>,
    /// Library that holds its light, as above.
    pub light: Option<PathBuf>,
    /// Name of the species in that library, where it is another.
    pub light_species: Option<String>,
    /// Whether an instance of the species may turn freely about the vertical.
    pub upright: bool,
}

impl Day {
    /// From a TOML date without a time.
    fn from_toml(found: Datetime) -> Result<Day, String> {
        let expected = |what: &str| format!("found {found}, expected {what}");
        let (Some(date), None, None) = (found.date, found.time, found.offset) else {
            return Err(expected("a date without a time, such as 2026-06-21"));
        };
        if !(1900..=2100).contains(&date.year) {
            return Err(expected("a year from 1900 to 2100"));
        }
        Ok(Day { year: date.year, month: date.month, day: date.day })
    }

    /// Days from 2000-01-01 to the start of this day. Days from civil, after Hinnant, "chrono-Compatible Low-Level Date
    /// Algorithms": years start in March, so that the leap day is the last.
    pub fn since_2000(&self) -> i64 {
        let month = i64::from(self.month);
        let year = i64::from(self.year) - i64::from(month <= 2);
        let of_year = (153 * ((month + 9) % 12) + 2) / 5 + i64::from(self.day) - 1;
        year * 365 + year / 4 - year / 100 + year / 400 + of_year - 730_425
    }
}

impl std::fmt::Display for Day {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

impl SunPath {
    /// Checks the ranges.
    fn new(latitude_deg: f64, longitude_deg: f64, from: Day, to: Day) -> Result<SunPath, String> {
        check_place(latitude_deg, longitude_deg)?;
        if from > to {
            return Err(format!("found {from} to {to}, expected the earlier day first"));
        }
        Ok(SunPath { latitude_deg, longitude_deg, from, to })
    }
}

fn check_place(latitude_deg: f64, longitude_deg: f64) -> Result<(), String> {
    for (what, value, most) in [("latitude", latitude_deg, 90.0), ("longitude", longitude_deg, 180.0)] {
        if !(-most..=most).contains(&value) {
            return Err(format!("found {what} {value}, expected -{most} to {most} degrees"));
        }
    }
    Ok(())
}

/// `LAT,LON,` and the rest.
fn place_and_time(text: &str) -> Option<(f64, f64, &str)> {
    let mut parts = text.splitn(3, ',').map(str::trim);
    let mut number = || parts.next().and_then(|part| part.parse::<f64>().ok());
    Some((number()?, number()?, parts.next()?))
}

/// `LAT,LON,DATE..DATE`, as on the command line; a single date stands for one day.
impl FromStr for SunPath {
    type Err = String;

    fn from_str(text: &str) -> Result<SunPath, String> {
        let expected = || {
            format!("found {text:?}, expected LAT,LON,DATE..DATE, such as 52.5,13.4,2026-06-01..2026-08-31")
        };
        let (latitude_deg, longitude_deg, days) = place_and_time(text).ok_or_else(expected)?;
        let (from, to) = days.split_once("..").unwrap_or((days, days));
        let day = |text: &str| Day::from_toml(text.trim().parse().map_err(|_| expected())?);
        SunPath::new(latitude_deg, longitude_deg, day(from)?, day(to)?)
    }
}

/// The point at a share of the way, 0 to 1, along the straight lines between some points: each line takes as long.
///
/// # Panics
/// If there is no point.
pub fn along<const N: usize>(points: &[[f64; N]], share: f64) -> [f64; N] {
    let place = share * (points.len() - 1) as f64;
    let first = (place as usize).min(points.len() - 1);
    let next = (first + 1).min(points.len() - 1);
    let t = place - first as f64;
    // Where both are the same no rounding may move the point.
    std::array::from_fn(|axis| points[first][axis] + (points[next][axis] - points[first][axis]) * t)
}

#[cfg(test)]
mod tests;
