//! From the beams of many suns to the light that the plant scatters, in several bands.
//!
//! ```text
//! beams -first scattering-> x_1 -one pass-> x_2 -harmonics of the sun, source iteration-> the rest of each sun
//! ```
//!
//! Light that was scattered three times or more hardly depends on where the sun stands. Where albedos are low it is
//! solved for a few harmonics of the sun's direction in place of every sun ([`super::smooth`]). Suns that are held out,
//! and the sky, are always solved to the end by themselves.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::beam::Beam;
use flb_format::progress::{Cancelled, Progress};
use rayon::prelude::*;

use super::OrdinatesSettings;
use super::band::Band;
use super::halves::{HALVINGS, by_halves};
use super::lanes::{LANES, Lanes};
use super::march::March;
use super::moments::Moments;
use super::smooth::Smooth;
use super::source_iteration::{Relaxed, arrives, source_iteration};
use super::suns::SolvePlan;

/// Scattered light of one band.
#[derive(Clone, Default)]
pub(super) struct Lit {
    /// Scattered fluence `[sun][site]`, the sky last where it is wanted.
    pub light: Vec<Vec<f32>>,
    /// Suns that were solved, the sky included. The light of others was made of that of other bands.
    pub solved: u32,
    pub passes: u32,
    pub error_estimate: f64,
}

impl Lit {
    fn solved(light: Vec<Vec<f32>>, passes: u32, error_estimate: f64) -> Lit {
        Lit { solved: light.len() as u32, light, passes, error_estimate }
    }
}

/// What a scatter is made of.
#[derive(Clone, Copy)]
pub(super) struct Scattering<'a> {
    pub march: &'a March,
    pub plan: &'a SolvePlan,
    /// One per sun of the plan.
    pub beams: &'a [&'a Beam],
    /// Light of the sky from below the horizon, relative to that above.
    pub below: f32,
    /// Fluence of the sky before any scattering, where that is wanted.
    pub open_sky: Option<&'a [f32]>,
    pub settings: &'a OrdinatesSettings,
    /// Whether the rest of the light may be solved for harmonics of the sun.
    pub may_be_smooth: bool,
}

impl<'a> Scattering<'a> {
    /// Light of all suns of a plan, of which the rest may be smooth.
    pub(super) fn whole(
        march: &'a March,
        plan: &'a SolvePlan,
        beams: &'a [&'a Beam],
        below: f32,
        open_sky: Option<&'a [f32]>,
        settings: &'a OrdinatesSettings,
    ) -> Scattering<'a> {
        Scattering { march, plan, beams, below, open_sky, settings, may_be_smooth: true }
    }
}

impl Scattering<'_> {
    /// Scattered light of all suns, and of a sky of fluence 1 where that is wanted, in each band.
    pub(super) fn scatter(&self, bands: &[Band], progress: &Progress<'_>) -> Result<Vec<Lit>, Cancelled> {
        let groups = self.groups();
        let sets = sets(bands, groups.len());
        let (done, all) = (AtomicUsize::new(0), sets.len() * groups.len());
        let step = || progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
        let made = sets
            .par_iter()
            .map(|set| {
                let of_set: Vec<&Band> = set.iter().map(|&band| &bands[band]).collect();
                match of_set[0].moments {
                    1 => self.of_bands::<1>(&of_set, &groups, &step),
                    4 => self.of_bands::<4>(&of_set, &groups, &step),
                    _ => self.of_bands::<9>(&of_set, &groups, &step),
                }
            })
            .collect::<Result<Vec<Vec<Lit>>, Cancelled>>()?;
        let mut of_bands: Vec<(usize, Lit)> =
            sets.into_iter().flatten().zip(made.into_iter().flatten()).collect();
        of_bands.sort_by_key(|(band, _)| *band);
        Ok(of_bands.into_iter().map(|(_, lit)| lit).collect())
    }

    /// All suns. The sky goes with the last ones, or by itself where they fill their lanes.
    pub(super) fn groups(&self) -> Vec<Group<'_>> {
        let chunks = self.beams.chunks(LANES).enumerate();
        let mut groups: Vec<Group> =
            chunks.map(|(at, beams)| Group { first_sun: at * LANES, beams, sky: false }).collect();
        if self.open_sky.is_some() {
            match groups.last_mut().filter(|_| !self.beams.len().is_multiple_of(LANES)) {
                Some(last) => last.sky = true,
                None => groups.push(Group { first_sun: self.beams.len(), beams: &[], sky: true }),
            }
        }
        groups
    }

    /// Up to [`TOGETHER`] bands.
    fn of_bands<const M: usize>(
        &self,
        bands: &[&Band],
        groups: &[Group],
        step: &Step,
    ) -> Result<Vec<Lit>, Cancelled> {
        match *bands {
            [a] => self.of_set::<M, 1>([a], groups, step),
            [a, b] => self.of_set::<M, 2>([a, b], groups, step),
            [a, b, c] => self.of_set::<M, 3>([a, b, c], groups, step),
            _ => unreachable!("a set has up to {TOGETHER} bands"),
        }
    }

    fn of_set<const M: usize, const B: usize>(
        &self,
        bands: [&Band; B],
        groups: &[Group],
        step: &Step,
    ) -> Result<Vec<Lit>, Cancelled> {
        let smooth: Vec<Option<Smooth>> = bands.iter().map(|band| self.smooth(band)).collect();
        let sky = self.sky::<M>();
        // One part per band.
        let of_group = |group: &[Group]| -> Result<Vec<Part<M>>, Cancelled> {
            let [group] = group else { unreachable!("groups are halved to the last") };
            let first = self.march.first_scattering::<M, B>(bands.map(|band| &band.matter), group.beams);
            let sky = sky.as_ref().filter(|_| group.sky);
            let made =
                first.into_par_iter().zip(&bands).zip(&smooth).map(|((first, band), smooth)| match smooth {
                    Some(smooth) => {
                        let next = |light: &Moments<M>| arrives(self.march, &band.gains, light);
                        self.begun(smooth, group, first, sky, next)
                    }
                    None => self.solved(band, group, first, sky),
                });
            let made = made.collect();
            step()?;
            Ok(made)
        };
        let add = |sum: &mut Result<Vec<Part<M>>, Cancelled>, other: Result<Vec<Part<M>>, Cancelled>| match (
            &mut *sum, other,
        ) {
            (Ok(sum), Ok(other)) => sum.iter_mut().zip(other).for_each(|(sum, other)| sum.add(other)),
            (Ok(_), cancelled) => *sum = cancelled,
            (Err(_), _) => {}
        };
        let parts = by_halves(groups, u32::MAX, &of_group, &add)?;
        let all = parts.into_par_iter().zip(bands).zip(smooth);
        let OrdinatesSettings { tolerance, max_passes, .. } = *self.settings;
        let joined = |((part, band), smooth): ((Part<M>, &Band), Option<Smooth>)| {
            part.joined(smooth.as_ref(), |wanted| {
                let relaxed = |wanted: &[Wanted<M>]| {
                    let (first, sizes) = (firsts_of(wanted), sizes_of(wanted));
                    source_iteration(self.march, &band.gains, &first, None, sizes, tolerance, max_passes)
                };
                Ok(wanted.par_chunks(LANES).map(relaxed).collect())
            })
        };
        all.map(joined).collect()
    }

    /// Harmonics of the sun, where the rest of the light is solved for these.
    pub(super) fn smooth(&self, band: &Band) -> Option<Smooth> {
        Smooth::of(self.plan, self.settings, band).filter(|_| self.may_be_smooth)
    }

    /// Moments of the sky before any scattering, where that is wanted.
    pub(super) fn sky<const M: usize>(&self) -> Option<Vec<[f32; M]>> {
        self.open_sky.map(|fluence| match M {
            1 => fluence.iter().map(|fluence| [*fluence; M]).collect(),
            _ => self.march.sky(self.below),
        })
    }

    /// All light of a group, solved to the end.
    fn solved<const M: usize>(
        &self,
        band: &Band,
        group: &Group,
        mut first: Moments<M>,
        sky: Option<&Vec<[f32; M]>>,
    ) -> Part<M> {
        if let Some(sky) = sky {
            let once = arrives(self.march, &band.gains, &lanes_of(&[sky]));
            group.set_sky(&mut first, &lane_of(&once, 0));
        }
        let OrdinatesSettings { tolerance, max_passes, .. } = *self.settings;
        let (start, sizes) = (group.start(band, &first), [0.0; LANES]);
        Part::solved(
            group,
            source_iteration(self.march, &band.gains, &first, start, sizes, tolerance, max_passes),
        )
    }

    /// The light of a group that was scattered once or twice, and what the rest is made of. `arrives` scatters light
    /// once more.
    pub(super) fn begun<const M: usize>(
        &self,
        smooth: &Smooth,
        group: &Group,
        mut first: Moments<M>,
        sky: Option<&Vec<[f32; M]>>,
        arrives: impl FnOnce(&Moments<M>) -> Moments<M>,
    ) -> Part<M> {
        // Of suns that are held out and of the sky, all is solved together with the rest of the others.
        let fitted = self.plan.fitted().saturating_sub(group.first_sun).min(group.beams.len());
        let apart = (fitted..group.beams.len()).map(|lane| lane_of(&first, lane)).collect();
        let mut part = Part { apart, ..Part::default() };
        if fitted > 0 || sky.is_some() {
            // The light of the sky goes along, one scattering behind.
            if let Some(sky) = sky {
                group.set_sky(&mut first, sky);
            }
            let next = arrives(&first);
            part.apart.extend(sky.map(|_| lane_of(&next, group.beams.len())));
            let both = |lane: usize| {
                first.iter().zip(&next).map(|(first, next)| first[0].0[lane] + next[0].0[lane]).collect()
            };
            part.light = (0..fitted).map(both).collect();
            part.passes = 1;
            part.smooth = smooth.project(&next, group.first_sun, fitted);
        }
        part
    }
}

/// Light that is solved for: its first scattering, and below which size errors do not count.
pub(super) type Wanted<'a, const M: usize> = (&'a Vec<[f32; M]>, f64);

/// First scatterings of up to [`LANES`] lights side by side.
pub(super) fn firsts_of<const M: usize>(wanted: &[Wanted<M>]) -> Moments<M> {
    let firsts: Vec<_> = wanted.iter().map(|(first, _)| *first).collect();
    lanes_of(&firsts)
}

/// Sizes of up to [`LANES`] lights.
pub(super) fn sizes_of<const M: usize>(wanted: &[Wanted<M>]) -> [f64; LANES] {
    std::array::from_fn(|lane| wanted.get(lane).map_or(0.0, |(_, size)| *size))
}

impl<const M: usize> Part<M> {
    /// Light of a group that was solved to the end.
    pub(super) fn solved(group: &Group, solved: Relaxed<M>) -> Part<M> {
        let Relaxed { light, passes, error_estimate } = solved;
        let light = (0..group.lanes()).map(|lane| fluence(&light, lane)).collect();
        Part { light, passes, error_estimate, ..Part::default() }
    }

    /// All light of a band, from what its groups made. `relax` solves for every [`LANES`] of what is wanted.
    pub(super) fn joined<E>(
        self,
        smooth: Option<&Smooth>,
        relax: impl FnOnce(&[Wanted<M>]) -> Result<Vec<Relaxed<M>>, E>,
    ) -> Result<Lit, E> {
        let Part { mut light, passes, error_estimate, smooth: sums, apart } = self;
        let Some(smooth) = smooth else { return Ok(Lit::solved(light, passes, error_estimate)) };
        let size = smooth.mean_square(&light);
        let wanted: Vec<Wanted<M>> =
            sums.iter().map(|sum| (sum, size)).chain(apart.iter().map(|first| (first, 0.0))).collect();
        let solved = relax(&wanted)?;
        let further = solved.iter().map(|solved| solved.passes).max().unwrap_or(0);
        let error_estimate = solved.iter().map(|solved| solved.error_estimate).fold(0.0, f64::max);
        let of_wanted = |at: usize| fluence(&solved[at / LANES].light, at % LANES);
        // What is solved for harmonics holds the light that it was begun with.
        let rest: Vec<Vec<f32>> = (0..sums.len())
            .into_par_iter()
            .map(|at| of_wanted(at).iter().zip(&sums[at]).map(|(all, begun)| all - begun[0]).collect())
            .collect();
        smooth.add_to_suns(&rest, &mut light);
        light.extend((sums.len()..wanted.len()).map(of_wanted));
        Ok(Lit::solved(light, passes + further, error_estimate))
    }
}

/// Called when a group was made.
type Step<'a> = dyn Fn() -> Result<(), Cancelled> + Sync + 'a;

/// Suns that go side by side, and perhaps the sky.
pub(super) struct Group<'a> {
    /// Number of the first.
    first_sun: usize,
    pub beams: &'a [&'a Beam],
    pub sky: bool,
}

impl Group<'_> {
    fn lanes(&self) -> usize {
        self.beams.len() + usize::from(self.sky)
    }

    /// Guess of the light of a band, where there is one; of moments but the fluence, those of the light scattered once.
    pub(super) fn start<const M: usize>(&self, band: &Band, first: &Moments<M>) -> Option<Moments<M>> {
        let guess = &band.guess.as_ref()?[self.first_sun..];
        let mut start = first.clone();
        for (lane, guess) in guess.iter().enumerate().take(self.lanes()) {
            start.iter_mut().zip(guess).for_each(|(moments, guess)| moments[0].0[lane] = *guess);
        }
        Some(start)
    }

    /// Puts light of the sky beside that of the suns.
    pub(super) fn set_sky<const M: usize>(&self, light: &mut Moments<M>, sky: &[[f32; M]]) {
        for (light, sky) in light.iter_mut().zip(sky) {
            light.iter_mut().zip(sky).for_each(|(lanes, value)| lanes.0[self.beams.len()] = *value);
        }
    }
}

/// Light of some groups in a band.
#[derive(Default)]
pub(super) struct Part<const M: usize> {
    /// `[lane][site]`: all of it, or what was scattered once or twice, of the suns that fields are made from.
    light: Vec<Vec<f32>>,
    passes: u32,
    error_estimate: f64,
    /// `[function][site]`: projections of what was scattered twice.
    smooth: Vec<Vec<[f32; M]>>,
    /// `[lane][site]`: what was scattered once, of suns that are held out and of the sky.
    apart: Vec<Vec<[f32; M]>>,
}

impl<const M: usize> Part<M> {
    /// Adds the groups that come next.
    pub(super) fn add(&mut self, next: Part<M>) {
        self.light.extend(next.light);
        self.passes = self.passes.max(next.passes);
        self.error_estimate = self.error_estimate.max(next.error_estimate);
        Smooth::add(&mut self.smooth, next.smooth);
        self.apart.extend(next.apart);
    }
}

fn fluence<const M: usize>(light: &Moments<M>, lane: usize) -> Vec<f32> {
    light.iter().map(|moments| moments[0].0[lane]).collect()
}

pub(super) fn lane_of<const M: usize>(light: &Moments<M>, lane: usize) -> Vec<[f32; M]> {
    light.iter().map(|moments| moments.map(|lanes| lanes.0[lane])).collect()
}

/// Up to [`LANES`] lights side by side.
pub(super) fn lanes_of<const M: usize>(lights: &[&Vec<[f32; M]>]) -> Moments<M> {
    let sites = lights[0].len();
    let of = |site: usize, a: usize| {
        Lanes(std::array::from_fn(|lane| lights.get(lane).map_or(0.0, |light| light[site][a])))
    };
    (0..sites).map(|site| std::array::from_fn(|a| of(site, a))).collect()
}

/// Most bands that go together.
const TOGETHER: usize = 3;

/// Numbers of the bands that go together: of one number of moments, and no more than leave work for every thread.
/// Results do not depend on it.
fn sets(bands: &[Band], groups: usize) -> Vec<Vec<usize>> {
    let wanted = rayon::current_num_threads().div_ceil(groups.max(1) << HALVINGS);
    let most = (bands.len() / wanted).clamp(1, TOGETHER);
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for (number, band) in bands.iter().enumerate() {
        match sets.iter_mut().find(|set| set.len() < most && bands[set[0]].moments == band.moments) {
            Some(set) => set.push(number),
            None => sets.push(vec![number]),
        }
    }
    sets
}
