//! `flb bake`: from mesh files to one published library.

use std::collections::BTreeMap;
use std::path::Path;

use flb_baker::artefact;
use flb_baker::{Mesh, Occupancy, Solution, SolveSettings, SolverKind, VoxelSettings};
use flb_format::meta::TriangleCounts;
use flb_format::{Codec, Medium, Optics, SpeciesMeta};
use flb_packer::{EncodeSettings, EncodedSpecies, SpeciesFields, encode_species, write_library};
use serde::Serialize;
use serde_json::{Value, json};

use crate::args::{BakeArgs, SolverArg};
use crate::cache::Cache;
use crate::classes::{MeshReader, triangle_counts};
use crate::exit::{Failure, LOSS, USAGE};
use crate::inputs::{check_distinct, check_output};
use crate::print;
use crate::stages::{Stage, Stages};

/// The summary of a bake; `--json` prints it (cli/schema/bake.json).
#[derive(Serialize)]
struct Summary {
    output: String,
    bytes: u64,
    converged: bool,
    stages: Vec<Stage>,
    species: Vec<SpeciesSummary>,
}

/// One species in the summary of `bake` and `pack`.
#[derive(Serialize)]
pub struct SpeciesSummary {
    pub name: String,
    pub triangles: u64,
    pub leaf_triangles: u64,
    pub wood_triangles: u64,
    pub lattice: u32,
    pub sites_nonempty: usize,
    pub bases: Vec<u8>,
    pub bytes: u64,
    /// Bytes of the bases as plain 32-bit floats over the bytes that they take in the file.
    pub ratio: f64,
    /// Null where the coded field is exact.
    pub surface_psnr_db: Option<f64>,
}

impl SpeciesSummary {
    /// Of a species that is ready to be written.
    pub fn new(species: &EncodedSpecies) -> SpeciesSummary {
        let meta = species.meta();
        SpeciesSummary {
            name: meta.name.clone(),
            triangles: meta.triangles.total,
            leaf_triangles: meta.triangles.leaf,
            wood_triangles: meta.triangles.wood,
            lattice: meta.grid.lattice,
            sites_nonempty: species.sites_nonempty(),
            bases: species.bases(),
            bytes: species.bytes(),
            ratio: species.report.ratio,
            surface_psnr_db: species.report.surface_psnr_db,
        }
    }
}

/// Checks, bakes every mesh, writes the library (and the fields, if they are kept), prints the summary.
pub fn run(args: &BakeArgs) -> Result<u8, Failure> {
    check_settings(args)?;
    let reader = MeshReader::new(&args.mesh)?;
    let cache = Cache::open(args.cache.as_deref())?;
    let mut stages = Stages::default();
    let mut coded = Vec::new();
    let mut kept = Vec::new();
    let mut converged = true;
    for path in &args.meshes {
        let baked = bake_species(path, args, &reader, &cache, &mut stages)?;
        converged &= baked.converged;
        let settings = EncodeSettings {
            codec: Codec::HaarPaper,
            threshold: args.coding.threshold(),
            compress: args.coding.compress,
            ..EncodeSettings::default()
        };
        let name = baked.fields.meta.name.clone();
        coded.push(stages.run("encode", &name, |progress| encode_species(&baked.fields, &settings, progress))?);
        if args.keep_fields.is_some() {
            let raw = EncodeSettings { codec: Codec::RawF32, threshold: 0.0, ..settings };
            kept.push(stages.run("encode", &name, |progress| encode_species(&baked.fields, &raw, progress))?);
        }
    }
    let bytes = stages.run("write", &args.output.display().to_string(), |_| -> Result<u64, Failure> {
        if let Some(fields) = &args.keep_fields {
            write_library(fields, &kept.iter().collect::<Vec<_>>(), args.force)?;
        }
        Ok(write_library(&args.output, &coded.iter().collect::<Vec<_>>(), args.force)?)
    })?;
    let summary = Summary {
        output: args.output.display().to_string(),
        bytes,
        converged,
        stages: stages.list().to_vec(),
        species: coded.iter().map(SpeciesSummary::new).collect(),
    };
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&summary_text(&summary))?,
    }
    Ok(if converged { 0 } else { LOSS })
}
