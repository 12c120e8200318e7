//! What the bakes of both models share: names, places and the voxels of a plant.

use flb_format::text::is_hidden;
use std::path::Path;

use flb_baker::artefact;
use flb_baker::plan::{Plan, PlanError, Share};
use flb_baker::voxelise::plant_bounds;
use flb_baker::{VoxelSettings, downsample, voxelise};
use flb_files::check_unread;
use flb_format::meta::{Bounds, SourceFile};
use flb_format::{Grid, Medium, Model, SpeciesMeta};
use flb_packer::SpeciesFields;
use flb_scene::import::WHOLE;
use serde_json::json;

use crate::args::BakeArgs;
use crate::cache::Cache;
use crate::classes::{ClassedMesh, MESH_KEY, MeshReader};
use crate::exit::{Failure, USAGE};
use crate::stages::Stages;

/// What all species of a bake share.
pub struct Job<'a> {
    pub args: &'a BakeArgs,
    pub reader: &'a MeshReader,
    pub plan: Option<&'a Plan>,
    pub cache: &'a Cache,
}

/// A species before coding.
pub struct Baked {
    pub fields: SpeciesFields,
    pub converged: bool,
    /// Bands that it could have.
    pub bands: usize,
    /// Solves that made its fields, and those of a bake without a plan.
    pub solves: [u32; 2],
}

/// A plant that was read, and what its file will say of it.
pub struct Start {
    pub classed: ClassedMesh,
    pub meta: SpeciesMeta,
    pub voxels: VoxelSettings,
}

impl Job<'_> {
    /// The name of a mesh's species, and what the plan says of it.
    pub fn planned(&self, path: &Path) -> Result<(String, Option<Share>), Failure> {
        let name = species_name(path, self.args, self.reader)?;
        let share = self.plan.map(|plan| plan.share(&name)).transpose()?;
        Ok((name, share))
    }

    /// Sites along each edge: the flag's, the plan's or the preset's.
    pub fn lattice(&self, share: Option<Share>) -> u32 {
        let asked = self.args.lattice.or(share.and_then(|share| share.lattice));
        asked.unwrap_or(self.args.preset().lattice)
    }

    /// Imports the mesh.
    pub fn start(
        &self,
        path: &Path,
        name: String,
        share: Option<Share>,
        model: Model,
        stages: &mut Stages,
    ) -> Result<Start, Failure> {
        let classed = stages.run("import", &name, |_| self.reader.read_classed(path))?;
        // Textures, buffers and material libraries are known by now.
        check_unread(&self.args.output)?;
        self.args.keep_fields.as_deref().map_or(Ok(()), check_unread)?;
        let by_file = self.reader.species.as_ref().is_some_and(|species| species.ignore_alpha);
        let voxels = VoxelSettings {
            voxels: self.args.voxels,
            lattice: self.lattice(share),
            ignore_alpha: self.args.ignore_alpha || by_file,
        };
        let meta = describe(name, &classed, self.reader, &voxels, model);
        Ok(Start { classed, meta, voxels })
    }

    /// Places of the bands that the plan asks for, in the species' order, and the names of the others.
    pub fn bands(&self, names: &[&str], species: &str) -> Result<(Vec<usize>, Vec<String>), PlanError> {
        let Some(wanted) = self.plan.and_then(|plan| plan.bands.as_ref()) else {
            return Ok(((0..names.len()).collect(), Vec::new()));
        };
        if let Some(unknown) = wanted.iter().find(|name| !names.contains(&name.as_str())) {
            let known = names.iter().map(|name| (*name).to_owned()).collect();
            return Err(PlanError::UnknownBand { name: unknown.clone(), species: species.to_owned(), known });
        }
        let is_wanted = |place: &usize| wanted.iter().any(|name| name == names[*place]);
        let (kept, others): (Vec<usize>, Vec<usize>) = (0..names.len()).partition(is_wanted);
        Ok((kept, others.into_iter().map(|place| names[place].to_owned()).collect()))
    }
}

/// What a plant's voxels depend on, besides the settings of the voxeliser.
pub fn shape(meta: &SpeciesMeta) -> [Vec<u8>; 2] {
    let (up, unit, mesh) =
        (&meta.settings["import.up"], &meta.settings["import.unit_m"], meta.settings.get(MESH_KEY));
    let shape = json!([meta.sources, up, unit, mesh]).to_string();
    [shape.into_bytes(), meta.settings["classify.materials"].to_string().into_bytes()]
}

/// Voxelise and downsample, or what an earlier bake kept of them.
pub fn medium(
    classed: &ClassedMesh,
    settings: &VoxelSettings,
    shape: &[Vec<u8>; 2],
    cache: &Cache,
    stages: &mut Stages,
) -> Result<Medium, Failure> {
    let key = artefact::key("occupancy", &[&shape[0], &shape[1]], &format!("{settings:?}"));
    let occupancy = stages.run("voxelise", "", |progress| {
        let make = || Ok(voxelise(&classed.mesh, &classed.classes, settings, progress)?);
        cache.reuse_or_make("occupancy", &key, |_| Ok(()), make)
    })?;
    let key = artefact::key("medium", &[key.as_bytes()], "");
    stages.run("downsample", "", |_| {
        let make = || Ok(downsample(&occupancy)?);
        cache.reuse_or_make("medium", &key, |_| Ok(()), make)
    })
}

/// What the file says about the species; the grid is the downsampled medium's, set later.
fn describe(
    name: String,
    classed: &ClassedMesh,
    reader: &MeshReader,
    voxels: &VoxelSettings,
    model: Model,
) -> SpeciesMeta {
    let bounds = plant_bounds(&classed.mesh, &classed.classes).or_else(|| classed.mesh.bounds());
    let mut sources = classed.mesh.sources.clone();
    if let Some(species) = &reader.species {
        sources.push(SourceFile { name: species.file.clone(), blake3: species.blake3.clone() });
    }
    let mut settings = reader.record(classed);
    settings.insert("voxelise.voxels".to_owned(), json!(voxels.voxels));
    settings.insert("voxelise.ignore_alpha".to_owned(), json!(voxels.ignore_alpha));
    SpeciesMeta {
        name,
        model,
        grid: Grid { lattice: voxels.lattice, origin_m: [0.0; 3], spacing_m: 1.0 },
        bounds_m: bounds.unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] }),
        triangles: classed.triangle_counts(),
        sources,
        settings,
        tool: concat!("flb ", env!("CARGO_PKG_VERSION")).to_owned(),
        left_out: None,
        extra: Default::default(),
    }
}

/// The flag's name, the species file's, that of the mesh in its file, or the mesh file's without its extension.
pub fn species_name(path: &Path, args: &BakeArgs, reader: &MeshReader) -> Result<String, Failure> {
    let stem = || path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let of_file = || reader.species.as_ref().and_then(|species| species.name.clone());
    let is_name = |word: &&String| *word != WHOLE && !word.starts_with('#');
    // What a library does not take in a name is replaced as `flb scene` does.
    let allowed = |word: &String| word.trim().replace(|c: char| is_hidden(c) || "/\\".contains(c), "_");
    let of_mesh = || reader.settings.gltf_mesh.as_ref().filter(is_name).map(allowed);
    // One name cannot serve several species.
    let name = match args.meshes.len() {
        1 => args.name.clone().or_else(of_file).or_else(of_mesh).or_else(stem),
        _ => stem(),
    };
    name.filter(|name| !name.is_empty()).ok_or_else(|| Failure::new(USAGE, "the file has no name").at(path))
}
