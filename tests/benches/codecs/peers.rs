//! What others take for the same fields.

use flb_format::container::payload;
use flb_format::container::payload::BlockPage;
use flb_format::{Codec, Field, block, sample};
use flb_packer::{EncodeSettings, Existing, encode_species, write_library};
use rayon::prelude::*;

use crate::bc6h;
use crate::plant::Plant;
use crate::surface::{Error, Surface};

/// A line of the table.
pub(crate) struct Row {
    pub name: String,
    pub bytes: f64,
    pub error: Option<Error>,
}

/// The papers' blocks, of the whole volume and of those near geometry alone, as `--near-geometry` stores them: each
/// base at the threshold that gives it the error.
pub(crate) fn haar_paper(plant: &Plant, surface: &Surface, psnr_db: f64) -> [Row; 2] {
    let n = plant.lattice;
    let is_read = block::near(n, &plant.non_empty);
    let bases: Vec<([f64; 2], [u64; 2])> = plant
        .bases()
        .par_iter()
        .enumerate()
        .map(|(i, (base, field))| {
            let unit = if *base == 0 { 18.0 } else { 1.0 };
            let at = |threshold: f32| {
                let page = blocks(field, threshold * unit);
                let error = surface.of_base(i, field.bands, |point, out| {
                    let at = sample::locate(n, point);
                    let (mask, coefficients) = page.block(at.block_index(n) as usize, field.bands as usize);
                    sample::sample(mask, coefficients, field.bands as usize, at.local, out);
                });
                (page, error)
            };
            let target = libm::exp10(-psnr_db / 10.0);
            let (mut low, mut high) = (0.0f32, 1.0f32);
            for _ in 0..14 {
                let middle = (low + high) / 2.0;
                *(if at(middle).1[0] > target { &mut high } else { &mut low }) = middle;
            }
            let (page, error) = at(low);
            let bytes = |all: bool| {
                let masks = page.masks.iter().zip(&is_read).filter(|(_, read)| all || **read);
                masks.map(|(mask, _)| u64::from(BlockPage::block_bytes(*mask, field.bands))).sum()
            };
            (error, [bytes(true), bytes(false)])
        })
        .collect();
    let error = surface.pool(&bases.iter().map(|base| base.0).collect::<Vec<_>>());
    let row = |which: usize, name: &str| Row {
        name: name.to_owned(),
        bytes: bases.iter().map(|base| base.1[which] as f64).sum(),
        error: Some(error),
    };
    [row(0, "haar-paper"), row(1, "haar-paper, blocks near geometry")]
}

/// All blocks in one page.
fn blocks(field: &Field, threshold: f32) -> BlockPage {
    let bands = field.bands as usize;
    let per_axis = block::blocks_per_axis(field.lattice);
    let mut page = BlockPage::default();
    let (mut texels, mut coefficients) = (vec![0.0; block::TEXELS * bands], Vec::new());
    for b in 0..per_axis.pow(3) {
        let at = [b % per_axis, b / per_axis % per_axis, b / (per_axis * per_axis)];
        block::gather(field, at, &mut texels);
        coefficients.clear();
        let mask = block::encode(&texels, bands, threshold, &mut coefficients);
        page.push(mask, &coefficients, bands);
    }
    page
}

/// Texels of all blocks near geometry, of all bases.
fn near_texels(plant: &Plant, surface: &Surface) -> f64 {
    (surface.near_blocks * block::TEXELS * plant.bases().len()) as f64
}

/// Plain binary16.
pub(crate) fn half(plant: &Plant, surface: &Surface) -> Row {
    let round = |field: &Field| {
        let values = field.values().iter().map(|value| payload::rounded_f16(*value)).collect();
        Field::new(field.lattice, field.bands, values)
    };
    Row {
        name: "binary16, blocks near geometry".to_owned(),
        bytes: 2.0 * f64::from(plant.bases()[0].1.bands) * near_texels(plant, surface),
        error: Some(surface.of_fields(plant, round)),
    }
}

/// BC6H, three bands in one byte a texel.
pub(crate) fn bc6h(plant: &Plant, surface: &Surface) -> Row {
    Row {
        name: "BC6H (one line a tile of 4 x 4), blocks near geometry".to_owned(),
        bytes: f64::from(plant.bases()[0].1.bands.div_ceil(3)) * near_texels(plant, surface),
        error: Some(surface.of_fields(plant, |field| bc6h::coded(field, &surface.is_near))),
    }
}

/// zfp's fixed rate, by the script, if there is a Python for it.
pub(crate) fn zfp(plant: &Plant, psnr_db: f64) -> Option<f64> {
    let python = std::env::var_os("FLB_ZFP_PYTHON")?;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("fields.flb");
    let settings = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
    let coded =
        encode_species(&plant.fields, &settings, &|_| Ok(())).expect("fields that were solved or read");
    write_library(&path, &[&coded], Existing::Keep).expect("the temporary folder is writable");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/zfp/compare.py");
    let run = std::process::Command::new(python)
        .arg(script)
        .arg(path)
        .args(["--db", &psnr_db.to_string()])
        .output();
    let run = run.expect("FLB_ZFP_PYTHON names a program");
    assert!(run.status.success(), "{script}: {}", String::from_utf8_lossy(&run.stderr));
    let talk = String::from_utf8(run.stdout).expect("text");
    let bytes = talk.split_whitespace().nth(2).and_then(|word| word.parse().ok());
    Some(bytes.unwrap_or_else(|| panic!("{script} printed {talk}")))
}
