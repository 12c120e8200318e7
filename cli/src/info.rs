//! `flb info`: what is in a file.

use flb_format::light::SunBasis;
use flb_format::material_surface::Texel;
use flb_format::matter::ClassOptics;
use flb_inspector::info::{Info, LightInfo, SpeciesInfo, info};
use serde::Serialize;

use crate::args::InfoArgs;
use crate::exit::Failure;
use crate::inputs::open;
use crate::print::{self, line, say};

#[derive(Serialize)]
struct Described<'a> {
    /// As it was named.
    file: String,
    /// What was fetched to find this out; null for a file on this machine.
    remote: Option<Fetched>,
    #[serde(flatten)]
    info: &'a Info,
}

#[derive(Serialize)]
struct Fetched {
    requests: u64,
    bytes: u64,
}

/// Opens, which checks header and tables; prints.
pub(crate) fn run(args: &InfoArgs) -> Result<u8, Failure> {
    let library = open(&args.file)?;
    let found = info(library.container());
    let remote = library.traffic().map(|all| Fetched { requests: all.requests, bytes: all.bytes });
    let file = library.path().display().to_string();
    if let Some(Fetched { requests, bytes }) = &remote {
        say!("{file}: read {bytes} bytes in {requests} request{}", if *requests == 1 { "" } else { "s" });
    }
    match args.json {
        true => print::json(&Described { file, remote, info: &found })?,
        false => print::out(&text(&found))?,
    }
    Ok(0)
}

fn text(found: &Info) -> String {
    let [file, tables] = [found.file_bytes, found.tables_bytes].map(print::bytes);
    let mut text = line!("format version {}, {file}, of which tables {tables}", found.format_version);
    text += &line!("root {}", found.root);
    for species in &found.species {
        let [low, high] = species.bounds;
        let extent = |axis: usize| format!("{:.3}", high[axis] - low[axis]);
        let list: Vec<String> = species.bases.iter().map(u8::to_string).collect();
        text += "\n";
        text += &line!("species {}", species.name);
        let left_out = species.left_out.as_ref().map_or("nothing".to_owned(), |left_out| {
            let bases = left_out.bases.iter().map(|base| base.to_string());
            let names = left_out.bands.iter().map(|band| format!("band {band}"));
            format!("{}: {}", bases.chain(names).collect::<Vec<_>>().join(" "), left_out.reason)
        });
        let on_mesh = match (&species.light, &species.mesh_error) {
            (None, _) => "not known: flb judge reads physical files".to_owned(),
            (Some(_), None) => {
                "not judged: flb bake --judge keeps it, flb judge --mesh MESH tells".to_owned()
            }
            (Some(_), Some(error)) => print::mesh_error(error),
        };
        let rows = [
            ("on mesh", on_mesh),
            ("model", species.model.clone()),
            ("lattice", format!("{0} x {0} x {0}, {1:.4} m apart", species.lattice, species.spacing_m)),
            ("extent", format!("{} x {} x {} m", extent(0), extent(1), extent(2))),
            (
                "triangles",
                format!(
                    "{}, {} leaf, {} wood",
                    species.triangles[0], species.triangles[1], species.triangles[2]
                ),
            ),
            ("mesh", species.mesh_blake3.clone().unwrap_or_else(|| "not said".to_owned())),
            ("bands", species.bands.join(" ")),
            ("bases", list.join(" ")),
            ("left out", left_out),
            ("codec", coding(species)),
            (
                "size",
                format!(
                    "{}{}, {:.2} times smaller than plain floats",
                    print::bytes(species.bytes),
                    match species.shared_bytes {
                        0 => String::new(),
                        shared => format!(", of which {} stored once with others", print::bytes(shared)),
                    },
                    species.ratio
                ),
            ),
            ("made by", species.tool.clone()),
            ("settings", settings(species)),
        ];
        let light = species.light.iter().flat_map(light_rows);
        let colours = species.light.is_some().then(|| ("colours", colours(species)));
        let rows = rows.into_iter().chain(matter(species)).chain(colours).chain(light);
        rows.for_each(|(key, value)| text += &line!("  {key:<10} {value}"));
    }
    let mut rows =
        vec![["section", "species", "item", "codec", "pages", "offset", "bytes"].map(str::to_owned).to_vec()];
    rows.extend(found.sections.iter().map(|s| {
        vec![
            s.kind.clone(),
            s.species.to_string(),
            s.item.to_string(),
            s.codec.clone(),
            s.pages.to_string(),
            s.offset.to_string(),
            s.bytes.to_string(),
        ]
    }));
    text + "\n" + &print::table(&rows)
}

/// Bands that a table shows one by one; of more, `--json` tells.
const MAX_BAND_ROWS: usize = 6;

/// What leaf and wood do to light in each band.
fn matter(species: &SpeciesInfo) -> Vec<(&'static str, String)> {
    if species.bands.len() > MAX_BAND_ROWS {
        return vec![("matter", format!("of {} bands: see --json", species.bands.len()))];
    }
    let optics = species.optics.iter().flat_map(|optics| &optics.bands).map(|band| {
        let of = |class: &ClassOptics| format!("absorbs {}, g {}", digits(class.sigma_a), digits(class.g));
        ("optics", format!("{}: leaf {}; wood {}", band.name, of(&band.leaf), of(&band.wood)))
    });
    let surfaces = species.surfaces.iter().flat_map(|surfaces| &surfaces.bands).map(|band| {
        let [reflected, transmitted, wood] =
            [band.leaf.reflectance, band.leaf.transmittance, band.wood.reflectance].map(digits);
        let text = format!(
            "{}: leaf reflects {reflected}, transmits {transmitted}; wood reflects {wood}",
            band.name
        );
        ("surfaces", text)
    });
    optics.chain(surfaces).collect()
}

/// Rounded to four places.
fn digits(value: f64) -> f64 {
    libm::round(1e4 * value) / 1e4
}

/// How the species was made, but for what other rows say.
fn settings(species: &SpeciesInfo) -> String {
    let is_told =
        |key: &str| ["import.", "voxelise.", "solve.", "scene."].iter().any(|prefix| key.starts_with(prefix));
    let told = species
        .settings
        .iter()
        .filter(|(key, value)| is_told(key) && (!value.is_array() || key.as_str() == "import.offset_m"));
    let told: Vec<String> = told.map(|(key, value)| format!("{key} {value}")).collect();
    if told.is_empty() { "none recorded".to_owned() } else { told.join(", ") }
}

/// The codec, what it was asked for, and what it lost.
fn coding(species: &SpeciesInfo) -> String {
    let mut text = species.codec.clone();
    if species.threshold > 0.0 || species.codec.contains("haar-paper") {
        text += &format!(", threshold {}", species.threshold);
    }
    if let Some(db) = species.target_psnr_db {
        text += &format!(", coded to {db} dB");
    }
    if let Some(share) = species.target_error {
        text += &format!(", dark places to {} %", libm::round(1e4 * share) / 100.0);
    }
    if let Some(db) = species.surface_psnr_db {
        text += &format!(", {db:.1} dB at surfaces");
    }
    text
}

/// What the texels of the mesh's materials mean.
fn colours(species: &SpeciesInfo) -> String {
    if let Some(error) = &species.materials_error {
        return format!("cannot be used: {error}");
    }
    let Some(materials) = &species.materials else {
        return "textures tint the mean leaf and wood".to_owned();
    };
    let count = |texel: Texel| materials.iter().flatten().filter(|surface| surface.texel == texel).count();
    let of = materials.len();
    format!(
        "of {of} materials the textures of {} are what they reflect, those of {} tint surfaces of their own, the rest \
         tint the mean leaf and wood",
        count(Texel::Albedo),
        count(Texel::Tint)
    )
}

/// What a `physical` species says of its light.
fn light_rows(light: &LightInfo) -> Vec<(&'static str, String)> {
    let suns = match &light.suns {
        SunBasis::Lattice18 => "18 lattice directions, blended by three".to_owned(),
        SunBasis::Harmonics { degree, single, leaning } => {
            let beam = if *leaning { "the near beam as leaves meet it" } else { "the near beam" };
            match single {
                false => format!("harmonics to degree {degree}, and {beam}"),
                true => format!("harmonics to degree {degree}, {beam}, and light scattered once"),
            }
        }
        SunBasis::Directions(list) => {
            format!("{} directions, blended by the three of a triangle", list.directions().len())
        }
    };
    let ordinates = format!(
        "{}, {} ray{} a site edge",
        light.ordinates,
        light.rays,
        if light.rays == 1 { "" } else { "s" }
    );
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let fit = match light.error.held_out {
        0 => "of the blend of suns not measured".to_owned(),
        count => {
            format!("{} rms of the mean fluence over {count} suns held out", percent(light.error.suns_rms))
        }
    };
    let mut error = format!("{fit}; solver about {}", percent(light.error.solver));
    if let Some(truth) = &light.error.monte_carlo {
        error += &format!("; Monte Carlo {} rms, {} bias", percent(truth.rms), percent(truth.bias));
    }
    vec![
        ("field", light.field.name().to_owned()),
        ("suns", format!("{suns}: {} fields and the sky", light.sun_fields)),
        ("ordinates", ordinates),
        ("leaves", if light.leaves_spherical { "at random" } else { "inclined as the file says" }.to_owned()),
        ("in voxels", error),
    ]
}
