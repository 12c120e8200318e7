//! The light of one species in two files, at the same points under the same suns.

use flb_format::container::Species;
use flb_format::light::FieldKind;
use flb_format::sun::towards_sun;
use flb_format::{Daylight, FormatError, Grid};
use flb_runtime::samplers::Marcher;
use flb_runtime::{InstanceLight, Library, RuntimeError, SpeciesLight};
use rayon::prelude::*;

use super::figures::{Figures, NoFigures, Sample, Values, figures};
use super::report::{LightChange, Worst, shown_sun};
use crate::FarmError;

/// Azimuths and elevations of the suns, degrees: one above, three half high, three low.
pub const SUNS_DEG: [[f64; 2]; 7] =
    [[0.0, 90.0], [0.0, 50.0], [120.0, 50.0], [240.0, 50.0], [60.0, 20.0], [180.0, 20.0], [300.0, 20.0]];
/// Points at most: sites with matter of the old file, by a fixed stride.
pub const MAX_POINTS: usize = 20_000;
/// Points that one task asks for.
const CHUNK: usize = 512;

/// Outcome for one species.
pub(super) struct Found {
    /// Sentences on what else differs.
    pub differs: Vec<String>,
    /// By how much the light differs, or why that cannot be said.
    pub light: Result<LightChange, String>,
}

type Side<'a> = (&'a Library, usize);

/// Compares; an error is of a file that cannot be read.
pub(super) fn compare_light(old: Side, new: Side) -> Result<Found, FarmError> {
    let [before, after] = [old, new].map(|(library, at)| &library.container().species()[at]);
    let mut differs = Vec::new();
    let bands = match match_up(before, after, &mut differs) {
        Ok(bands) => bands,
        Err(reason) => return Ok(Found { differs, light: Err(reason) }),
    };
    let (sites, points) = points(old)?;
    let sites_after = matter(new)?.len();
    if sites != sites_after {
        differs.push(format!("sites with matter {sites} -> {sites_after}"));
    }
    let light = match sample_both([old, new], &points, &bands)? {
        Err(reason) => Err(reason),
        Ok([before_values, after_values]) => {
            let (old, new) = (&before_values.values, &after_values.values);
            let suns = before_values.suns_deg.iter().filter(|sun| sun.is_some()).count();
            let found = figures(&Values { old, new, bands: bands.len(), suns });
            let told = Told { species: before, points: &points, suns_deg: &before_values.suns_deg };
            found.map(|figures| told.change(figures)).map_err(|none| told.reason(none))
        }
    };
    Ok(Found { differs, light })
}

/// Places of the old bands among the new ones, or why the lights cannot be compared; and what else differs.
fn match_up(old: &Species, new: &Species, differs: &mut Vec<String>) -> Result<Vec<usize>, String> {
    let (old, new) = (&old.meta, &new.meta);
    let mut tell = |what: &str, was: String, is: String| {
        if was != is {
            differs.push(format!("{what} {was} -> {is}"));
        }
    };
    let numbers = |numbers: [f64; 3]| numbers.map(metres).join(" ");
    tell("lattice", old.grid.lattice.to_string(), new.grid.lattice.to_string());
    tell("site edge, m,", metres(old.grid.spacing_m), metres(new.grid.spacing_m));
    tell("lattice corner, m,", numbers(old.grid.origin_m), numbers(new.grid.origin_m));
    tell("lower bounds, m,", numbers(old.bounds_m.min), numbers(new.bounds_m.min));
    tell("upper bounds, m,", numbers(old.bounds_m.max), numbers(new.bounds_m.max));
    tell("triangles", old.triangles.total.to_string(), new.triangles.total.to_string());
    if old.model.name() != new.model.name() {
        return Err(format!("model {} -> {}", old.model.name(), new.model.name()));
    }
    if let (Some((_, old)), Some((_, new))) = (old.physical(), new.physical()) {
        let offset = |offset: Option<f64>| offset.map_or("none".to_owned(), |sites| sites.to_string());
        tell("suns", old.suns.name().to_owned(), new.suns.name().to_owned());
        tell("distance off solids, sites,", offset(old.solid_offset), offset(new.solid_offset));
        let [was, is] = [old.field.name(), new.field.name()];
        if was != is {
            return Err(format!("fields of {was} -> {is} light"));
        }
    }
    let place = |band: &str| new.bands().position(|other| other == band);
    let places: Option<Vec<usize>> = old.bands().map(place).collect();
    match places {
        Some(places) if places.len() == new.band_count() => Ok(places),
        _ => {
            let list = |bands: Vec<&str>| bands.join(" ");
            Err(format!("bands {} -> {}", list(old.bands().collect()), list(new.bands().collect())))
        }
    }
}

/// Metres to a micrometre: less is not told.
fn metres(metres: f64) -> String {
    format!("{metres:.6}")
}

/// Sites with matter.
fn matter((library, at): Side) -> Result<Vec<u32>, FarmError> {
    let medium = library.container().read_medium(library.source(), at).map_err(|e| refused(library, e))?;
    let sites = (0u32..).zip(&medium.density).filter(|(_, density)| **density > 0.0);
    Ok(sites.map(|(site, _)| site).collect())
}

/// Number of sites with matter, and the middles of as many of them as are asked, metres.
fn points(side: Side) -> Result<(usize, Vec<[f32; 3]>), FarmError> {
    let sites = matter(side)?;
    let grid: Grid = side.0.container().species()[side.1].meta.grid;
    let stride = sites.len().div_ceil(MAX_POINTS).max(1);
    let middle = |site: &u32| grid.middle_m(grid.site(*site as usize)).map(|metres| metres as f32);
    Ok((sites.len(), sites.iter().step_by(stride).map(middle).collect()))
}

fn refused(library: &Library, error: FormatError) -> RuntimeError {
    RuntimeError::Format { path: library.path().to_owned(), source: Box::new(error) }
}

/// Light of one file.
struct Sampled {
    /// `[light][point][band]`.
    values: Vec<Vec<f32>>,
    /// Sun of each light; `None` is the sky. The sky comes last.
    suns_deg: Vec<Option<[f64; 2]>>,
}

/// Samples one file after the other, or says which light only one has.
fn sample_both(
    sides: [Side; 2],
    points: &[[f32; 3]],
    bands: &[usize],
) -> Result<Result<[Sampled; 2], String>, FarmError> {
    let [old, new] = sides;
    let in_order: Vec<usize> = (0..bands.len()).collect();
    let old = sample(old, points, &in_order)?;
    let new = sample(new, points, bands)?;
    let lacks = |one: &Sampled, other: &Sampled| {
        other.suns_deg.iter().find(|sun| !one.suns_deg.contains(sun)).map(|sun| shown_sun(*sun))
    };
    Ok(match (lacks(&old, &new), lacks(&new, &old)) {
        (None, None) => Ok([old, new]),
        (Some(light), _) => Err(format!("light of {light} in the new file alone")),
        (None, Some(light)) => Err(format!("light of {light} in the old file alone")),
    })
}

/// Samples every light that a file has. The bands are put in this order.
fn sample((library, at): Side, points: &[[f32; 3]], bands: &[usize]) -> Result<Sampled, FarmError> {
    let light = SpeciesLight::load(library, at)?;
    let (near, beam) = (light.near(), beam((library, at))?);
    let mut found = Sampled { values: Vec::new(), suns_deg: Vec::new() };
    let suns = SUNS_DEG.map(|sun| {
        let [azimuth, elevation] = sun;
        (Some(sun), Daylight { towards_sun: towards_sun(azimuth, elevation), sun: 1.0, sky: 0.0 })
    });
    let sky = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 1.0 };
    let sky = light.has_sky().then_some((None, sky));
    for (sun_deg, daylight) in suns.into_iter().chain(sky) {
        let lit = match light.lit_by_in_model(&daylight) {
            Ok(lit) => lit.prepared_by(near.as_ref()),
            // A file may have been made without.
            Err(RuntimeError::LeftOut { .. } | RuntimeError::MissingBase { .. }) => continue,
            Err(error) => return Err(error.into()),
        };
        let beam = beam.as_ref().filter(|_| sun_deg.is_some()).map(|beam| (beam, daylight.towards_sun));
        found.values.push(at_points((&lit, beam), points, bands));
        found.suns_deg.push(sun_deg);
    }
    Ok(found)
}

/// Finds the sun's beam at a point, where the fields leave it to the renderer.
fn beam((library, at): Side) -> Result<Option<Marcher<'static>>, FarmError> {
    let light = library.container().species()[at].meta.physical();
    if light.is_none_or(|(_, light)| light.field != FieldKind::Scattered) {
        return Ok(None);
    }
    let turbid = library.container().read_turbid(library.source(), at).map_err(|e| refused(library, e))?;
    Ok(Some(Marcher::new(&turbid, false)))
}

/// `[point][band]`; each point has the same light whatever the threads are.
fn at_points(
    (lit, beam): (&InstanceLight, Option<(&Marcher, [f64; 3])>),
    points: &[[f32; 3]],
    bands: &[usize],
) -> Vec<f32> {
    let mut values = vec![0.0; points.len() * bands.len()];
    values.par_chunks_mut(CHUNK * bands.len()).zip(points.par_chunks(CHUNK)).for_each(|(values, points)| {
        let (mut cursor, mut all) = (lit.cursor(), vec![0.0; lit.bands()]);
        for (values, point) in values.chunks_exact_mut(bands.len()).zip(points) {
            cursor.at(*point, &mut all);
            let passes = beam.map_or(0.0, |(beam, towards_sun)| beam.near(*point, towards_sun, &[])[0]);
            values.iter_mut().zip(bands).for_each(|(value, band)| *value = all[*band] + passes);
        }
    });
    values
}

/// What names need that figures only number.
struct Told<'a> {
    species: &'a Species,
    points: &'a [[f32; 3]],
    suns_deg: &'a [Option<[f64; 2]>],
}

impl Told<'_> {
    fn change(&self, figures: Figures) -> LightChange {
        let Figures { rms, p99, mean, worst } = figures;
        LightChange { rms, p99, mean, points: self.points.len(), worst: self.worst(&worst) }
    }

    fn worst(&self, sample: &Sample) -> Worst {
        Worst {
            point_m: self.points[sample.point],
            sun_deg: self.suns_deg[sample.light],
            band: self.species.meta.model.band(sample.band).to_owned(),
            old: sample.old,
            new: sample.new,
            share: sample.share,
        }
    }

    fn reason(&self, none: NoFigures) -> String {
        match none {
            NoFigures::NoPoints => "the old file has no matter, or no light".to_owned(),
            NoFigures::Black => "the old light is black, the new is not".to_owned(),
            NoFigures::NotFinite(sample) => {
                let Worst { point_m: [x, y, z], sun_deg, band, old, new, .. } = self.worst(&sample);
                let sun = shown_sun(sun_deg);
                format!("{band} is {old} -> {new} at {x} {y} {z} m under {sun}, expected finite numbers")
            }
        }
    }
}
