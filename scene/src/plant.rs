//! A plant as a bake takes it: its mesh with the class of every material, its surfaces, and what its file says of both.
//!
//! ```text
//! mesh file, species file, patterns -PlantReader-> ClassedMesh -plant-> Plant
//! ```

mod record;
#[cfg(test)]
mod tests;

use std::path::Path;

use flb_format::matter::{Optics, Surfaces};
use flb_format::mesh::MeshMark;
use flb_format::meta::{Bounds, SourceFile, TriangleCounts};
use flb_format::text::is_hidden;

pub use record::{Record, recorded_classes, recorded_offset_m, recorded_settings};

use crate::classify::Classified;
use crate::classify::classify;
use crate::color::{ColorRules, Colors, MaterialColor, resolve};
use crate::import::{WHOLE, area, import};
use crate::leaf::knapp_carter;
use crate::mesh::AlphaMode;
use crate::{ClassRules, ImportError, ImportSettings, MaterialClass, Mesh, SpeciesFile, sheets};

/// A mesh and the class of each of its materials.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassedMesh {
    /// Mesh as imported.
    pub mesh: Mesh,
    /// Class of each material of `mesh`.
    pub classes: Vec<MaterialClass>,
}

impl ClassedMesh {
    /// A mesh whose classes are known, one per material: what it states twice counts once from here on
    /// ([`crate::sheets`]). Wood whose alpha channel is not said to cut is opaque, as that of bark is gloss or height.
    pub fn of(mut mesh: Mesh, classes: Vec<MaterialClass>) -> ClassedMesh {
        for (material, class) in mesh.materials.iter_mut().zip(&classes) {
            if material.is_alpha_guessed && *class == MaterialClass::Wood {
                material.alpha_mode = AlphaMode::Opaque;
                material.base_color[3] = 1.0;
            }
        }
        sheets::find(&mut mesh, &classes);
        ClassedMesh { mesh, classes }
    }

    /// Triangles by class.
    pub fn triangle_counts(&self) -> TriangleCounts {
        let count = |class| {
            let of_class = |material: &&u32| self.classes[**material as usize] == class;
            self.mesh.triangle_material.iter().filter(of_class).count() as u64
        };
        TriangleCounts {
            total: self.mesh.triangles.len() as u64,
            leaf: count(MaterialClass::Leaf),
            wood: count(MaterialClass::Wood),
        }
    }

    /// Area of the triangles of a class, nothing cut away, square metres. A triangle that stands for one side of a leaf
    /// counts half.
    pub fn area_m2(&self, class: MaterialClass) -> f64 {
        let mesh = &self.mesh;
        let of_class = |triangle: &usize| self.classes[mesh.triangle_material[*triangle] as usize] == class;
        let area_m2 = |triangle: usize| mesh.sheets.side(triangle).share() * area(mesh.corners_m(triangle));
        (0..mesh.triangles.len()).filter(of_class).map(area_m2).sum()
    }

    /// Bounds of what is leaf or wood; of all triangles where nothing is; `None` for a mesh without any.
    pub fn bounds(&self) -> Option<Bounds> {
        plant_bounds(&self.mesh, &self.classes).or_else(|| self.mesh.bounds())
    }

    /// Computes the mark of the mesh, as a file of its light keeps it; `None` for what is no mesh.
    pub fn mark(&self) -> Option<MeshMark> {
        Some(MeshMark { blake3: self.mesh.digest()?, bounds_m: self.bounds()? })
    }
}

/// Bounds of the triangles whose material is leaf or wood; `None` where there is none.
pub fn plant_bounds(mesh: &Mesh, classes: &[MaterialClass]) -> Option<Bounds> {
    bounds_where(mesh, classes, |class| class != MaterialClass::Neither)
}

/// Bounds of the triangles whose material is of a class that `counts`; `None` where there is none.
pub(crate) fn bounds_where(
    mesh: &Mesh,
    classes: &[MaterialClass],
    counts: impl Fn(MaterialClass) -> bool,
) -> Option<Bounds> {
    let mut bounds: Option<Bounds> = None;
    for (triangle, &material) in mesh.triangles.iter().zip(&mesh.triangle_material) {
        if !counts(classes[material as usize]) {
            continue;
        }
        for &vertex in triangle {
            let point = mesh.positions[vertex as usize].map(f64::from);
            let b = bounds.get_or_insert(Bounds { min: point, max: point });
            b.min = std::array::from_fn(|axis| b.min[axis].min(point[axis]));
            b.max = std::array::from_fn(|axis| b.max[axis].max(point[axis]));
        }
    }
    bounds
}

/// All that a bake has to know of a plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Name of the species.
    pub name: String,
    /// Triangles and classes, model space, metres.
    pub classed: ClassedMesh,
    /// Reflectance and transmittance per band, of the `physical` model: the mean of what pictures show. A material of
    /// `classed` that is no tint of these has a surface of its own.
    pub surfaces: Surfaces,
    /// Colour of each material and how it was found; `None` for what is neither leaf nor wood.
    pub colors: Vec<Option<MaterialColor>>,
    /// Optical parameters per band, of the `paper` model.
    pub optics: Optics,
    /// The files that it was read from, with their digests.
    pub sources: Vec<SourceFile>,
    /// Record of how the mesh was read, for the file that is baked, so that a renderer can read the mesh in the same
    /// way.
    pub record: Record,
    /// Take every texel of a leaf card for present.
    pub ignore_alpha: bool,
}

impl Plant {
    /// A mesh made in memory, with surfaces of common leaves and bark.
    pub fn new(name: impl Into<String>, mesh: Mesh, classes: Vec<MaterialClass>) -> Plant {
        PlantReader::default().plant(name.into(), ClassedMesh::of(mesh, classes))
    }
}

/// Settings by which mesh files are read.
#[derive(Debug, Clone, Default)]
pub struct PlantReader {
    /// The species file, if there is one.
    pub species: Option<SpeciesFile>,
    /// Unit and up axis.
    pub settings: ImportSettings,
    /// Patterns of materials.
    pub rules: ClassRules,
    /// Rules for the meaning of texels.
    pub colors: ColorRules,
}

impl PlantReader {
    /// Makes a reader with a species file, whose words `settings` and `rules` go before.
    pub fn new(species: Option<SpeciesFile>, settings: ImportSettings, rules: ClassRules) -> PlantReader {
        let settings = match &species {
            Some(species) => species.import_settings(&settings),
            None => settings,
        };
        let rules = ClassRules { species: species.as_ref().map(SpeciesFile::rules), ..rules };
        let settings = ImportSettings { split: rules.split_patterns(), ..settings };
        let colors = species.as_ref().map(SpeciesFile::color_rules).unwrap_or_default();
        PlantReader { species, settings, rules, colors }
    }

    /// The mesh of a file with its classes, and the rule that decided each.
    ///
    /// # Errors
    /// As [`import()`] and [`classify()`].
    pub fn read(&self, path: &Path) -> Result<(ClassedMesh, Vec<Classified>), ImportError> {
        self.class(import(path, &self.settings)?)
    }

    /// Classifies the materials of a mesh that was imported already.
    ///
    /// # Errors
    /// As [`classify()`] and [`ColorRules::check`].
    pub fn class(&self, mesh: Mesh) -> Result<(ClassedMesh, Vec<Classified>), ImportError> {
        let decisions = classify(&mesh, &self.rules)?;
        let classes: Vec<MaterialClass> = decisions.iter().map(|decision| decision.class).collect();
        let names = mesh.materials.iter().map(|material| &material.name);
        self.colors.check(&names.chain(&self.rules.elsewhere).map(String::as_str).collect::<Vec<_>>())?;
        Ok((ClassedMesh::of(mesh, classes), decisions))
    }

    /// Checks that all files of a job can be read: imports and classes each. Remembers the materials' names, so that a
    /// pattern may be meant for one mesh of several.
    ///
    /// # Errors
    /// As [`PlantReader::read`], with the index of the file.
    pub fn rehearse(&mut self, paths: &[impl AsRef<Path>]) -> Result<(), (usize, ImportError)> {
        let mut meshes = Vec::new();
        for (index, path) in paths.iter().enumerate() {
            meshes.push(import(path.as_ref(), &self.settings).map_err(|error| (index, error))?);
            let names = meshes.last().into_iter().flat_map(|mesh| &mesh.materials).map(|m| m.name.clone());
            self.rules.elsewhere.extend(names);
        }
        for (index, mesh) in meshes.iter().enumerate() {
            classify(mesh, &self.rules).map_err(|error| (index, error))?;
        }
        Ok(())
    }

    /// The name of a file's species: the species file's, that of the mesh in its file, or the mesh file's without its
    /// extension; `None` where all are empty.
    pub fn name(&self, path: &Path) -> Option<String> {
        let of_file = self.species.as_ref().and_then(|species| species.name.clone());
        let is_name = |word: &&String| *word != WHOLE && !word.starts_with('#');
        // What a library does not take in a name is replaced.
        let allowed = |word: &String| word.trim().replace(|c: char| is_hidden(c) || "/\\".contains(c), "_");
        let of_mesh = || self.settings.gltf_mesh.as_ref().filter(is_name).map(allowed);
        of_file.or_else(of_mesh).or_else(|| file_name(path)).filter(|name| !name.is_empty())
    }

    /// The plant of a mesh that was read.
    pub fn plant(&self, name: String, mut classed: ClassedMesh) -> Plant {
        let species = self.species.as_ref();
        let mut sources = classed.mesh.sources.clone();
        sources.extend(species.map(|s| SourceFile { name: s.file.clone(), blake3: s.blake3.clone() }));
        let Colors { materials, surfaces, mean } =
            resolve(&classed.mesh, &classed.classes, &self.surfaces(), &self.colors);
        let all = classed.mesh.materials.iter_mut();
        all.zip(surfaces).for_each(|(material, surface)| material.surface = surface);
        Plant {
            name,
            surfaces: mean,
            colors: materials,
            optics: self.optics(),
            sources,
            record: Record::of(&self.settings, &classed.mesh, &classed.classes),
            ignore_alpha: species.is_some_and(|species| species.ignore_alpha),
            classed,
        }
    }

    /// Surfaces of the `physical` model: the species file's, else those of common leaves and bark.
    pub fn surfaces(&self) -> Surfaces {
        self.species.as_ref().and_then(|species| species.surfaces.clone()).unwrap_or_else(knapp_carter)
    }

    /// Optics of the `paper` model: the species file's, else the papers'.
    pub fn optics(&self) -> Optics {
        self.species.as_ref().and_then(|species| species.optics.clone()).unwrap_or_else(Optics::paper)
    }
}

/// A file's name without its extension, as a species' name.
pub fn file_name(path: &Path) -> Option<String> {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned())
}
