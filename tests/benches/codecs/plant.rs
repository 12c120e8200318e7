//! The fields that are coded.

use std::path::Path;

use flb_baker::{VoxelSettings, downsample, voxelise};
use flb_fixtures::{PlantKind, grow};
use flb_format::matter::{Class, Optics};
use flb_format::{Container, Field, SpeciesFields};
use flb_scene::classify::classify;
use flb_scene::{ClassRules, MaterialClass};
use flb_tests::pipeline::{SEED, import_glb, species_meta};
use flb_transport::lattice::{SolveSettings, solve};

pub(crate) struct Plant {
    pub lattice: u32,
    pub non_empty: Vec<bool>,
    pub fields: SpeciesFields,
}

impl Plant {
    fn new(fields: SpeciesFields) -> Plant {
        let non_empty = fields.medium.class.iter().map(|class| *class != Class::Empty).collect();
        Plant { lattice: fields.medium.grid.lattice, non_empty, fields }
    }

    pub(crate) fn bases(&self) -> &[(u8, Field)] {
        &self.fields.bases
    }
}

/// The built-in oak, solved with the papers' model.
pub(crate) fn oak(lattice: u32) -> Plant {
    let kind = PlantKind::Oak;
    let plant = grow(kind, SEED, kind.default_triangles()).expect("the count is within the limits");
    let mesh = import_glb(kind.name(), &plant.to_glb());
    let classified = classify(&mesh, &ClassRules::default()).expect("the fixtures' names are known");
    let classes: Vec<MaterialClass> = classified.iter().map(|c| c.class).collect();
    let settings = VoxelSettings { voxels: 1024, lattice, ignore_alpha: false };
    let occupancy = voxelise(&mesh, &classes, &settings, &|_| Ok(())).expect("a plant has triangles");
    let medium = downsample(&occupancy).expect("an occupancy of voxelise downsamples");
    let settings = SolveSettings::default();
    let solution = solve(&medium, &Optics::paper(), &settings, &|_| Ok(())).expect("the medium is valid");
    let meta = species_meta(kind.name(), &mesh, &classes, &medium);
    Plant::new(SpeciesFields { meta, medium, turbid: None, bases: solution.bases })
}

/// The first species of a file.
pub(crate) fn read(path: &Path) -> Plant {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let container = Container::open(&bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Plant::new(flb_packer::load_species(&container, &bytes, 0).expect("a file of kept fields"))
}
