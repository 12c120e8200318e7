//! `flb grow`: a built-in plant as a GLB file.

use flb_files::publish;
use flb_fixtures::{autumn, grow, potted};
use serde::Serialize;

use crate::args::GrowArgs;
use crate::exit::Failure;
use crate::inputs::check_output;
use crate::print::{self, line};

#[derive(Serialize)]
struct Grown {
    plant: &'static str,
    seed: u64,
    autumn: bool,
    potted: bool,
    triangles: usize,
    bytes: usize,
    output: String,
}

/// Grows, writes, says what was written.
pub(crate) fn run(args: &GrowArgs) -> Result<u8, Failure> {
    check_output(&args.output, &[], args.existing)?;
    let kind = args.plant;
    let plant = kind.name();
    let grown = grow(kind, args.seed, args.triangles.unwrap_or(kind.default_triangles()))?;
    let grown = if args.autumn { autumn(grown) } else { grown };
    let grown = if args.potted { potted(grown) } else { grown };
    let glb = grown.to_glb();
    publish(&args.output, args.existing, |file| file.write_all(&glb))?;
    let season = if args.autumn { " in autumn" } else { "" };
    let place = if args.potted { " in a pot" } else { "" };
    let summary = Grown {
        plant,
        seed: args.seed,
        autumn: args.autumn,
        potted: args.potted,
        triangles: grown.triangle_count(),
        bytes: glb.len(),
        output: args.output.display().to_string(),
    };
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&line!(
            "{}: {plant}{place}{season}, seed {}, {} triangles, {}",
            summary.output,
            summary.seed,
            summary.triangles,
            print::bytes(summary.bytes as u64)
        ))?,
    }
    Ok(0)
}
