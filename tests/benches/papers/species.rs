//! The five species of the papers' forest, Table 6.4: their stand-ins, grown, baked and coded.

use flb_baker::bake::{BakeSettings, ModelSettings, NoStore, PaperSettings, bake};
use flb_fixtures::{PlantKind, grow};
use flb_format::{Codec, Quality, SpeciesFields};
use flb_packer::{EncodeSettings, StoredBlocks, encode_species, write_library_to};
use flb_runtime::Library;
use flb_scene::{ClassedMesh, PlantReader, Unobserved};
use flb_tests::pipeline::import_glb;
use flb_transport::lattice::SolverKind;

use crate::Scale;

/// A species of the papers, and the plant that we grow in its place.
pub(crate) struct Sort {
    pub theirs: &'static str,
    kind: PlantKind,
    seed: u64,
    triangles: u32,
    pub instances: usize,
    their_mb: u32,
}

const fn oak(theirs: &'static str, seed: u64, triangles: u32, instances: usize, their_mb: u32) -> Sort {
    Sort { theirs, kind: PlantKind::Oak, seed, triangles, instances, their_mb }
}

pub(crate) static FOREST: [Sort; 5] = [
    oak("Red Maple", 2, 115_529, 20, 81),
    oak("Ohio Buckeye", 3, 168_520, 89, 64),
    oak("Paper Birch", 4, 372_896, 81, 63),
    oak("Southern Catalpa (adult)", 5, 155_342, 74, 77),
    oak("Southern Catalpa (medium)", 1, 316_767, 160, 81),
];

/// Names of the ways to keep light that are timed, in the order of [`Plant::files`].
pub(crate) const WAYS: [&str; 3] = ["floats", "`haar-paper`", "`classed`"];

/// A baked species.
pub(crate) struct Plant {
    pub sort: &'static Sort,
    pub instances: usize,
    pub mesh: ClassedMesh,
    /// Its light as each of [`WAYS`].
    pub files: [Library; 3],
    /// Their bytes, and those of `haar-paper` with all blocks.
    bytes: [usize; 4],
}

impl Plant {
    /// Grows and bakes as `--quality papers` does, but that sweeps solve: to 1e-4, in a 57th of the time.
    pub(crate) fn bake(sort: &'static Sort, scale: &Scale) -> (Plant, SpeciesFields) {
        let triangles = (f64::from(sort.triangles) * scale.share) as u32;
        let glb = grow(sort.kind, sort.seed, triangles).expect("a count within the limits").to_glb();
        let reader = PlantReader::default();
        let (mesh, _) = reader.class(import_glb(sort.theirs, &glb)).expect("the fixtures' names are known");
        let plant = reader.plant(sort.theirs.to_owned(), mesh.clone());
        let papers =
            PaperSettings { solver: SolverKind::Sweep, steps: None, ..PaperSettings::of(Quality::Papers) };
        let settings = BakeSettings {
            lattice: scale.lattice,
            voxels: scale.voxels,
            model: ModelSettings::Paper(papers),
            ..BakeSettings::of(Quality::Papers)
        };
        let fields = bake(plant, &settings, &NoStore, &Unobserved).expect("a good plant").fields;
        let haar_paper = EncodeSettings::of(Quality::Papers, Codec::HaarPaper);
        let coded = [
            EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() },
            EncodeSettings { blocks: StoredBlocks::NearGeometry, ..haar_paper.clone() },
            EncodeSettings::of(Quality::Standard, Codec::Classed),
            haar_paper,
        ]
        .map(|settings| file(&fields, &settings));
        let bytes = [0, 1, 2, 3].map(|way: usize| coded[way].len());
        let [raw, near, classed, _] = coded;
        let files = [raw, near, classed].map(|bytes| {
            Library::from_source(sort.theirs, Box::new(bytes)).expect("a file that was just written")
        });
        let instances = (sort.instances as f64 * scale.share).ceil() as usize;
        (Plant { sort, instances, mesh, files, bytes }, fields)
    }

    pub(crate) fn triangles(&self) -> usize {
        self.mesh.mesh.triangles.len()
    }
}

fn file(fields: &SpeciesFields, settings: &EncodeSettings) -> Vec<u8> {
    let encoded = encode_species(fields, settings, &|_| Ok(())).expect("fields that were solved");
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&encoded]).expect("memory takes it");
    bytes
}

/// Table 6.4.
pub(crate) fn table(plants: &[Plant]) {
    println!("Table 6.4, MB of 10^6 bytes; the plants of ours are grown oaks:\n");
    println!(
        "| theirs | instances | triangles | their MB | floats | `haar-paper`, all blocks | near geometry | `classed` |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    let cells = |bytes: [f64; 4]| {
        let [raw, near, classed, all] = bytes.map(|bytes| bytes / 1e6);
        format!("{raw:.0} | {all:.1} | {near:.1} | {classed:.2}")
    };
    let mut sum = ([0.0; 4], 0, 0);
    for plant in plants {
        let bytes = plant.bytes.map(|bytes| bytes as f64);
        let Sort { theirs, their_mb, .. } = plant.sort;
        println!(
            "| {theirs} | {} | {} | {their_mb} | {} |",
            plant.instances,
            plant.triangles(),
            cells(bytes)
        );
        sum = (
            [0, 1, 2, 3].map(|i: usize| sum.0[i] + bytes[i]),
            sum.1 + plant.instances,
            sum.2 + plant.instances * plant.triangles(),
        );
    }
    println!("| all | {} | {} | 366 | {} |\n", sum.1, sum.2, cells(sum.0));
}
