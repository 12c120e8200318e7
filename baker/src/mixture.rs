//! Sites that hold several materials: what their leaves and their wood scatter, mixed by area.
//!
//! ```text
//! mesh, what each material shows, TurbidMedium -mix-> per band and site: albedos of leaf and wood, what passes
//! ```

use flb_scene::alpha::{AlphaError, Coverage};
use flb_scene::color::MeanShares;
use flb_scene::rays::{points, uv};
use flb_scene::sampling::on_triangle;
use flb_scene::{MaterialClass, Plant};
use flb_transport::turbid::{BandScatter, Phase, TurbidMedium};

/// Points over the area of a site's face, and most on a triangle.
const PER_FACE: f64 = 16.0;
const MAX_POINTS: f64 = 65_536.0;

/// Albedos of leaf and wood in one band.
pub trait Albedos: Sync {
    /// Albedos of leaf and wood in the site at a place of the list of non-empty ones.
    fn albedos(&self, place: usize) -> [f64; 2];
}

/// Everywhere alike.
impl Albedos for BandScatter {
    fn albedos(&self, _: usize) -> [f64; 2] {
        [self.leaf.albedo, self.wood.albedo]
    }
}

/// One band, site by site, in the order of [`TurbidMedium::sites`].
#[derive(Debug, Clone, PartialEq)]
pub struct MixedBand {
    /// Albedos of leaf and of wood.
    pub albedos: Vec<[f64; 2]>,
    /// Share of what leaves scatter that comes out of the far side.
    pub transmitted: Vec<f32>,
}

impl Albedos for MixedBand {
    fn albedos(&self, place: usize) -> [f64; 2] {
        self.albedos[place]
    }
}

/// The bands `kept` of a plant whose materials differ; `None` where all leaves are alike and all wood is. `mean` is
/// what a site gets in which no point of its matter was found.
///
/// # Errors
/// Of [`Coverage::of`], for textures that cannot be cut.
pub fn mix(
    plant: &Plant,
    kept: &[usize],
    turbid: &TurbidMedium,
    mean: &[BandScatter],
    ignore_alpha: bool,
) -> Result<Option<Vec<MixedBand>>, AlphaError> {
    let (mesh, classes) = (&plant.classed.mesh, &plant.classed.classes);
    let shown: Vec<Option<&[MeanShares]>> =
        plant.colors.iter().map(|color| color.as_ref().map(|color| color.shown.as_slice())).collect();
    if are_alike(classes, &shown) {
        return Ok(None);
    }
    let coverage = Coverage::of_all(mesh, ignore_alpha)?;
    let sites = turbid.sites();
    let mut places = vec![usize::MAX; turbid.grid.sites()];
    sites.iter().enumerate().for_each(|(place, &site)| places[site as usize] = place);
    let face_m2 = turbid.grid.spacing_m * turbid.grid.spacing_m;
    // `[place][kind]`: area, and over the bands the sums of what is reflected and what is transmitted.
    let width = kept.len();
    let mut areas = vec![[0.0f64; 2]; sites.len()];
    let mut sums = vec![[0.0f64; 2]; sites.len() * 2 * width];
    for (triangle, &material) in mesh.triangle_material.iter().enumerate() {
        let material = material as usize;
        let kind = match classes[material] {
            MaterialClass::Leaf => 0,
            MaterialClass::Wood => 1,
            MaterialClass::Neither => continue,
        };
        let Some(shown) = shown[material] else { continue };
        let [a, b, c] = points(mesh, triangle);
        let area_m2 = f64::from((b - a).cross(c - a).length()) / 2.0;
        let count = (area_m2 / face_m2 * PER_FACE).ceil().clamp(1.0, MAX_POINTS) as u32;
        let share = area_m2 * mesh.sheets.side(triangle).share() / f64::from(count);
        for point in 0..count {
            let weights = on_triangle(triangle as u32, point);
            if !coverage[material].present_at(uv(mesh, triangle, weights)) {
                continue;
            }
            let at = a + (b - a) * weights[0] + (c - a) * weights[1];
            let Some(place) = place(turbid, &places, at.as_dvec3().to_array()) else { continue };
            areas[place][kind] += share;
            let sums = &mut sums[(2 * place + kind) * width..][..width];
            for (sum, &band) in sums.iter_mut().zip(kept) {
                sum[0] += share * shown[band].reflectance;
                sum[1] += share * shown[band].transmittance;
            }
        }
    }
    let of_band = |band: usize| {
        let Phase::BiLambert { transmitted: mean_passes } = mean[band].leaf.phase else {
            unreachable!("surfaces scatter as facets")
        };
        let mut mixed = MixedBand {
            albedos: vec![mean[band].albedos(0); sites.len()],
            transmitted: vec![mean_passes as f32; sites.len()],
        };
        for (place, areas) in areas.iter().enumerate() {
            for (kind, area_m2) in areas.iter().enumerate().filter(|(_, area_m2)| **area_m2 > 0.0) {
                let [reflected, transmitted] = sums[(2 * place + kind) * width + band];
                let albedo = (reflected + transmitted) / area_m2;
                mixed.albedos[place][kind] = albedo.clamp(0.0, 1.0);
                if kind == 0 && reflected + transmitted > 0.0 {
                    mixed.transmitted[place] = (transmitted / (reflected + transmitted)) as f32;
                }
            }
        }
        mixed
    };
    Ok(Some((0..width).map(of_band).collect()))
}

/// Whether all materials of each class show the same.
fn are_alike(classes: &[MaterialClass], shown: &[Option<&[MeanShares]>]) -> bool {
    [MaterialClass::Leaf, MaterialClass::Wood].iter().all(|wanted| {
        let mut of_class =
            classes.iter().zip(shown).filter(|(class, _)| *class == wanted).filter_map(|(_, shown)| *shown);
        let first = of_class.next();
        of_class.all(|shown| Some(shown) == first)
    })
}

fn place(turbid: &TurbidMedium, places: &[usize], at: [f64; 3]) -> Option<usize> {
    let site = turbid.grid.lattice_from_model(at).map(|c| c.floor());
    let within = site.iter().all(|c| (0.0..f64::from(turbid.grid.lattice)).contains(c));
    let index = within.then(|| turbid.grid.index(site[0] as u32, site[1] as u32, site[2] as u32))?;
    Some(places[index]).filter(|place| *place != usize::MAX)
}

/// Digest of what is mixed, for the store.
pub fn digest(bands: &[MixedBand]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for band in bands {
        band.albedos.as_flattened().iter().for_each(|albedo| _ = hasher.update(&albedo.to_le_bytes()));
        band.transmitted.iter().for_each(|share| _ = hasher.update(&share.to_le_bytes()));
    }
    hasher.finalize().into()
}

#[cfg(test)]
mod tests;
