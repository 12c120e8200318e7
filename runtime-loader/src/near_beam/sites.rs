//! The sites of a medium that hold matter, for near beams that are found for all of them at once.

use flb_format::beam::{MAX_MEANS, Near};
use flb_format::error::Place;
use flb_format::light::SunBasis;
use flb_format::matter::TurbidMedium;
use flb_format::sample::{corners, locate};
use flb_format::{FormatError, room};

use super::{PreparedSun, dense, everywhere};
use crate::extinction::Extinction;
use crate::sun_terms::SunTerms;

/// No matter in a site.
const EMPTY: u32 = u32::MAX;

/// The extinction at every site, and which of them hold matter.
#[derive(Debug)]
pub(crate) struct MediumSites {
    turbid: TurbidMedium,
    /// Sites with matter, ascending.
    sites: Vec<u32>,
    /// `[site]`: place in `sites`, or [`EMPTY`].
    place: Vec<u32>,
}

impl MediumSites {
    /// Lists the sites of a medium.
    ///
    /// # Errors
    /// Where there is no memory for the lists.
    pub(crate) fn new(turbid: TurbidMedium) -> Result<MediumSites, FormatError> {
        // A list of sites that grows is copied to one of twice its length.
        room::ask(Place::file(0), "sites with matter", 8 * turbid.grid.sites() as u64)?;
        let place = room::filled(Place::file(0), "places of sites", EMPTY, turbid.grid.sites())?;
        Ok(MediumSites::listed(turbid, place))
    }

    /// Of extinction that is kept where there is some.
    pub(crate) fn of(extinction: &Extinction) -> MediumSites {
        let turbid = extinction.to_dense();
        let place = vec![EMPTY; turbid.grid.sites()];
        MediumSites::listed(turbid, place)
    }

    fn listed(turbid: TurbidMedium, mut place: Vec<u32>) -> MediumSites {
        let sites = turbid.sites();
        (0..).zip(&sites).for_each(|(at, &site)| place[site as usize] = at);
        MediumSites { turbid, sites, place }
    }

    /// The extinction, in m^-1.
    pub(crate) fn turbid(&self) -> &TurbidMedium {
        &self.turbid
    }

    /// Sites with matter, ascending.
    pub(crate) fn sites(&self) -> &[u32] {
        &self.sites
    }

    /// The place of a site among them.
    pub(crate) fn place_of(&self, site: usize) -> Option<usize> {
        Some(self.place[site]).filter(|place| *place != EMPTY).map(|place| place as usize)
    }

    /// Memory that extinction and lists take.
    pub(crate) fn size_bytes(&self) -> usize {
        self.turbid.leaf_per_m.len() * 8 + (self.sites.len() + self.place.len()) * 4
    }

    /// What makes near beams of suns; `single` says whether they need light scattered once.
    pub(crate) fn near(&self, single: bool) -> Near<'_> {
        Near::new(&self.turbid, &self.sites, single)
    }

    /// The near beam of a sun at every site with matter; nothing where the fields of `suns` need none.
    pub(crate) fn prepare(&self, suns: &SunBasis, near: &Near, terms: SunTerms, rays: u32) -> PreparedSun {
        let mut all = Vec::new();
        if suns.has_near_beam() {
            let beam = near.beam(terms.towards_sun, rays);
            let means = 1 + beam.around.len();
            let mean = |j, site| if j < means { beam.mean(j, site) } else { 0.0 };
            all = (0..self.sites.len()).map(|site| std::array::from_fn(|j| mean(j, site))).collect();
        }
        PreparedSun { terms, near: all }
    }

    /// Means of the near beam at a point: over those of the eight sites that hold matter, by their trilinear weights;
    /// where none does, the beam at the point itself, and no light scattered once.
    ///
    /// # Panics
    /// If the sun was prepared for another medium.
    pub(crate) fn near_at(
        &self,
        prepared: &PreparedSun,
        single: bool,
        point_model_m: [f32; 3],
    ) -> [f32; MAX_MEANS] {
        let (mut sum, mut weights) = ([0.0; MAX_MEANS], 0.0);
        self.around(point_model_m, |place, w| {
            let near = &prepared.near[place];
            sum.iter_mut().zip(near).for_each(|(sum, near)| *sum += w * near);
            weights += w;
        });
        if weights > 0.0 {
            return sum.map(|sum| sum / weights);
        }
        let point = self.turbid.grid.lattice_from_model(point_model_m.map(f64::from));
        everywhere(dense::transmittance(&self.turbid, point, prepared.terms.towards_sun), single)
    }

    /// Tells the places of those of the eight sites around a point that hold matter, with their trilinear weights.
    pub(crate) fn around(&self, point_model_m: [f32; 3], mut tell: impl FnMut(usize, f32)) {
        let grid = &self.turbid.grid;
        let at = locate(grid.lattice, grid.lattice_from_model(point_model_m.map(f64::from)));
        let n = grid.lattice as usize;
        let (mut first, mut part) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let texel = at.block[axis] as f32 * flb_format::block::STRIDE as f32 + at.local[axis];
            first[axis] = (texel as usize).min(n - 2);
            part[axis] = texel - first[axis] as f32;
        }
        for ([x, y, z], weight) in corners(part) {
            let site = ((first[2] + z) * n + first[1] + y) * n + first[0] + x;
            if let Some(place) = self.place_of(site) {
                tell(place, weight);
            }
        }
    }
}
