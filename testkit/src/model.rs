//! Models of the plants of tests.

use flb_format::light::{FieldKind, Light, LightError, SunBasis};
use flb_format::matter::{
    BandOptics, BandSurfaces, ClassOptics, LeafSurface, Optics, Surfaces, TurbidMedium, WoodSurface,
};
use flb_format::model::Model;

/// The model, its bases, and what it keeps of the medium; without suns it is `paper`.
pub fn model(suns: Option<&SunBasis>, turbid: TurbidMedium) -> (Model, u16, Option<TurbidMedium>) {
    match suns {
        None => {
            let optics = ClassOptics { sigma_a: 0.1, g: 0.0 };
            let band = |name: &str| BandOptics { name: name.to_owned(), leaf: optics, wood: optics };
            let bands = ["R", "G", "B"].map(band).to_vec();
            (Model::Paper { optics: Optics { bands } }, 19, None)
        }
        Some(suns) => {
            let light = scattered(suns, &turbid);
            let band = |name: &str| BandSurfaces {
                name: name.to_owned(),
                leaf: LeafSurface { reflectance: 0.25, transmittance: 0.25 },
                wood: WoodSurface { reflectance: 0.5 },
            };
            let surfaces = Surfaces { bands: ["R", "G", "B"].map(band).to_vec() };
            (Model::Physical { surfaces, light }, suns.items(), Some(turbid))
        }
    }
}

/// Scattered light of these suns in a medium, of a solve without error.
pub fn scattered(suns: &SunBasis, turbid: &TurbidMedium) -> Light {
    Light {
        field: FieldKind::Scattered,
        ordinates: 18,
        rays: 2,
        suns: suns.clone(),
        leaf_angles: turbid.angles.clone(),
        error: LightError { suns_rms: 0.0, held_out: 0, solver: 0.0, monte_carlo: None },
        solid_offset: None,
    }
}
