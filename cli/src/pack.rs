//! `flb pack`: encode fields again, or merge species into one library; never solves.

use flb_format::Codec;
use flb_packer::{EncodeSettings, EncodedSpecies, copy_species, encode_species, load_species, write_library};
use flb_runtime::Library;
use serde::Serialize;

use crate::args::{CodecArg, PackArgs};
use crate::exit::{Failure, USAGE};
use crate::inputs::check_output;
use crate::print;
use crate::stages::{Stage, Stages};
use crate::summary::{SpeciesSummary, sites_nonempty, species_table};

#[derive(Serialize)]
struct Summary {
    output: String,
    bytes: u64,
    stages: Vec<Stage>,
    species: Vec<SpeciesSummary>,
}

/// Loads or copies every species of every input, writes them as one library.
pub fn run(args: &PackArgs) -> Result<u8, Failure> {
    let inputs: Vec<&std::path::Path> = args.inputs.iter().map(|path| path.as_path()).collect();
    check_output(&args.output, &inputs, args.force)?;
    let settings = settings(args)?;
    let mut stages = Stages::default();
    let mut coded: Vec<EncodedSpecies> = Vec::new();
    let mut summaries = Vec::new();
    for path in &args.inputs {
        let library = Library::open_positioned(path)?;
        let (container, source) = (library.container(), library.source());
        for (index, species) in container.species().iter().enumerate() {
            let name = &species.meta.name;
            let at_input = |error| Failure::from(error).at(path);
            let (species, sites) = match &settings {
                None => {
                    let copied = stages
                        .run("copy", name, |_| copy_species(container, source, index))
                        .map_err(at_input)?;
                    let medium =
                        container.read_medium(source, index).map_err(|e| Failure::from(e).at(path))?;
                    (copied, sites_nonempty(&medium))
                }
                Some(settings) => {
                    if species.bases.iter().any(|base| base.threshold > 0.0) {
                        eprintln!(
                            "flb: warning: {}: species {name:?} has lost detail already (threshold above 0): losses add up; pack from kept fields instead",
                            path.display()
                        );
                    }
                    let fields = stages
                        .run("load", name, |_| load_species(container, source, index))
                        .map_err(at_input)?;
                    let encode =
                        |progress: &(dyn Fn(f64) + Sync)| encode_species(&fields, settings, progress);
                    (stages.run("encode", name, encode).map_err(at_input)?, sites_nonempty(&fields.medium))
                }
            };
            summaries.push(SpeciesSummary::new(&species, sites));
            coded.push(species);
        }
    }
    for species in &coded {
        for key in &species.dropped {
            eprintln!(
                "flb: species {}: left out {key}, which only its writer understands",
                species.meta.name
            );
        }
    }
    let list: Vec<&EncodedSpecies> = coded.iter().collect();
    let bytes = stages.run("write", "", |_| write_library(&args.output, &list, args.force))?;
    let summary = Summary {
        output: args.output.display().to_string(),
        bytes,
        stages: stages.list().to_vec(),
        species: summaries,
    };
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&format!(
            "{}\n{}: {}\n",
            species_table(&summary.species),
            summary.output,
            print::bytes(summary.bytes)
        ))?,
    }
    Ok(0)
}

/// `None`: copy species as they are. That is what merging means unless a coding flag asks for more.
fn settings(args: &PackArgs) -> Result<Option<EncodeSettings>, Failure> {
    let coding = &args.coding;
    let asked =
        coding.threshold.is_some() || coding.quality.is_some() || coding.compress || args.codec.is_some();
    if args.inputs.len() > 1 && !asked {
        return Ok(None);
    }
    let codec = match args.codec {
        Some(CodecArg::RawF32) => Codec::RawF32,
        None | Some(CodecArg::HaarPaper) => Codec::HaarPaper,
    };
    if codec == Codec::RawF32 && (coding.threshold.is_some() || coding.quality.is_some()) {
        return Err(Failure::new(
            USAGE,
            "--codec raw-f32 keeps every value; it takes no --threshold or --quality",
        ));
    }
    let threshold = if codec == Codec::RawF32 { 0.0 } else { coding.threshold() };
    Ok(Some(EncodeSettings { codec, threshold, compress: coding.compress, ..EncodeSettings::default() }))
}
