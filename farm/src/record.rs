//! What is known of a species that was baked: kept beside its file, and what tables and pages are made of.

use flb_format::light::LightError;
use flb_format::provenance::SURFACE_PSNR_DB;
use flb_packer::EncodedSpecies;
use serde::{Deserialize, Serialize};

use crate::manifest::Budget;
use crate::parts::Parts;

/// Record of a species that was baked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the species.
    pub name: String,
    /// Inputs and settings that its file depends on.
    pub parts: Parts,
    /// Sites with matter.
    pub sites: u64,
    /// Name and seconds of each stage.
    pub stages: Vec<(String, f64)>,
    /// Facts that an index tells, too.
    #[serde(flatten)]
    pub facts: Facts,
}

/// Facts of a species that an index tells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Key of its parts.
    pub key: String,
    /// Bytes of its file.
    pub bytes: u64,
    /// Digest of its file, 64 hexadecimal digits.
    pub blake3: String,
    /// Triangles of the mesh: all, leaf, wood.
    pub triangles: [u64; 3],
    /// Width along x, height along y, depth along z, in metres.
    pub size_m: [f64; 3],
    /// Sites along each edge.
    pub lattice: u32,
    /// Names of the bands.
    pub bands: Vec<String>,
    /// Error of the fit over suns that were held out, of the mean total fluence; `None` where nothing is fitted.
    pub suns_error: Option<f64>,
    /// Peak signal to noise of the coding at surfaces, in dB; `None` where there is no error.
    pub psnr_db: Option<f64>,
    /// Relative error of the coding in dark places, the largest of the bases that miss their target for it; `None`
    /// where none does. Bases that miss their mean error, too, are among the warnings.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub dark_error: Option<f64>,
    /// Whether every solve met its tolerance.
    pub is_converged: bool,
    /// Seconds of the bake.
    pub seconds: f64,
    /// Doubts about the mesh, and warnings.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub warnings: Vec<String>,
}

impl Facts {
    /// Facts of a species that is coded, and of its file.
    pub(crate) fn of(species: &EncodedSpecies, key: &str, file: &[u8]) -> Facts {
        let meta = &species.meta;
        let light: Option<&LightError> = meta.physical().map(|(_, light)| &light.error);
        let held_out = light.filter(|error| error.held_out > 0);
        Facts {
            key: key.to_owned(),
            bytes: file.len() as u64,
            blake3: blake3::hash(file).to_hex().to_string(),
            triangles: [meta.triangles.total, meta.triangles.leaf, meta.triangles.wood],
            size_m: std::array::from_fn(|axis| meta.bounds_m.max[axis] - meta.bounds_m.min[axis]),
            lattice: meta.grid.lattice,
            bands: meta.bands().map(str::to_owned).collect(),
            suns_error: held_out.map(|error| error.suns_rms),
            psnr_db: meta.recorded(&SURFACE_PSNR_DB).flatten(),
            dark_error: species.missed().map(|missed| missed.dark_error).reduce(f64::max),
            is_converged: true,
            seconds: 0.0,
            warnings: Vec::new(),
        }
    }

    /// Sentences on what goes over a budget.
    pub fn over(&self, budget: &Budget) -> Vec<String> {
        let Budget { bytes, suns_error, seconds } = *budget;
        let rows = [
            ("bytes", Some(self.bytes as f64), bytes),
            ("suns_error", self.suns_error, suns_error),
            ("seconds", Some(self.seconds), seconds),
        ];
        let over = rows.into_iter().filter_map(|(what, found, most)| {
            let (found, most) = (found?, most?);
            (found > most).then(|| format!("{what} is {found}, over its budget of {most}"))
        });
        over.collect()
    }
}
