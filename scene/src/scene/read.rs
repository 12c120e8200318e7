//! Scene files: TOML to a [`Scene`].

use flb_format::text::is_hidden;
use flb_format::{Placement, Transform};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::camera::RawCamera;
use super::ground::RawGround;
use super::highlight::RawHighlight;
use super::parts::{Parts, Size};
use super::reading::{Checked, Reading};
use super::sky::RawSky;
use super::sun::RawSun;
use super::sunlight::Sunlight;
use super::syntax::shown;
use super::water::RawWater;
use super::{Scene, SceneSpecies, Suns};
use crate::import::{ImportError, MAX_SPECIES, ask, excerpt, in_words, read_text, reserve};
use crate::species::MAX_BANDS;

/// Bytes of a scene file.
pub const MAX_SCENE_BYTES: u64 = 64 << 20;
/// Plants of a scene.
pub const MAX_INSTANCES: usize = 1 << 20;

/// What toml may make a tree of at once: a scene without its instances, or one of them. At most 700 bytes for each
/// token (tables of one key), and 7 for each byte, most of which is never written to.
const MAX_TREE: Size = Size { tokens: 1 << 18, bytes: 8 << 20 };

/// What a token of that tree takes in an ordinary scene.
const USUAL_TOKEN_BYTES: usize = 200;

/// Sizes of plants.
pub(crate) const SCALES: [f64; 2] = [1e-6, 1e6];
/// A rotation's length may be this far from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    bands: Option<Spanned<Vec<String>>>,
    light: Option<PathBuf>,
    #[serde(default, deserialize_with = "RawSky::of_table_or_file")]
    sky: RawSky,
    sun: Option<Spanned<RawSun>>,
    camera: Option<Spanned<RawCamera>>,
    ground: Option<Spanned<RawGround>>,
    water: Option<RawWater>,
    #[serde(default)]
    highlight: RawHighlight,
    #[serde(default)]
    species: Vec<Spanned<RawSpecies>>,
    instance: Option<Vec<Spanned<RawInstance>>>,
}

/// A document of instances alone.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Instances {
    instance: Vec<Spanned<RawInstance>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSpecies {
    name: String,
    file: Option<PathBuf>,
    gltf_mesh: Option<Spanned<String>>,
    species_file: Option<PathBuf>,
    light: Option<PathBuf>,
    light_species: Option<Spanned<String>>,
    #[serde(default)]
    upright: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawInstance {
    species: String,
    position_m: [f64; 3],
    yaw_deg: Option<f64>,
    rotation: Option<[f64; 4]>,
    scale: Option<f64>,
}

impl Scene {
    /// Reads and validates the file at `path`.
    ///
    /// # Errors
    /// [`ImportError::Io`]; [`ImportError::Limit`]; [`ImportError::Syntax`] with line and column for what is no TOML,
    /// of another type, or an unknown key; [`ImportError::Malformed`] with the line for a value out of its range.
    pub fn read(path: &Path) -> Result<Scene, ImportError> {
        let (file, text) = read_text(path, MAX_SCENE_BYTES)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Scene::parse(&file, folder, text.strip_prefix('\u{feff}').unwrap_or(&text))
    }

    /// Parses a scene from text; `file` is for messages, `folder` is where relative paths start.
    ///
    /// Of several mistakes, a text that is small enough to be read as a whole tells the one that TOML comes to first,
    /// which need not be the first one in the text.
    pub fn parse(file: &str, folder: &Path, text: &str) -> Result<Scene, ImportError> {
        match Scene::parse_in_parts(file, folder, text) {
            Err(_) if MAX_TREE.is_room_for(Size::of(text)) => Scene::parse_as_a_whole(file, folder, text),
            found => found,
        }
    }

    /// Parses a scene from text, an instance at a time: the memory is that of the instances, less than twice the text.
    /// Of several mistakes it tells another one, perhaps, than [`Scene::parse_as_a_whole`].
    pub fn parse_in_parts(file: &str, folder: &Path, text: &str) -> Result<Scene, ImportError> {
        let text_bytes = text.len() as u64;
        if text_bytes > MAX_SCENE_BYTES {
            let (file, what) = (file.to_owned(), "bytes of the scene".to_owned());
            return Err(ImportError::Limit { file, what, found: text_bytes, limit: MAX_SCENE_BYTES });
        }
        let parts = Parts::of(text).map_err(|_| {
            let (file, what) = (file.to_owned(), "the places of instances".to_owned());
            ImportError::Memory { file, what, bytes: text_bytes }
        })?;
        let whole = Reading { file, folder, text, parts: None };
        whole.tree("beside its instances", parts.rest_size)?;
        whole.tree("of an instance", parts.most)?;
        let raw: Raw =
            toml::from_str(&parts.rest()).map_err(|error| whole.syntax(&error, |at| parts.place(at)))?;
        if let (Some(at), Some(_)) = (parts.first_table, &raw.instance) {
            return Err(whole.malformed(at, "instance", "[[instance]] and instance", "one of them"));
        }
        let instances = parts.instances().flat_map(|part| {
            let found: Result<Instances, _> = toml::from_str(&part.text);
            let (instances, error) = match found {
                Ok(found) => (found.instance, None),
                Err(error) => (Vec::new(), Some(whole.syntax(&error, |at| part.place(at)))),
            };
            let place = move |instance: Spanned<RawInstance>| {
                let at = part.place(instance.span().start);
                Ok((at, instance.into_inner()))
            };
            instances.into_iter().map(place).chain(error.map(Err))
        });
        Reading { file, folder, text, parts: Some(&parts) }.scene(raw, parts.count, instances)
    }

    /// Parses a scene from text, with a tree of all of it, which takes fifty times the text and more: for texts that
    /// are small, and to compare with.
    pub fn parse_as_a_whole(file: &str, folder: &Path, text: &str) -> Result<Scene, ImportError> {
        let whole = Reading { file, folder, text, parts: None };
        let mut raw: Raw = toml::from_str(text).map_err(|error| ImportError::Syntax {
            file: file.to_owned(),
            message: excerpt(in_words(error.to_string().trim_end())),
        })?;
        let instances = raw.instance.take().unwrap_or_default();
        let count = instances.len();
        let place = |instance: Spanned<RawInstance>| Ok((instance.span().start, instance.into_inner()));
        whole.scene(raw, count, instances.into_iter().map(place))
    }
}

impl Reading<'_> {
    /// `instances` come with their places in the text.
    fn scene(
        &self,
        raw: Raw,
        count: usize,
        instances: impl Iterator<Item = Checked<(usize, RawInstance)>>,
    ) -> Checked<Scene> {
        self.limit("species", raw.species.len(), MAX_SPECIES)?;
        self.limit("instances", count, MAX_INSTANCES)?;
        if raw.species.is_empty() {
            return Err(self.malformed(0, "species", "none", "one [[species]] or more"));
        }
        let (sky, ambient, backdrop) = self.sky(raw.sky)?;
        let mut by_name = HashMap::new();
        let mut species = Vec::with_capacity(raw.species.len());
        for entry in &raw.species {
            species.push(self.species(entry, by_name.len(), &mut by_name)?);
        }
        let instances = Reading { parts: None, ..*self }.instances(count, instances, &species, &by_name)?;
        let mut placed = vec![false; species.len()];
        instances.iter().for_each(|instance: &Placement| placed[instance.species] = true);
        for (i, entry) in raw.species.iter().enumerate() {
            if !placed[i] && !species[i].upright {
                let found = format!("species {:?} without an instance", species[i].name);
                let expected = "an [[instance]], or upright = true";
                return Err(self.malformed(entry.span().start, "species", found, expected));
            }
        }
        let ground = raw.ground.map(|ground| self.ground(ground)).transpose()?;
        let water = raw.water.map(|water| self.water(water, ground.as_ref())).transpose()?;
        let (suns, sunlight) = match raw.sun {
            Some(sun) => self.suns(sun)?,
            None => (Suns::Sky, Sunlight::default()),
        };
        Ok(Scene {
            bands: raw.bands.map(|bands| self.bands(bands)).transpose()?,
            light: raw.light.map(|light| self.folder.join(light)),
            ambient,
            sky,
            backdrop,
            suns,
            sunlight,
            highlight: self.highlight(raw.highlight)?,
            camera: raw.camera.map(|camera| self.camera(camera)).transpose()?,
            ground,
            water,
            species,
            instances,
        })
    }

    fn bands(&self, raw: Spanned<Vec<String>>) -> Checked<Vec<String>> {
        let (at, bands) = (raw.span().start, raw.into_inner());
        if !(1..=MAX_BANDS).contains(&bands.len()) {
            return Err(self.malformed(at, "bands", format!("{} names", bands.len()), "1 to 64 names"));
        }
        if let Some(twice) = (1..bands.len()).find(|&i| bands[..i].contains(&bands[i])) {
            return Err(self.malformed(at, "bands", format!("{:?} twice", bands[twice]), "each name once"));
        }
        Ok(bands)
    }

    fn species(
        &self,
        raw: &Spanned<RawSpecies>,
        index: usize,
        by_name: &mut HashMap<String, usize>,
    ) -> Checked<SceneSpecies> {
        let (at, raw) = (raw.span().start, raw.get_ref());
        if raw.name.trim().is_empty() || raw.name.chars().any(is_hidden) {
            return Err(self.malformed(at, "species.name", format!("{:?}", raw.name), "a printable name"));
        }
        if by_name.insert(raw.name.clone(), index).is_some() {
            return Err(self.malformed(
                at,
                "species.name",
                format!("{:?} again", raw.name),
                "each name once",
            ));
        }
        if let Some(name) = raw.light_species.as_ref().filter(|_| raw.light.is_none()) {
            let found = "light_species without light";
            return Err(self.malformed(
                name.span().start,
                "species",
                found,
                "light, the library that holds it",
            ));
        }
        if let Some(mesh) = raw.gltf_mesh.as_ref().filter(|_| raw.file.is_none()) {
            let at = mesh.span().start;
            return Err(self.malformed(
                at,
                "species",
                "gltf_mesh without file",
                "file, which holds the mesh",
            ));
        }
        let beside = |path: &Option<PathBuf>| path.as_ref().map(|path| self.folder.join(path));
        Ok(SceneSpecies {
            name: raw.name.clone(),
            file: beside(&raw.file),
            gltf_mesh: raw.gltf_mesh.as_ref().map(|mesh| mesh.get_ref().clone()),
            species_file: beside(&raw.species_file),
            light: beside(&raw.light),
            light_species: raw.light_species.as_ref().map(|name| name.get_ref().clone()),
            upright: raw.upright,
        })
    }

    fn instances(
        &self,
        count: usize,
        raw: impl Iterator<Item = Checked<(usize, RawInstance)>>,
        species: &[SceneSpecies],
        by_name: &HashMap<String, usize>,
    ) -> Checked<Vec<Placement>> {
        let mut instances = Vec::new();
        reserve(self.file, "instances", &mut instances, count)?;
        for entry in raw {
            let (at, raw) = entry?;
            instances.push(self.instance(at, &raw, species, by_name)?);
        }
        Ok(instances)
    }

    fn instance(
        &self,
        at: usize,
        raw: &RawInstance,
        species: &[SceneSpecies],
        by_name: &HashMap<String, usize>,
    ) -> Checked<Placement> {
        let Some(&index) = by_name.get(&raw.species) else {
            let mut names: Vec<&str> = species.iter().take(20).map(|species| species.name.as_str()).collect();
            if species.len() > names.len() {
                names.push("...");
            }
            let expected = format!("one of {}", names.join(", "));
            return Err(self.malformed(at, "instance.species", format!("{:?}", raw.species), &expected));
        };
        self.points(at, "instance.position_m", &[raw.position_m])?;
        let scale = raw.scale.unwrap_or(1.0);
        let [least, most] = SCALES;
        self.within(at, "instance.scale", scale, least, most)?;
        let transform = match (raw.yaw_deg, raw.rotation) {
            (Some(_), Some(_)) => {
                return Err(self.malformed(at, "instance", "yaw_deg and rotation", "one of them"));
            }
            (yaw_deg, None) => {
                let yaw_deg = yaw_deg.unwrap_or(0.0);
                let yaw_deg = self.within(at, "instance.yaw_deg", yaw_deg, -36_000.0, 36_000.0)?;
                Transform::from_yaw(raw.position_m, yaw_deg, scale)
            }
            (None, Some(quaternion)) => {
                let length = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
                let what = "length of instance.rotation";
                self.within(at, what, length, 1.0 - UNIT_TOLERANCE, 1.0 + UNIT_TOLERANCE)?;
                let placed = Transform::from_quaternion(raw.position_m, quaternion, scale);
                placed.ok_or_else(|| {
                    let found = format!("{quaternion:?}");
                    self.malformed(at, "instance.rotation", found, "a quaternion of length 1")
                })?
            }
        };
        let instance = Placement { species: index, transform };
        if species[index].upright && !instance.transform.is_upright() {
            let found = format!("a tilted plant of the upright species {:?}", raw.species);
            let expected = "yaw_deg, or a rotation with x and z 0";
            return Err(self.malformed(at, "instance.rotation", found, expected));
        }
        Ok(instance)
    }

    /// An error if toml's tree of so much would be too large.
    fn tree(&self, what: &str, size: Size) -> Checked<()> {
        self.limit(&format!("bytes of TOML {what}"), size.bytes, MAX_TREE.bytes)?;
        self.limit(&format!("words and signs of TOML {what}"), size.tokens, MAX_TREE.tokens)?;
        ask(self.file, &format!("TOML {what}"), (7 * size.bytes + USUAL_TOKEN_BYTES * size.tokens) as u64)
    }

    /// An error of a part, told as of the whole text.
    fn syntax(&self, error: &toml::de::Error, place: impl Fn(usize) -> usize) -> ImportError {
        let message = match error.span() {
            Some(span) => shown(self.text, place(span.start)..place(span.end), error.message()),
            None => error.to_string(),
        };
        ImportError::Syntax { file: self.file.to_owned(), message: excerpt(in_words(message.trim_end())) }
    }
}

#[cfg(test)]
mod tests;
