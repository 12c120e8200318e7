//! `flb migrate`: a file of an older version of the format, rewritten as the present one.

use flb_format::container::records::version_of;
use flb_inspector::Level;
use flb_packer::{Copier, EncodedSpecies, write_library};
use flb_runtime::Location;
use serde::Serialize;

use crate::args::MigrateArgs;
use crate::exit::Failure;
use crate::inputs::{check_output_of, open_location};
use crate::print::{self, line, say};
use crate::validate::{demand, look_at};

#[derive(Serialize)]
struct Summary {
    output: String,
    /// Version of the input.
    from: String,
    /// Version of the output.
    to: String,
    species: Vec<String>,
    /// Bytes of the input.
    bytes_before: u64,
    /// Bytes of the output.
    bytes: u64,
    /// Sections that only their writer understands and that may not be copied.
    dropped: Vec<String>,
}

/// Checks the whole input, takes every page over as it is coded, writes the output.
pub(crate) fn run(args: &MigrateArgs) -> Result<u8, Failure> {
    check_output_of(&args.output, &[&args.input], args.existing)?;
    let location = Location::parse(&args.input)?;
    let library = open_location(&location)?;
    let (container, source, path) = (library.container(), library.source(), library.path());
    // What is wrong in the old file must not look sound in a new one.
    demand(&location, &look_at(&location, source, Level::Decode)?)?;
    let count = container.species().len();
    let mut copier = Copier::new(container, source);
    let copied: Vec<EncodedSpecies> = (0..count)
        .map(|index| copier.species(index))
        .collect::<Result<_, _>>()
        .map_err(|error| Failure::from(error).at(path))?;
    let bytes = write_library(&args.output, &copied.iter().collect::<Vec<_>>(), args.existing)?;
    let version = |(major, minor): (u16, u16)| format!("{major}.{minor}");
    let dropped = copied.iter().flat_map(|species| {
        species.dropped.iter().map(|key| format!("{key}, of species {}", species.meta.name))
    });
    let summary = Summary {
        output: args.output.display().to_string(),
        from: version(container.format_version()),
        to: version(version_of(container.header().required_features)),
        species: copied.iter().map(|species| species.meta.name.clone()).collect(),
        bytes_before: container.header().file_bytes,
        bytes,
        dropped: dropped.chain(copier.of_the_file().iter().map(|key| key.to_string())).collect(),
    };
    for key in &summary.dropped {
        say!("left out {key}, which only its writer understands");
    }
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&line!(
            "{}: version {} to {}, {} species, {} to {}",
            summary.output,
            summary.from,
            summary.to,
            summary.species.len(),
            print::bytes(summary.bytes_before),
            print::bytes(summary.bytes)
        ))?,
    }
    Ok(0)
}
