//! The light of the suns of a picture.

use clap::Args;
use flb_scene::scene::{AddedSun, Sunlight, irradiance};

use super::values::angle_pair;

#[derive(Args)]
pub(crate) struct SunlightArgs {
    /// The sun's strength and colour: its irradiance on a plane that faces it, as one number or as R,G,B. 1 is that
    /// for which light is stored. A clear sky colours its sun as well [default: the scene's, else 1]
    #[arg(long, value_name = "E|R,G,B", value_parser = bands, visible_aliases = ["sun-colour", "sun-color"])]
    pub sun_irradiance: Option<[f32; 3]>,
    /// Another sun in the same picture, and its irradiance as above, by default 1; it stands still. Repeat it for more.
    /// Each costs its shadow rays and a blend [default: the scene's]
    #[arg(long, value_name = "AZIMUTH,ELEVATION[=E|=R,G,B]", value_parser = sun, allow_hyphen_values = true)]
    pub add_sun: Vec<AddedSun>,
}

impl SunlightArgs {
    /// Further suns that take the place of a scene's.
    pub(crate) fn added(&self) -> Option<Vec<AddedSun>> {
        (!self.add_sun.is_empty()).then(|| self.add_sun.clone())
    }

    /// The same over a plant, which has none of its own.
    pub(crate) fn of_a_plant(&self) -> Sunlight {
        let irradiance = self.sun_irradiance.unwrap_or(Sunlight::default().irradiance);
        Sunlight { irradiance, added: self.add_sun.clone() }
    }
}

fn bands(text: &str) -> Result<[f32; 3], String> {
    let values: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let found = values.map_err(|_| "one number, or three for R, G, B").and_then(|values| irradiance(&values));
    found.map_err(|expected| format!("found {text:?}, expected {expected}"))
}

fn sun(text: &str) -> Result<AddedSun, String> {
    let (angles, light) = text.split_once('=').map_or((text, None), |(angles, light)| (angles, Some(light)));
    Ok(AddedSun { sun_deg: angle_pair(angles)?, irradiance: light.map_or(Ok([1.0; 3]), bands)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_further_sun_has_an_irradiance_or_one_of_1() {
        let of = |text: &str| sun(text).map(|one| (one.sun_deg, one.irradiance));
        assert_eq!(of("90,15"), Ok(([90.0, 15.0], [1.0; 3])));
        assert_eq!(of("90,-15=0.5"), Ok(([90.0, -15.0], [0.5; 3])));
        assert_eq!(of("90,15=1,0,0.25"), Ok(([90.0, 15.0], [1.0, 0.0, 0.25])));
        for bad in ["90", "90,95", "90,15=", "90,15=-1", "90,15=1,2", "90,15=nan", "90,15=0,0,0", "90,15=2e6"]
        {
            assert!(of(bad).is_err(), "{bad}");
        }
        assert!(bands("-1,1,1").unwrap_err().contains("expected 0 to 10^6, and not 0 in all bands"));
    }
}
