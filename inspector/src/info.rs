//! What a file holds, as a value: for the command line's table and its JSON.

use std::collections::BTreeMap;

use flb_format::container::records::{self, SectionKey};
use flb_format::container::verify::hexadecimal;
use flb_format::light::{FieldKind, LightError, SunBasis};
use flb_format::material_surface::MaterialSurface;
use flb_format::matter::{Optics, Surfaces};
use flb_format::mesh::MeshError;
use flb_format::meta::LeftOut;
use flb_format::{Codec, Container, provenance};
use serde::Serialize;
use serde_json::Value;

/// Summary of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Info {
    /// "major.minor".
    pub format_version: String,
    /// Length of the file.
    pub file_bytes: u64,
    /// Bytes in front of the first page: header, table of contents, page tables.
    pub tables_bytes: u64,
    /// BLAKE3 root, hexadecimal: the identity of the file.
    pub root: String,
    /// Species, in the file's order.
    pub species: Vec<SpeciesInfo>,
    /// Sections, in the file's order.
    pub sections: Vec<SectionInfo>,
}

/// Summary of a species.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeciesInfo {
    /// Name, unique in the file.
    pub name: String,
    /// Light transport model.
    pub model: String,
    /// Optics per band; null for the model `physical`.
    pub optics: Option<Optics>,
    /// Surfaces per band; null for the model `paper`.
    pub surfaces: Option<Surfaces>,
    /// Method, storage and error of the light; null for the model `paper`.
    pub light: Option<LightInfo>,
    /// Error of the light on its mesh, as the bake judged it; null where it did not.
    pub mesh_error: Option<MeshError>,
    /// Sites per edge.
    pub lattice: u32,
    /// Base indices, ascending.
    pub bases: Vec<u8>,
    /// Bases and bands that were left out on purpose, and why; null if none were.
    pub left_out: Option<LeftOut>,
    /// Band names, in order.
    pub bands: Vec<String>,
    /// Codec of the bases; several are joined by a comma.
    pub codec: String,
    /// Largest relative threshold of the bases.
    pub threshold: f32,
    /// Error that the bases were coded to, dB; null where the writer's settings name none.
    pub target_psnr_db: Option<f64>,
    /// Relative error of the darkest tenth of samples that the bases were coded to; null where the writer's settings
    /// name none.
    pub target_error: Option<f64>,
    /// Error of samples at surfaces that all codings made, dB, as the writer measured it; null where it says nothing or
    /// none.
    pub surface_psnr_db: Option<f64>,
    /// Bounds of the mesh in model space, metres: `[[min x, y, z], [max x, y, z]]`.
    pub bounds: [[f64; 3]; 2],
    /// Corner of the lattice in model space, metres.
    pub origin_m: [f64; 3],
    /// Edge of a site, metres.
    pub spacing_m: f64,
    /// Triangles of the mesh: all, leaf, wood.
    pub triangles: [u64; 3],
    /// Digest of the mesh that its light is of, hexadecimal; null where the file does not say.
    pub mesh_blake3: Option<String>,
    /// Surfaces of the mesh's materials, null for a tint of the species' leaf or wood; null where all are.
    pub materials: Option<Vec<Option<MaterialSurface>>>,
    /// Reason why the file's surfaces of materials cannot be used; null where they can, or the file has none.
    pub materials_error: Option<String>,
    /// Stored bytes of the species' pages, those included that it shares.
    pub bytes: u64,
    /// Bytes of the pages that the file stores for pages before them, of this species or another.
    pub shared_bytes: u64,
    /// Bytes of the species' bases as plain floats, divided by those of their pages.
    pub ratio: f64,
    /// Program that wrote the species.
    pub tool: String,
    /// Settings that the writer recorded, as the file has them.
    pub settings: BTreeMap<String, Value>,
}

/// Light of a species of the model `physical`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightInfo {
    /// "scattered" or "total".
    pub field: FieldKind,
    /// Directions along which light was followed.
    pub ordinates: u32,
    /// Rays per site edge.
    pub rays: u32,
    /// Dependence of the fields on the sun.
    pub suns: SunBasis,
    /// Fields per band for the sun; the sky's is one more.
    pub sun_fields: u8,
    /// Whether leaves favour no direction; else the file holds their inclinations.
    pub leaves_spherical: bool,
    /// Error of the stored light, as far as it is known.
    pub error: LightError,
    /// Stored bytes of the extinctions.
    pub extinction_bytes: u64,
}

/// Summary of a section.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionInfo {
    /// "metadata", "medium", "base", "blocks", "averages", "detail" or "kind 77".
    pub kind: String,
    /// Index of the species.
    pub species: u32,
    /// Item within the kind: base index, or the array of the medium.
    pub item: u32,
    /// Name of the codec, or its number.
    pub codec: String,
    /// Offset of the first page.
    pub offset: u64,
    /// Bytes of the data.
    pub bytes: u64,
    /// Bytes of the pages before compression.
    pub raw_bytes: u64,
    /// Number of pages.
    pub pages: u32,
    /// Relative threshold.
    pub threshold: f32,
}

/// Summarises an open file.
pub fn info(container: &Container) -> Info {
    let (major, minor) = container.format_version();
    Info {
        format_version: format!("{major}.{minor}"),
        file_bytes: container.header().file_bytes,
        tables_bytes: container.header().tables_end,
        root: hexadecimal(container.root()),
        species: species_infos(container),
        sections: container.sections().iter().map(section_info).collect(),
    }
}

fn species_infos(container: &Container) -> Vec<SpeciesInfo> {
    let mut infos: Vec<_> = (0..container.species().len()).map(|i| species_info(container, i)).collect();
    let mut end = 0; // of what the pages so far store
    for (section, entry) in container.sections().iter().enumerate() {
        for page in container.pages(section) {
            let stored = u64::from(page.stored_bytes);
            match infos.get_mut(entry.key.species as usize) {
                Some(info) if page.offset < end => info.shared_bytes += stored,
                _ => {}
            }
            end = end.max(page.offset + stored);
        }
    }
    infos
}

fn species_info(container: &Container, index: usize) -> SpeciesInfo {
    let species = &container.species()[index];
    let meta = &species.meta;
    let mut codecs: Vec<&str> = species.bases.iter().map(|base| base.codec.name()).collect();
    codecs.dedup();
    let stored = |section: usize| container.stored_bytes(section);
    let of_all = species.blocks.iter().flat_map(|blocks| [Some(blocks.map), blocks.classes]).flatten();
    let base_bytes =
        of_all.map(stored).sum::<u64>() + species.bases.iter().map(|base| base.bytes).sum::<u64>();
    let plain_bytes = (meta.grid.sites() * meta.band_count() * 4 * species.bases.len()) as f64;
    SpeciesInfo {
        name: meta.name.clone(),
        model: meta.model.name().to_owned(),
        optics: meta.optics().cloned(),
        surfaces: meta.physical().map(|(surfaces, _)| surfaces.clone()),
        light: meta.physical().map(|(_, light)| LightInfo {
            field: light.field,
            ordinates: light.ordinates,
            rays: light.rays,
            suns: light.suns.clone(),
            sun_fields: (light.suns.items() - 1) as u8,
            leaves_spherical: light.leaf_angles.is_spherical(),
            error: light.error,
            extinction_bytes: (species.extinction.iter().flatten()).map(|&section| stored(section)).sum(),
        }),
        mesh_error: MeshError::of(meta),
        lattice: meta.grid.lattice,
        bases: species.bases.iter().map(|base| base.base).collect(),
        left_out: meta.left_out.clone(),
        bands: meta.bands().map(str::to_owned).collect(),
        codec: codecs.join(","),
        threshold: species.bases.iter().map(|base| base.threshold).fold(0.0, f32::max),
        target_psnr_db: meta.recorded(&provenance::TARGET_PSNR_DB),
        target_error: meta.recorded(&provenance::TARGET_ERROR),
        surface_psnr_db: meta.recorded(&provenance::SURFACE_PSNR_DB).flatten(),
        bounds: [meta.bounds_m.min, meta.bounds_m.max],
        origin_m: meta.grid.origin_m,
        spacing_m: meta.grid.spacing_m,
        triangles: [meta.triangles.total, meta.triangles.leaf, meta.triangles.wood],
        mesh_blake3: meta.mesh_blake3.clone(),
        materials: meta.material_surfaces().ok().flatten(),
        materials_error: meta.material_surfaces().err(),
        bytes: species.bytes,
        shared_bytes: 0,
        ratio: plain_bytes / base_bytes as f64,
        tool: meta.tool.clone(),
        settings: meta.settings.iter().map(|(key, value)| (key.clone(), value.clone())).collect(),
    }
}

fn section_info(section: &records::SectionEntry) -> SectionInfo {
    let SectionKey { kind, species, item } = section.key;
    let name = match kind {
        records::KIND_METADATA => "metadata".to_owned(),
        records::KIND_MEDIUM => "medium".to_owned(),
        records::KIND_BASE => "base".to_owned(),
        records::KIND_BLOCKS => "blocks".to_owned(),
        records::KIND_AVERAGES => "averages".to_owned(),
        records::KIND_DETAIL => "detail".to_owned(),
        other => format!("kind {other}"),
    };
    let codec = match section.codec {
        records::CODEC_SPARSE_F32 => "sparse-f32".to_owned(),
        records::CODEC_SPARSE_U8 => "sparse-u8".to_owned(),
        records::CODEC_JSON => "json".to_owned(),
        records::CODEC_BLOCK_MAP => "block-map".to_owned(),
        records::CODEC_CLASSES => "classes".to_owned(),
        records::CODEC_AVERAGES => "averages".to_owned(),
        other => Codec::from_number(other).map_or(format!("codec {other}"), |codec| codec.name().to_owned()),
    };
    SectionInfo {
        kind: name,
        species,
        item,
        codec,
        offset: section.data_offset,
        bytes: section.data_bytes,
        raw_bytes: section.raw_bytes,
        pages: section.page_count,
        threshold: section.threshold,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn physical_species_show_model_suns_and_error_and_paper_species_none() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../format-spec/golden/physical.flb");
        let bytes = std::fs::read(path).expect("the golden file is committed");
        let info = info(&Container::open(&bytes).expect("it opens"));
        let json = serde_json::to_value(&info).expect("it is plain");
        let [harmonics, lattice, paper] = [0, 1, 2].map(|i| &json["species"][i]);
        assert_eq!(
            [&harmonics["model"], &lattice["model"], &paper["model"]],
            ["physical", "physical", "paper"]
        );
        assert!(paper["light"].is_null() && paper["bands"] == serde_json::json!(["R"]));
        assert!(paper["surfaces"].is_null() && harmonics["optics"].is_null());
        assert_eq!(paper["optics"][0]["name"], "R");
        assert!(paper["optics"][0]["leaf"]["sigma_a"].is_number());
        assert!(harmonics["surfaces"].is_array() || harmonics["surfaces"].is_object());
        assert!(harmonics["settings"].is_object());
        let light = &harmonics["light"];
        let suns = serde_json::json!({"kind": "harmonics", "degree": 1, "reaches": [1, 3, 8]});
        assert_eq!((&light["suns"], &light["sun_fields"]), (&suns, &serde_json::json!(8)));
        assert_eq!(
            (&light["field"], &light["ordinates"], &light["rays"]),
            (&"scattered".into(), &50.into(), &2.into())
        );
        assert_eq!(light["error"], serde_json::json!({"suns_rms": 0.0125, "held_out": 30, "solver": 1e-4}));
        assert_eq!(light["leaves_spherical"], false);
        let extinction: u64 = info
            .sections
            .iter()
            .filter(|s| s.kind == "medium" && s.species == 0 && s.item > 3)
            .map(|s| s.bytes)
            .sum();
        assert!(
            extinction > 0
                && info.species[0].light.as_ref().is_some_and(|l| l.extinction_bytes == extinction)
        );
        assert_eq!(
            (&lattice["light"]["field"], &lattice["light"]["leaves_spherical"]),
            (&"total".into(), &true.into())
        );
        assert_eq!(lattice["light"]["error"]["monte_carlo"]["photons"], 1_000_000);
        assert_eq!(harmonics["bands"], serde_json::json!(["red", "near infrared"]));
    }
}
