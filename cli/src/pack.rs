//! `flb pack`: encode fields again, or merge species into one library; never solves.

use std::path::Path;

use flb_baker::plan::Plan;
use flb_format::Codec;
use flb_format::bases::BaseSet;
use flb_format::container::Species;
use flb_format::progress::Progress;
use flb_packer::leave_out::{keep_bases, keep_coded_bases};
use flb_packer::{Copier, EncodeSettings, EncodedSpecies, encode_species, load_species, write_library};
use flb_scene::Step;
use serde::Serialize;

use crate::args::PackArgs;
use crate::exit::{Failure, LOSS, USAGE};
use crate::inputs::{check_output_of, open};
use crate::memory::{check, fields_bytes};
use crate::plan::check_known;
use crate::print::{self, line, say};
use crate::saving::PlanSavings;
use crate::stages::{Stage, Stages};
use crate::summary::{SpeciesSummary, misses_its_error, saving_lines, species_table};
use flb_baker::bake::why_whole;

#[derive(Serialize)]
struct Summary {
    output: String,
    bytes: u64,
    stages: Vec<Stage>,
    species: Vec<SpeciesSummary>,
}

/// Loads or copies every species of every input, writes them as one library.
pub(crate) fn run(args: &PackArgs) -> Result<u8, Failure> {
    let mut inputs: Vec<&Path> = args.inputs.iter().map(|path| path.as_path()).collect();
    inputs.extend(args.plan.as_deref());
    check_output_of(&args.output, &inputs, args.existing)?;
    let settings = settings(args)?;
    let plan = args.plan.as_deref().map(Plan::read).transpose()?;
    let stages = Stages::default();
    let mut coded: Vec<EncodedSpecies> = Vec::new();
    let mut summaries = Vec::new();
    for input in &args.inputs {
        let library = open(input)?;
        let path = library.path();
        let (container, source) = (library.container(), library.source());
        if let Some((plan, file)) = plan.as_ref().zip(args.plan.as_deref()) {
            let names: Vec<String> = container.species().iter().map(|s| s.meta.name.clone()).collect();
            check_known(plan, &names).map_err(|failure| failure.at(file))?;
        }
        let mut copier = Copier::new(container, source);
        for key in copier.of_the_file() {
            say!("{}: left out {key}, which only its writer understands", path.display());
        }
        for (index, species) in container.species().iter().enumerate() {
            let name = &species.meta.name;
            let at_input = |error| Failure::from(error).at(path);
            // A plan can spare fields of lattice directions only.
            let whole = species.meta.physical().filter(|_| species.meta.model.needs_all_items());
            if let Some((_, light)) = whole.filter(|_| plan.is_some()) {
                say!("{name}: {}, so all are kept", why_whole(&light.suns));
            }
            let plan = plan.as_ref().filter(|_| whole.is_none());
            let keep = plan.map(|plan| kept(plan, species, path)).transpose()?;
            let saving = keep.map(|keep| PlanSavings::of_pack(species, keep));
            let (species, sites) = match &settings {
                None => {
                    let mut copied =
                        stages.run(Step::Copy, name, |_| copier.species(index)).map_err(at_input)?;
                    if let Some((keep, plan)) = keep.zip(plan) {
                        keep_coded_bases(&mut copied, keep, &plan.reason).map_err(at_input)?;
                    }
                    let medium =
                        container.read_medium(source, index).map_err(|e| Failure::from(e).at(path))?;
                    (copied, medium.nonempty_sites())
                }
                Some(settings) => {
                    if let Some(loss) = loss(species, settings.codec) {
                        say!(
                            "warning: {}: species {name:?} has lost detail already ({loss}): losses add up; pack from kept fields instead",
                            path.display()
                        );
                    }
                    let needed = fields_bytes(species).saturating_add(stored_bytes(&coded));
                    check(&library, &format!("the fields of species {name:?}"), needed, &args.memory)?;
                    let mut fields = stages
                        .run(Step::Load, name, |_| load_species(container, source, index))
                        .map_err(at_input)?;
                    if let Some((keep, plan)) = keep.zip(plan) {
                        keep_bases(&mut fields, keep, &plan.reason);
                    }
                    let encode = |progress: &Progress<'_>| encode_species(&fields, settings, progress);
                    (
                        stages.run(Step::Encode, name, encode).map_err(at_input)?,
                        fields.medium.nonempty_sites(),
                    )
                }
            };
            summaries.push(SpeciesSummary::new(&species, sites, saving));
            coded.push(species);
        }
    }
    for species in &coded {
        for key in &species.dropped {
            say!("species {}: left out {key}, which only its writer understands", species.meta.name);
        }
    }
    let list: Vec<&EncodedSpecies> = coded.iter().collect();
    let bytes = stages.run(Step::Write, "", |_| write_library(&args.output, &list, args.existing))?;
    let summary = Summary {
        output: args.output.display().to_string(),
        bytes,
        stages: stages.list(),
        species: summaries,
    };
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&format!(
            "{}{}\n{}",
            species_table(&summary.species),
            saving_lines(&summary.species),
            line!("{}: {}", summary.output, print::bytes(summary.bytes))
        ))?,
    }
    summary.species.iter().for_each(SpeciesSummary::say_missed);
    let missed = args.coding.recipe(args.quality).asks_for_error() && coded.iter().any(misses_its_error);
    Ok(if missed { LOSS } else { 0 })
}

/// Bytes of what was coded so far.
fn stored_bytes(coded: &[EncodedSpecies]) -> u64 {
    let pages = coded.iter().flat_map(|species| &species.sections).flat_map(|section| &section.pages);
    pages.map(|page| page.stored.len() as u64).sum()
}

/// The bases of a species that a plan keeps. Refuses a file that lacks one of them; says what packing cannot change.
fn kept(plan: &Plan, species: &Species, path: &Path) -> Result<BaseSet, Failure> {
    let name = &species.meta.name;
    let share = plan.share(name)?;
    let present: BaseSet = species.bases.iter().map(|base| base.base).collect();
    let lacking = share.bases.intersection(present.missing());
    if !lacking.is_empty() {
        let message =
            format!("species {name:?} lacks bases {lacking:?}, which the plan needs: bake it again");
        return Err(Failure::new(USAGE, message).at(path));
    }
    let lattice = species.meta.grid.lattice;
    if let Some(planned) = share.lattice.filter(|planned| *planned != lattice) {
        say!(
            "warning: {}: species {name:?} stays at lattice {lattice}, the plan says {planned}: only a bake changes it",
            path.display()
        );
    }
    let unwanted = |band: &&str| plan.bands.as_ref().is_some_and(|b| !b.iter().any(|name| name == band));
    for band in species.meta.bands().filter(unwanted) {
        say!(
            "warning: {}: species {name:?} keeps band {band:?}, which the plan leaves out: only a bake drops it",
            path.display()
        );
    }
    Ok(share.bases)
}

/// What an earlier coding took from a species, if it took anything that `codec` will not take alike.
fn loss(species: &Species, codec: Codec) -> Option<&'static str> {
    if species.bases.iter().any(|base| base.threshold > 0.0) {
        return Some("threshold above 0");
    }
    if species.bases.iter().any(|base| base.codec.is_near_geometry()) {
        return Some("quantised");
    }
    let rounded = species.bases.iter().any(|base| base.codec == Codec::RawF16);
    (rounded && codec != Codec::RawF16).then_some("rounded to raw-f16")
}

/// `None`: copy species as they are. That is what merging means unless a coding flag asks for more.
fn settings(args: &PackArgs) -> Result<Option<EncodeSettings>, Failure> {
    let recipe = args.coding.recipe(args.quality);
    if args.inputs.len() > 1 && args.quality.is_none() && !recipe.asks_for_coding() {
        return Ok(None);
    }
    let codec = recipe.codec();
    if args.quality.is_some() && matches!(codec, Codec::RawF32 | Codec::RawF16) {
        let message = format!("--codec {} drops no detail; it takes no --quality", codec.name());
        return Err(Failure::new(USAGE, message));
    }
    Ok(Some(recipe.encode_settings()?))
}
