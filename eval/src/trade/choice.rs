//! What is tried: solves, and the codings of each.
//!
//! A solve has the settings of a bake, and is shown as the flags of `flb bake` that make them: a test of the command
//! holds the two together.

use std::fmt;

use flb_baker::bake::BakeSettings;
use flb_format::light::FieldKind;
use flb_format::{Codec, Quality};
use flb_packer::rate::Target;
use flb_packer::{CodingPreset, EncodeSettings};
use flb_transport::ordinates::{NamedSuns, Ordinates};

use super::transport::{COUNTED, Marched, PAPERS, Transport};

/// A bake up to its fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solve {
    /// Sites along each edge.
    pub lattice: u32,
    /// Model and settings.
    pub transport: Transport,
}

/// A coding of the fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Store {
    /// Codec of the fields.
    pub codec: Codec,
    /// Threshold of `haar-paper`, else 0.
    pub threshold: f32,
    /// PSNR that `classed` and `haar` are coded to, in dB; else 0.
    pub psnr_db: f64,
    /// Relative error in dark places that they are coded to; else 0.
    pub dark_error: f64,
}

/// A solve and its codings, none of them twice.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Solve of the fields.
    pub solve: Solve,
    /// Codings of the fields.
    pub stores: Vec<Store>,
}

/// Choice that was not tried.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Skipped {
    /// The solve, with its coding or with all of them.
    pub choice: String,
    /// Sites along each edge.
    pub lattice: u32,
    /// Reason why it was not tried.
    pub reason: String,
    /// Whether more memory would let it be tried.
    #[serde(skip)]
    pub is_of_memory: bool,
}

impl Skipped {
    /// A solve with one of its codings, or with all of them.
    pub(super) fn new(solve: &Solve, store: Option<&Store>, reason: String) -> Skipped {
        let choice = store.map_or(solve.to_string(), |store| format!("{solve} {store}"));
        Skipped { choice, lattice: solve.lattice, reason, is_of_memory: false }
    }
}

const RAW: Store = Store { codec: Codec::RawF32, threshold: 0.0, psnr_db: 0.0, dark_error: 0.0 };

/// Codings without an error to be chosen.
const RAW_STORES: [Store; 2] = [RAW, Store { codec: Codec::RawF16, ..RAW }];

impl Store {
    /// Settings of a bake that codes so.
    pub fn settings(&self) -> EncodeSettings {
        let Store { codec, threshold, psnr_db, dark_error: relative } = *self;
        let mut settings = EncodeSettings { codec, threshold, ..EncodeSettings::papers() };
        if codec.is_near_geometry() {
            (settings.target, settings.compress) = (Target::Both { psnr_db, relative }, true);
        }
        settings
    }

    /// The flags of `flb bake` that make it.
    pub fn flags(&self) -> String {
        match self.codec {
            Codec::Classed | Codec::Haar => {
                let Store { codec, psnr_db, dark_error, .. } = self;
                format!("--codec {} --target-psnr {psnr_db} --target-error {dark_error}", codec.name())
            }
            Codec::HaarPaper => format!("--codec haar-paper --threshold {}", self.threshold),
            Codec::RawF32 | Codec::RawF16 => format!("--codec {}", self.codec.name()),
        }
    }
}

fn physical(suns: NamedSuns, ordinates: Ordinates) -> Transport {
    Marched::new(suns, ordinates).into()
}

/// A solve on a lattice, with as many rays as that lattice gets where none are asked for.
fn solve(lattice: u32, transport: Transport) -> Solve {
    Solve { lattice, transport: transport.on(lattice) }
}

/// The solve that all others are compared with, of the finest lattice.
pub(super) fn finest(lattice: u32) -> Solve {
    solve(lattice, physical(NamedSuns::Sh3s, Ordinates::Lebedev110))
}

/// The solve of the papers' model that its other solves are compared with, of the finest lattice.
pub(super) fn finest_of_paper(lattice: u32) -> Solve {
    solve(lattice, PAPERS[0])
}

/// The coding that the finest solve is sampled from.
pub const FINEST_STORE: Store = RAW;

/// Largest lattice at which sites are cut: the memory is that of the next lattice and more.
const CUT_UP_TO: u32 = 64;

/// Largest lattice at which the papers' steps are counted: at 128 they take minutes.
const COUNTED_UP_TO: u32 = 64;

/// All choices, the finest lattice and its finest solve first, and the presets that no lattice of the list serves.
pub fn choices(lattices: &[u32], quick: bool) -> (Vec<Choice>, Vec<Skipped>) {
    let mut descending = lattices.to_vec();
    descending.sort_unstable_by(|a, b| b.cmp(a));
    let mut choices = Vec::new();
    for lattice in descending {
        for (transport, stores) in if quick { few() } else { many(lattice) } {
            add(&mut choices, solve(lattice, transport), &stores);
        }
    }
    let mut skipped = Vec::new();
    for quality in Quality::ALL {
        let (solve, store) = of_preset(quality);
        match lattices.contains(&solve.lattice) {
            true => add(&mut choices, solve, &[store]),
            false => skipped.push(Skipped {
                choice: format!("preset {}", quality.name()),
                lattice: solve.lattice,
                reason: format!("it bakes at lattice {}, which was not asked for", solve.lattice),
                is_of_memory: false,
            }),
        }
    }
    // Stable: a preset's own solve goes behind the others of its lattice.
    choices.sort_by_key(|choice| std::cmp::Reverse(choice.solve.lattice));
    (choices, skipped)
}

fn add(choices: &mut Vec<Choice>, solve: Solve, stores: &[Store]) {
    let at = choices.iter().position(|choice| choice.solve == solve).unwrap_or_else(|| {
        choices.push(Choice { solve, stores: Vec::new() });
        choices.len() - 1
    });
    for store in stores {
        if !choices[at].stores.contains(store) {
            choices[at].stores.push(*store);
        }
    }
}

/// What a preset bakes.
fn of_preset(quality: Quality) -> (Solve, Store) {
    let transport = Marched::of_preset(quality).into();
    (solve(BakeSettings::of(quality).lattice, transport), coded(quality))
}

/// The presets that bake just this.
pub(super) fn presets_of(solve: &Solve, store: &Store) -> Vec<&'static str> {
    let same = |quality: &Quality| of_preset(*quality) == (*solve, *store);
    Quality::ALL.iter().filter(|quality| same(quality)).map(|quality| quality.name()).collect()
}

fn coded(quality: Quality) -> Store {
    let CodingPreset { psnr_db, dark_error, .. } = CodingPreset::of(quality);
    Store { codec: Codec::Classed, psnr_db, dark_error, ..RAW }
}

fn papers(quality: Quality) -> Store {
    Store { codec: Codec::HaarPaper, threshold: CodingPreset::of(quality).threshold, ..RAW }
}

fn all_stores() -> Vec<Store> {
    let haar = Store { codec: Codec::Haar, ..coded(Quality::Standard) };
    Quality::ALL
        .map(coded)
        .into_iter()
        .chain([haar])
        .chain(Quality::ALL.map(papers))
        .chain(RAW_STORES)
        .collect()
}

fn few() -> Vec<(Transport, Vec<Store>)> {
    let usual = || vec![coded(Quality::Standard)];
    vec![
        (physical(NamedSuns::Sh3s, Ordinates::Lebedev110), vec![coded(Quality::Standard), RAW]),
        (physical(NamedSuns::Sh2s, Ordinates::Lebedev110), all_stores()),
        (
            physical(NamedSuns::Sh1s, Ordinates::Lebedev50),
            vec![coded(Quality::Draft), coded(Quality::Standard)],
        ),
        (physical(NamedSuns::Sh2, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Ico42, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Lattice18, Ordinates::Lattice18), usual()),
        (PAPERS[0], vec![FINEST_STORE]),
        (PAPERS[1], vec![coded(Quality::Standard), papers(Quality::Draft)]),
    ]
}

fn many(lattice: u32) -> Vec<(Transport, Vec<Store>)> {
    let usual = || vec![coded(Quality::Standard), coded(Quality::Fine)];
    let coarse = || [Quality::Draft, Quality::Standard, Quality::Fine].map(coded).to_vec();
    let by_default = |suns| Marched::new(suns, Ordinates::Lebedev110);
    let mut all = vec![
        (physical(NamedSuns::Sh3s, Ordinates::Lebedev110), coarse().into_iter().chain([RAW]).collect()),
        (physical(NamedSuns::Sh2s, Ordinates::Lebedev110), all_stores()),
        (
            Marched { field: FieldKind::Total, ..by_default(NamedSuns::Sh2s) }.into(),
            usual().into_iter().chain([RAW]).collect(),
        ),
        (Marched { tolerance: 2e-2, ..by_default(NamedSuns::Sh2s) }.into(), usual()),
        (physical(NamedSuns::Sh2s, Ordinates::Lebedev50), usual()),
        (physical(NamedSuns::Sh1s, Ordinates::Lebedev110), coarse()),
        (physical(NamedSuns::Sh1s, Ordinates::Lebedev50), coarse()),
        (physical(NamedSuns::Sh3, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Sh2, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Sh1, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Ico42, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Ico12, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Lattice18, Ordinates::Lebedev110), usual()),
        (physical(NamedSuns::Lattice18, Ordinates::Lattice18), usual()),
        (PAPERS[0], vec![FINEST_STORE]),
        (PAPERS[1], all_stores()),
        (PAPERS[2], usual()),
    ];
    if lattice <= COUNTED_UP_TO {
        all.push((COUNTED, vec![coded(Quality::Standard)]));
    }
    if lattice <= CUT_UP_TO {
        all.push((Marched { parts: 2, ..by_default(NamedSuns::Sh3s) }.into(), usual()));
    }
    all
}

impl Solve {
    /// The flags of `flb bake` that make it.
    pub fn flags(&self) -> String {
        let start = format!("--model {} --lattice {}", self.transport.name(), self.lattice);
        let end = match self.transport.steps() {
            Some(steps) => format!("--solver explicit --steps {steps}"),
            None => format!("--tolerance {}", self.transport.tolerance()),
        };
        let Some(marched) = self.transport.marched() else { return format!("{start} {end}") };
        let Marched { suns, ordinates, rays, parts, field, .. } = marched;
        format!(
            "{start} --suns {} --ordinates {} --rays {rays}{} --field {} {end}",
            suns.name(),
            ordinates.count(),
            if *parts > 1 { " --cut-sites" } else { "" },
            field.name(),
        )
    }

    /// The settings of its bake.
    pub fn settings(&self, voxels: u32, ignore_alpha: bool) -> BakeSettings {
        let model = self.transport.settings();
        BakeSettings { lattice: self.lattice, voxels, ignore_alpha, model, ..BakeSettings::default() }
    }

    /// Whether its light holds the sun's beam.
    pub(super) fn holds_beam(&self) -> bool {
        self.transport.field() == FieldKind::Total
    }
}

impl fmt::Display for Solve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.transport.name(), self.lattice)?;
        if let Some(Marched { suns, ordinates, rays, parts, field, .. }) = self.transport.marched() {
            write!(f, " {}/{}", suns.name(), ordinates.count())?;
            if *rays > 1 {
                write!(f, " rays {rays}")?;
            }
            if *parts > 1 {
                f.write_str(" cut")?;
            }
            if *field == FieldKind::Total {
                f.write_str(" total")?;
            }
        }
        match self.transport.steps() {
            Some(steps) => write!(f, " {steps} steps"),
            None => write!(f, " tol {}", self.transport.tolerance()),
        }
    }
}

impl fmt::Display for Store {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.codec {
            Codec::HaarPaper => write!(f, "{} {}", self.codec.name(), self.threshold),
            Codec::Classed | Codec::Haar => write!(f, "{} {} dB", self.codec.name(), self.psnr_db),
            _ => f.write_str(self.codec.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_choice_comes_twice_and_the_finest_is_the_first() {
        for quick in [false, true] {
            let (choices, skipped) = choices(&[32, 64, 128, 256], quick);
            assert_eq!(skipped, []);
            assert_eq!(choices[0].solve, finest(256));
            assert!(choices[0].stores.contains(&FINEST_STORE));
            for (at, choice) in choices.iter().enumerate() {
                assert!(choices[..at].iter().all(|other| other.solve != choice.solve), "{}", choice.solve);
                assert!(!choice.stores.is_empty());
                let twice = |i: usize| choice.stores[..i].contains(&choice.stores[i]);
                assert!(!(0..choice.stores.len()).any(twice), "{}", choice.solve);
            }
        }
    }

    #[test]
    fn every_preset_is_a_row_where_its_lattice_is_tried() {
        let (choices, skipped) = choices(&[16, 32], true);
        let rows = choices
            .iter()
            .flat_map(|choice| choice.stores.iter().map(|store| presets_of(&choice.solve, store)));
        assert_eq!(rows.flatten().collect::<Vec<_>>(), ["draft"]);
        let left: Vec<&str> = skipped.iter().map(|skipped| skipped.choice.as_str()).collect();
        assert_eq!(left, ["preset standard", "preset fine", "preset reference"]);
    }
}
