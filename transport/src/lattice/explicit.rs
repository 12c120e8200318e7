//! The plain dense solver: the papers' iteration over the whole lattice, f32, all cores.
//!
//! Every site, empty or not, takes what its 18 neighbours sent and sends it on, in every iteration, so memory
//! bandwidth is the bound: [`SITE_BYTES`] per site and iteration. It shares the collision with the sweep solver and
//! nothing else: a second way to the same fixed point. The rest density of wood is eliminated, as there.

mod light;
mod matter;

use flb_format::direction::MOVING;
use flb_format::matter::Optics;
use flb_format::progress::{Cancelled, Progress};
use flb_format::{Field, Medium};

use super::collision;
use super::course::{CROSSINGS, Course, TREND_SPAN};
use super::kernel::{Gain, LANES};
use super::{Solution, SolveSettings, dense, finish, solved_bases};
use light::Light;
use matter::SiteList;

/// Least memory traffic of an iteration per site, bytes: 18 values are read and 18 written. They are written where they
/// were read, so no line of the cache is fetched only to be overwritten.
pub const SITE_BYTES: usize = 2 * MOVING * size_of::<f32>();

/// All bases of all bands, one after the other. Input as [`solve`](super::solve) has checked it. An iteration counts
/// as a sweep.
pub(super) fn solve(
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    progress: &Progress<'_>,
) -> Result<Solution, Cancelled> {
    let bands = optics.bands.len() as u32;
    let sites = medium.grid.sites();
    let mut matter = SiteList::new(medium);
    let mut light = Light::new(medium.grid.lattice as usize);
    let (mut others, mut reports) = (Vec::new(), Vec::new());
    let solved = solved_bases(settings);
    for (at, base) in solved.iter().enumerate() {
        let mut field = Field::zeros(medium.grid.lattice, bands);
        for (band, of_band) in optics.bands.iter().enumerate() {
            let done = at * bands as usize + band;
            progress(done as f64 / (solved.len() * bands as usize) as f64)?;
            let gains = collision::gains(of_band).map(|gain| Gain::new(&[gain; LANES]));
            light.darken(base);
            matter.darken();
            let course = relax(&mut light, &mut matter, &gains, settings);
            let phi = &mut field.values_mut()[band * sites..][..sites];
            light.cross_empty_sites(&matter);
            light.gather(phi);
            matter.write(phi);
            dense::hold_boundary(phi, medium.grid.lattice as usize, dense::boundary_light(usize::from(base)));
            reports.push(course.report(base, band as u32, settings));
        }
        others.push((base, field));
    }
    Ok(finish(medium, bands, settings, others, reports))
}

/// Iterates until the residual is below the tolerance or no iteration is left, or as often as is asked for.
fn relax(light: &mut Light, matter: &mut SiteList, gains: &[Gain; 2], settings: &SolveSettings) -> Course {
    let mut course = Course::default();
    let steps = settings.steps.map(|steps| steps.count(matter.lattice as u32));
    for iteration in 1..=steps.unwrap_or(settings.max_sweeps) as usize {
        let [change, norm] = light.update(matter, gains);
        course.note(change, norm);
        if steps.is_some() {
            continue;
        }
        // Before light has crossed the lattice, residuals say nothing: what is dark yet does not change. And while it
        // goes to and fro for the first times, they rise now and then, which is no reason to give up.
        let crossed = iteration > matter.lattice + TREND_SPAN && course.is_converged(settings);
        if crossed || iteration > CROSSINGS * matter.lattice && course.is_hopeless(settings) {
            break;
        }
    }
    course
}
