//! Two libraries compared by their light: the gate of a build that runs every night.
//!
//! Each of the two is a folder that [`build`](crate::build::build) wrote, or a `.flb` file. A species whose bytes are
//! others is sampled in both: at the sites of the old file that hold matter, [`MAX_POINTS`] at most by a fixed stride,
//! under the suns of [`SUNS_DEG`], and under the sky where both have light of it. The light is that of
//! [`SpeciesLight`](flb_runtime::SpeciesLight). Where a file leaves the sun's beam to the renderer, the beam at the
//! point is added, as the plant's matter lets it through: an eye sees both. Each difference counts as a share of the
//! mean old light over points and bands, under the suns or under the sky.

mod figures;
mod files;
mod junit;
mod light;
mod page;
mod pictures;
mod report;
mod side;
#[cfg(test)]
mod tests;

use std::path::Path;

use flb_format::container::Species;
use flb_runtime::Library;
use rayon::prelude::*;

pub use files::{FILES, files};
pub use light::{MAX_POINTS, SUNS_DEG};
pub use report::{Comparison, Count, LightChange, SpeciesComparison, State, Worst, percent};

use crate::FarmError;
use light::compare_light;
use side::{Side, content_digest};

/// Follower of a comparison. Every method may do nothing.
pub trait CompareObserver: Sync {
    /// Called when a species that changed has been compared.
    fn compared(&self, species: &SpeciesComparison, done: usize, total: usize) {
        let _ = (species, done, total);
    }

    /// Called before the light of species is read, to refuse what takes too much memory.
    ///
    /// # Errors
    /// A sentence for [`FarmError::Room`].
    fn admit(&self, light: &[(&Library, &Species)]) -> Result<(), String> {
        let _ = light;
        Ok(())
    }
}

/// Compares two libraries. Of light, that of one species is in memory at a time. The same input has the same outcome
/// with any number of threads. Where `fail_above` is set, species fail whose rms difference is larger, whose light
/// cannot be compared, and that are gone.
///
/// # Errors
/// A folder, an index or a file that cannot be read, or is none; a refusal of the observer.
pub fn compare(
    old: &Path,
    new: &Path,
    fail_above: Option<f64>,
    observer: &dyn CompareObserver,
) -> Result<Comparison, FarmError> {
    let sides = [Side::open(old)?, Side::open(new)?];
    let [before, after] = &sides;
    let (in_both, gone): (Vec<&String>, Vec<&String>) =
        before.species.keys().partition(|name| after.species.contains_key(*name));
    let added = after.species.keys().filter(|name| !before.species.contains_key(*name));
    let alone = |state| move |name: &String| SpeciesComparison::new(name.clone(), state);
    check_all(&sides)?;
    let are_same: Vec<Result<bool, FarmError>> =
        in_both.par_iter().map(|name| is_same(&sides, name)).collect();
    let are_same = are_same.into_iter().collect::<Result<Vec<bool>, FarmError>>()?;
    let total = are_same.iter().filter(|is_same| !**is_same).count();
    let mut species: Vec<SpeciesComparison> = gone.into_iter().map(alone(State::Removed)).collect();
    species.extend(added.map(alone(State::Added)));
    let mut done = 0;
    for (name, is_same) in in_both.into_iter().zip(are_same) {
        if is_same {
            species.push(SpeciesComparison::new(name.clone(), State::Unchanged));
            continue;
        }
        let one = changed(&sides, name, observer)?;
        done += 1;
        observer.compared(&one, done, total);
        species.push(one);
    }
    let names = sides.each_ref().map(|side| side.path.display().to_string());
    Ok(Comparison::of(names, fail_above, species))
}

/// Checks that every file of both has the bytes that its index tells of.
fn check_all(sides: &[Side; 2]) -> Result<(), FarmError> {
    let all: Vec<(&Side, &String)> =
        sides.iter().flat_map(|side| side.species.keys().map(move |name| (side, name))).collect();
    // The first error in the order of the names, whatever the threads are.
    let checked: Vec<Result<(), FarmError>> = all.par_iter().map(|(side, name)| side.check(name)).collect();
    checked.into_iter().collect()
}

/// Whether both have the same bytes of a species.
fn is_same([old, new]: &[Side; 2], name: &str) -> Result<bool, FarmError> {
    if old.species[name].is_same(&new.species[name]) {
        return Ok(true);
    }
    let digest = |side: &Side| {
        let (library, at) = side.species(name)?;
        content_digest(&library, at)
    };
    Ok(digest(old)? == digest(new)?)
}

/// Compares a species of other bytes.
fn changed(
    [old, new]: &[Side; 2],
    name: &str,
    observer: &dyn CompareObserver,
) -> Result<SpeciesComparison, FarmError> {
    let (before, at_before) = old.species(name)?;
    let (after, at_after) = new.species(name)?;
    let species = |library: &'_ Library, at: usize| library.container().species()[at].clone();
    let (one, other) = (species(&before, at_before), species(&after, at_after));
    observer.admit(&[(&before, &one), (&after, &other)]).map_err(FarmError::Room)?;
    let found = compare_light((&before, at_before), (&after, at_after))?;
    let (light, incomparable) = match found.light {
        Ok(light) => (Some(light), None),
        Err(reason) => (None, Some(reason)),
    };
    let pictures = match [old, new].map(|side| side.species[name].picture()) {
        [Some(old), Some(new)] => Some([old.to_owned(), new.to_owned()]),
        _ => None,
    };
    let differs = found.differs;
    Ok(SpeciesComparison {
        incomparable,
        light,
        differs,
        pictures,
        ..SpeciesComparison::new(name.to_owned(), State::Changed)
    })
}
