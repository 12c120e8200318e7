//! What `bake` and `pack` say at the end about each species and each stage.

use flb_format::container::records::{KIND_AVERAGES, KIND_BASE, KIND_BLOCKS, KIND_DETAIL};
use flb_format::provenance::SURFACE_PSNR_DB;
use flb_packer::EncodedSpecies;
use flb_packer::sections::EncodedSection;
use serde::Serialize;

use flb_baker::bake::base_list;

use crate::colors::ColorRow;
use crate::print::{self, line, say};
use crate::saving::PlanSavings;
use crate::size::{Areas, DoubtSaid, size_text};
use crate::stages::Stage;

/// One species in the summary of `bake` and `pack`.
#[derive(Serialize)]
pub(crate) struct SpeciesSummary {
    pub name: String,
    pub triangles: u64,
    pub leaf_triangles: u64,
    pub wood_triangles: u64,
    pub lattice: u32,
    pub sites_nonempty: u64,
    /// Width along x, height along y, depth along z.
    pub size_m: [f64; 3],
    /// Areas of leaves and wood; of `bake` alone, which has its mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub areas: Option<Areas>,
    /// Doubts about the plant; of `bake` alone, which has its mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubts: Option<Vec<DoubtSaid>>,
    /// Meaning of the texels of the plant's materials; of `bake` alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colours: Option<Vec<ColorRow>>,
    pub bases: Vec<u32>,
    /// All pages of the species as stored.
    pub bytes: u64,
    /// Bytes of the bases as plain 32-bit floats over the bytes that their pages take in the file.
    pub ratio: f64,
    /// Error of trilinear samples inside non-empty sites, each base relative to its own peak, all bases
    /// pooled; null where no sample has an error.
    pub surface_psnr_db: Option<f64>,
    /// Bases that missed the error that they were to be coded to, in words.
    pub missed: Vec<String>,
    /// Savings by a plan; null without one.
    pub plan: Option<PlanSavings>,
}

impl SpeciesSummary {
    /// Of a species that is ready to be written, with the number of its non-empty sites and what a plan saved.
    pub(crate) fn new(
        species: &EncodedSpecies,
        sites_nonempty: usize,
        plan: Option<PlanSavings>,
    ) -> SpeciesSummary {
        let meta = &species.meta;
        let of_base = |kind: u32| matches!(kind, KIND_BASE | KIND_BLOCKS | KIND_AVERAGES | KIND_DETAIL);
        let sections = species.sections.iter().filter(|section| of_base(section.kind));
        let first = |section: &&EncodedSection| matches!(section.kind, KIND_BASE | KIND_AVERAGES);
        let bases: Vec<u32> = sections.clone().filter(first).map(|section| section.item).collect();
        let stored = |sections: &mut dyn Iterator<Item = &EncodedSection>| -> u64 {
            sections.flat_map(|section| &section.pages).map(|page| page.stored.len() as u64).sum()
        };
        let plain_bytes = meta.grid.sites() * meta.band_count() * 4 * bases.len();
        SpeciesSummary {
            name: meta.name.clone(),
            triangles: meta.triangles.total,
            leaf_triangles: meta.triangles.leaf,
            wood_triangles: meta.triangles.wood,
            lattice: meta.grid.lattice,
            sites_nonempty: sites_nonempty as u64,
            size_m: std::array::from_fn(|axis| meta.bounds_m.max[axis] - meta.bounds_m.min[axis]),
            areas: None,
            doubts: None,
            colours: None,
            bytes: stored(&mut species.sections.iter()),
            ratio: plain_bytes as f64 / stored(&mut { sections }).max(1) as f64,
            bases,
            surface_psnr_db: meta.recorded(&SURFACE_PSNR_DB).flatten(),
            missed: species.missed().map(|m| m.to_string()).collect(),
            plan,
        }
    }

    /// Says on stderr how many bases missed their error, and one of them.
    pub(crate) fn say_missed(&self) {
        if let [first, others @ ..] = &self.missed[..] {
            let others = match others.len() {
                0 => String::new(),
                count => format!("; so do {count} other bases (--json lists them)"),
            };
            say!(
                "warning: species {:?} misses an error that it was to be coded to: {first}{others}",
                self.name
            );
        }
    }
}

/// Whether a species is worse than it was to be coded: a relative error in dark places, beside a mean one, is only
/// worth a warning.
pub(crate) fn misses_its_error(species: &EncodedSpecies) -> bool {
    species.missed().any(|missed| missed.is_loss())
}

/// One row per species.
pub(crate) fn species_table(species: &[SpeciesSummary]) -> String {
    let head = [
        "species",
        "metres",
        "triangles",
        "leaf",
        "wood",
        "lattice",
        "sites",
        "bases",
        "size",
        "ratio",
        "psnr dB",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    rows.extend(species.iter().map(|s| {
        vec![
            s.name.clone(),
            size_text(s.size_m),
            s.triangles.to_string(),
            s.leaf_triangles.to_string(),
            s.wood_triangles.to_string(),
            s.lattice.to_string(),
            s.sites_nonempty.to_string(),
            s.bases.len().to_string(),
            print::bytes(s.bytes),
            format!("{:.2}", s.ratio),
            s.surface_psnr_db.map_or("exact".to_owned(), |db| format!("{db:.1}")),
        ]
    }));
    print::table(&rows)
}

/// One row per stage, and their sum.
pub(crate) fn stage_table(stages: &[Stage]) -> String {
    let mut rows = vec![["stage", "seconds", "peak memory"].map(str::to_owned).to_vec()];
    let row = |name: &str, seconds: f64, peak: u64| {
        vec![name.to_owned(), format!("{seconds:.2}"), print::bytes(peak)]
    };
    rows.extend(stages.iter().map(|stage| {
        let cached = !stage.solves.is_empty() && stage.solves.iter().all(|solve| solve.cached);
        let name = if cached { format!("{} (cached)", stage.name) } else { stage.name.to_owned() };
        row(&name, stage.seconds, stage.peak_bytes)
    }));
    let seconds = stages.iter().map(|stage| stage.seconds).sum();
    rows.push(row("all", seconds, stages.iter().map(|stage| stage.peak_bytes).max().unwrap_or(0)));
    print::table(&rows)
}

/// One line for each species that a plan saved something of, behind an empty one; nothing without a plan.
pub(crate) fn saving_lines(species: &[SpeciesSummary]) -> String {
    let mut text = String::new();
    for species in species {
        let Some(saving) = &species.plan else { continue };
        let bands: String = saving.bands_left_out.iter().map(|band| format!(" {band}")).collect();
        let bands = if bands.is_empty() { bands } else { format!(" and bands{bands}") };
        text += "\n";
        text += &line!(
            "{}: left out bases {}{bands}: {} solves, about {} of the file, {} of memory",
            species.name,
            base_list(saving.bases_left_out),
            saving.solves_left_out,
            print::bytes(saving.file_bytes_left_out),
            print::bytes(saving.memory_bytes_left_out)
        );
    }
    text
}
