//! Each stage's result as a few lines of text: numbers that a person can judge, and a digest that one
//! changed bit changes. Everything in the pipeline is meant to be the same to the bit on every machine,
//! so the digests are exact; the numbers beside them say how far a change went.

use std::fmt::Write;

use flb_baker::Occupancy;
use flb_fixtures::Plant;
use flb_format::container::records::KIND_BASE;
use flb_format::container::verify::hexadecimal;
use flb_format::matter::Class;
use flb_format::{Container, Field, Medium, SpeciesFields};
use flb_packer::quality::CodingReport;
use flb_scene::Mesh;
use flb_scene::classify::Classified;
use flb_transport::lattice::Solution;

/// First 16 hexadecimal digits of the BLAKE3 of what `feed` gives to `eat`.
fn digest(feed: impl FnOnce(&mut dyn FnMut(&[u8]))) -> String {
    let mut hasher = blake3::Hasher::new();
    feed(&mut |bytes| {
        hasher.update(bytes);
    });
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Digest of floats, by their bits.
pub fn digest_of_floats(values: &[f32]) -> String {
    digest(|eat| {
        for part in values.chunks(4096) {
            let bytes: Vec<u8> = part.iter().flat_map(|value| value.to_le_bytes()).collect();
            eat(&bytes);
        }
    })
}

/// Parts, counts, bytes.
pub fn plant(plant: &Plant, glb: &[u8]) -> String {
    let mut text = format!("{} of seed {}\n", plant.kind.name(), plant.seed);
    for part in &plant.parts {
        let (vertices, triangles) = (part.positions.len(), part.triangles.len());
        let PlantSurface { name, size, cutoff } = PlantSurface::of(part);
        let _ =
            writeln!(text, "  {name}: {vertices} vertices, {triangles} triangles, texture {size}, {cutoff}");
    }
    let file = digest(|eat| eat(glb));
    let _ = writeln!(text, "  glb: {} bytes, {file}", glb.len());
    text
}

struct PlantSurface {
    name: &'static str,
    size: String,
    cutoff: String,
}

impl PlantSurface {
    fn of(part: &flb_fixtures::PlantPart) -> PlantSurface {
        let material = &part.material;
        PlantSurface {
            name: material.name,
            size: format!("{} x {}", material.width, material.height),
            cutoff: material.alpha_cutoff.map_or("opaque".to_owned(), |cutoff| format!("cut at {cutoff}")),
        }
    }
}

/// Vertices, triangles, materials, images, area, bounds, warnings.
pub fn mesh(mesh: &Mesh) -> String {
    let corners = |triangle: &[u32; 3]| triangle.map(|v| mesh.positions[v as usize].map(f64::from));
    let area_m2: f64 = mesh.triangles.iter().map(|triangle| flb_scene::import::area(corners(triangle))).sum();
    let bounds = mesh.bounds().expect("a plant has triangles");
    let mut text = format!(
        "{} vertices, {} triangles, {area_m2:.6} m^2\n  from {:.4?} to {:.4?}\n",
        mesh.positions.len(),
        mesh.triangles.len(),
        bounds.min,
        bounds.max
    );
    for material in &mesh.materials {
        let _ = writeln!(text, "  material {}: {:?}", material.name, material.alpha_mode);
    }
    for image in &mesh.images {
        let _ = writeln!(
            text,
            "  image {}: {} x {}, cut {}",
            image.name, image.width, image.height, image.has_cut
        );
    }
    mesh.warnings.iter().for_each(|warning| text += &format!("  warning: {warning}\n"));
    let all = digest(|eat| {
        for value in mesh.positions.as_flattened().iter().chain(mesh.normals.as_flattened()) {
            eat(&value.to_le_bytes());
        }
        mesh.uvs.as_flattened().iter().for_each(|value| eat(&value.to_le_bytes()));
        for index in mesh.triangles.as_flattened().iter().chain(&mesh.triangle_material) {
            eat(&index.to_le_bytes());
        }
        mesh.images.iter().for_each(|image| eat(&image.rgba));
    });
    let _ = writeln!(text, "  {all}");
    text
}

/// One line per material.
pub fn classes(mesh: &Mesh, classified: &[Classified]) -> String {
    let line = |(material, decision): (&flb_scene::mesh::Material, &Classified)| {
        format!("  {}: {:?} by {}\n", material.name, decision.class, decision.rule)
    };
    mesh.materials.iter().zip(classified).map(line).collect()
}

/// Counts, areas.
pub fn occupancy(occupancy: &Occupancy) -> String {
    let [leaf, wood, either] = occupancy.counts();
    let [leaf_m2, wood_m2] = occupancy.area_m2();
    let all = digest(|eat| {
        for cluster in occupancy.clusters() {
            cluster.position.iter().for_each(|c| eat(&c.to_le_bytes()));
            cluster.leaf.iter().chain(&cluster.wood).for_each(|w| eat(&w.to_le_bytes()));
        }
        for area in occupancy.areas() {
            eat(&area.site.to_le_bytes());
            eat(&area.leaf.to_le_bytes());
            eat(&area.wood.to_le_bytes());
        }
    });
    format!(
        "{}^3 voxels: {leaf} leaf, {wood} wood, {either} either, in {} clusters\n  \
         {leaf_m2:.6} m^2 leaf, {wood_m2:.6} m^2 wood, in {} sites\n  {all}\n",
        occupancy.voxels(),
        occupancy.clusters().len(),
        occupancy.areas().len()
    )
}

/// Classes, a histogram of density in tenths, leaf and wood area density.
pub fn medium(medium: &Medium) -> String {
    let count = |class: Class| medium.class.iter().filter(|c| **c == class).count();
    let mut tenths = [0u32; 10];
    for density in medium.density.iter().filter(|density| **density > 0.0) {
        tenths[((density * 10.0) as usize).min(9)] += 1;
    }
    let mean_max = |values: &[f32]| {
        let sum: f64 = values.iter().map(|value| f64::from(*value)).sum();
        let max = values.iter().fold(0.0f32, |max, value| max.max(*value));
        format!("mean {:.6}, max {max:.6}", sum / values.len() as f64)
    };
    let all = digest_of_floats(
        &[&medium.density[..], &medium.leaf_area_density, &medium.wood_area_density].concat(),
    );
    let class = digest(|eat| medium.class.iter().for_each(|c| eat(&[*c as u8])));
    format!(
        "{0}^3 sites of {1:.9} m from {2:.6?}: {3} leaf, {4} wood\n  density: {5}, tenths {tenths:?}\n  \
         leaf area density: {6}\n  wood area density: {7}\n  {all} class {class}\n",
        medium.grid.lattice,
        medium.grid.spacing_m,
        medium.grid.origin_m,
        count(Class::Leaf),
        count(Class::Wood),
        mean_max(&medium.density),
        mean_max(&medium.leaf_area_density),
        mean_max(&medium.wood_area_density),
    )
}

/// A line per base: mean, root mean square and maximum over all sites and bands, sweeps, digest.
pub fn fields(solution: &Solution) -> String {
    let line = |(base, field): &(u8, Field)| {
        let count = field.len() as f64;
        let (mut sum, mut squares, mut max) = (0.0f64, 0.0f64, 0.0f32);
        for value in field.values().iter() {
            sum += f64::from(*value);
            squares += f64::from(*value) * f64::from(*value);
            max = max.max(*value);
        }
        let sweeps = solution.reports.iter().filter(|r| r.base == *base).map(|r| r.sweeps).max().unwrap_or(0);
        format!(
            "  {base:2}: mean {:.6} rms {:.6} max {max:.6} sweeps {sweeps} {}\n",
            sum / count,
            (squares / count).sqrt(),
            digest_of_floats(&field.values())
        )
    };
    let head = if solution.reports.iter().all(|r| r.converged) { "converged" } else { "NOT converged" };
    head.to_owned() + "\n" + &solution.bases.iter().map(line).collect::<String>()
}

/// A line per base: empty blocks, constant blocks, coefficients kept, bytes, error.
///
/// # Panics
/// If the file is not valid.
#[allow(clippy::ptr_arg, reason = "a slice is no `&dyn Source`: it has no size")]
pub fn blocks(file: &Vec<u8>, report: &CodingReport) -> String {
    let decibels = |db: Option<f64>| db.map_or("exact".to_owned(), |db| format!("{db:.3} dB"));
    let container = Container::open(file).expect("the packer writes valid files");
    let mut text = format!(
        "ratio {:.4}, {}, {} bytes\n",
        report.ratio,
        decibels(report.surface_psnr_db),
        report.coded_bytes
    );
    for (index, _) in container.sections().iter().enumerate().filter(|(_, s)| s.key.kind == KIND_BASE) {
        let item = container.sections()[index].key.item;
        let pages = container.pages(index).len() as u32;
        let read = |page| container.read_block_page(file, index, page).expect("a page of a valid file");
        let masks: Vec<u64> = (0..pages).flat_map(|page| read(page).masks).collect();
        let of = |mask: u64| masks.iter().filter(|m| **m == mask).count();
        let kept: u32 = masks.iter().map(|mask| mask.count_ones()).sum();
        let base = report.bases.iter().find(|b| u32::from(b.base) == item).expect("a report per base");
        let _ = writeln!(
            text,
            "  {item:2}: {} blocks, {} empty, {} constant, {kept} kept, {} bytes, error {:.6}, {}",
            masks.len(),
            of(0),
            of(1),
            base.coded_bytes,
            base.max_error,
            decibels(base.surface_psnr_db)
        );
    }
    text
}

/// A line per section: key, codec, place, sizes, pages; the root.
///
/// # Panics
/// If the file is not valid.
#[allow(clippy::ptr_arg, reason = "a slice is no `&dyn Source`: it has no size")]
pub fn container(file: &Vec<u8>) -> String {
    let container = Container::open(file).expect("the packer writes valid files");
    let mut text = format!(
        "version {:?}, {} bytes, tables to {}, root {}\n",
        container.format_version(),
        container.header().file_bytes,
        container.header().tables_end,
        &hexadecimal(container.root())[..16]
    );
    for section in container.sections() {
        let _ = writeln!(
            text,
            "  {} codec {}: {} bytes at {}, {} raw, {} pages",
            section.key,
            section.codec,
            section.data_bytes,
            section.data_offset,
            section.raw_bytes,
            section.page_count
        );
    }
    text
}

/// Extinction, how it was calibrated, leaf angles.
///
/// # Panics
/// If the fields are of the other model.
pub fn crown(fields: &SpeciesFields) -> String {
    let turbid = fields.turbid.as_ref().expect("the default model has a turbid medium");
    let mean = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64;
    format!(
        "factor {}, gap {}\n  leaf: mean {:.6} per metre {}\n  wood: mean {:.6} per metre {}\n  angles {:.4?}\n",
        fields.meta.settings["crown.factor"],
        fields.meta.settings["crown.gap"],
        mean(&turbid.leaf_per_m),
        digest_of_floats(&turbid.leaf_per_m),
        mean(&turbid.wood_per_m),
        digest_of_floats(&turbid.wood_per_m),
        turbid.angles.shares(),
    )
}

/// How the light was solved and fitted over the suns, then a line per item: mean, root mean square, largest, digest.
///
/// # Panics
/// If the fields are of the other model.
pub fn physical_fields(fields: &SpeciesFields) -> String {
    let (_, light) = fields.meta.physical().expect("the default model");
    let error = &light.error;
    let mut text = format!(
        "{} {}, {} ordinates, {} rays; fit off by {:.6} over {} suns, solver by {:.2e}\n",
        light.suns.name(),
        light.suns.items(),
        light.ordinates,
        light.rays,
        error.suns_rms,
        error.held_out,
        error.solver
    );
    for (item, field) in &fields.bases {
        let count = field.len() as f64;
        let sum: f64 = field.values().iter().map(|value| f64::from(*value)).sum();
        let squares: f64 = field.values().iter().map(|value| f64::from(*value) * f64::from(*value)).sum();
        let largest = field.values().iter().fold(0.0f32, |largest, value| largest.max(value.abs()));
        let _ = writeln!(
            text,
            "  {item:2}: mean {:.6} rms {:.6} largest {largest:.6} {}",
            sum / count,
            (squares / count).sqrt(),
            digest_of_floats(&field.values())
        );
    }
    text
}

/// A line per item of a coding near geometry: bytes and errors.
pub fn coding(report: &CodingReport) -> String {
    let decibels = |db: Option<f64>| db.map_or("exact".to_owned(), |db| format!("{db:.3} dB"));
    let whole = decibels(report.surface_psnr_db);
    let mut text = format!("ratio {:.4}, {whole}, {} bytes\n", report.ratio, report.coded_bytes);
    for base in &report.bases {
        let of_base = decibels(base.surface_psnr_db);
        let _ = writeln!(
            text,
            "  {:2}: {} bytes, error {:.6}, {of_base}",
            base.base, base.coded_bytes, base.max_error
        );
    }
    text
}

/// Values with their digest.
pub fn values(name: &str, values: &[f32]) -> String {
    let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len().max(1) as f64;
    format!("  {name}: {} values, mean {mean:.6} {}\n", values.len(), digest_of_floats(values))
}
