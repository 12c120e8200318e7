//! The near beam at the centres of texels, with matter or without.

use flb_format::beam::MAX_MEANS;
use flb_format::blocks::{EDGE, TEXELS};
use flb_format::sample::site_of;

use super::texel_at;
use crate::InstanceLight;
use crate::near_beam::MediumSites;

/// The near beam at the centres of texels.
pub(super) struct NearTexels<'a> {
    light: &'a InstanceLight<'a>,
    /// Those with matter; none where the light needs no near beam.
    sites: Option<&'a MediumSites>,
    /// `[place]`
    of_sites: Vec<[f32; MAX_MEANS]>,
}

impl<'a> NearTexels<'a> {
    pub(super) fn of(light: &'a InstanceLight<'a>) -> NearTexels<'a> {
        let sites = light.species.sites().filter(|_| light.terms.needs_near()).map(|sites| &**sites);
        let mut near = NearTexels { light, sites, of_sites: Vec::new() };
        if let Some(sites) = sites {
            let grid = light.species.grid();
            let of_site = |site: &u32| near.at(grid.site(*site as usize).map(|x| f64::from(x) + 0.5));
            near.of_sites = sites.sites().iter().map(of_site).collect();
        }
        near
    }

    fn at(&self, point: [f64; 3]) -> [f32; MAX_MEANS] {
        self.light.near(self.light.species.grid().model_from_lattice(point).map(|x| x as f32))
    }

    /// The means of the texels of a block. A texel without matter takes the mean of those with matter around it, since
    /// a sample beside them leaves it out; where there are none, the mean of its block.
    pub(super) fn of_block(&self, first: [usize; 3]) -> [[f32; MAX_MEANS]; TEXELS] {
        let Some(sites) = self.sites else { return [[0.0; MAX_MEANS]; TEXELS] };
        let lattice = self.light.species.grid().lattice as usize;
        let place = |[x, y, z]: [usize; 3]| sites.place_of((z * lattice + y) * lattice + x);
        let of = |texel: [usize; 3]| place(texel).map(|place| self.of_sites[place]);
        let found: [Option<[f32; MAX_MEANS]>; TEXELS] = std::array::from_fn(|number| {
            let texel = texel_at(first, number);
            of(texel).or_else(|| mean(around(texel, lattice).filter_map(of)))
        });
        let rest = mean(found.iter().flatten().copied())
            .unwrap_or_else(|| self.at(first.map(|texel| (texel + EDGE / 2) as f64)));
        found.map(|found| found.unwrap_or(rest))
    }
}

/// A texel and those around it.
fn around(texel: [usize; 3], lattice: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..27).filter_map(move |number: usize| {
        let offset = site_of(number, 3);
        let at: [usize; 3] = std::array::from_fn(|axis| texel[axis] + offset[axis] as usize);
        at.iter().all(|x| (1..=lattice).contains(x)).then(|| at.map(|x| x - 1))
    })
}

fn mean(all: impl Iterator<Item = [f32; MAX_MEANS]>) -> Option<[f32; MAX_MEANS]> {
    let (mut sum, mut count) = ([0.0; MAX_MEANS], 0_u32);
    for one in all {
        sum.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
        count += 1;
    }
    (count > 0).then(|| sum.map(|sum| sum / count as f32))
}
