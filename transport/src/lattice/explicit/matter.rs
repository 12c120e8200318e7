//! The sites that change light, in short runs: what the explicit solver does beside moving light on.

use flb_format::Medium;
use flb_format::matter::Class;

use super::super::kernel::{Gain, LANES, Lanes};
use super::MOVING;

/// The non-empty sites of a lattice.
pub(super) struct SiteList {
    /// N.
    pub lattice: usize,
    /// Runs of each plane z, by y, then x.
    pub planes: Vec<Vec<Run>>,
}

/// [`LANES`] neighbouring sites of a row, all inside the lattice's outermost layer. Runs share no non-empty site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    pub y: usize,
    /// Coordinate x of the first site.
    pub x: usize,
    /// Densities of leaf and of wood; 0 also where another run serves the site.
    rho: [Lanes; 2],
    /// Light of the iteration before; 0 where the density is.
    phi: Lanes,
}

impl SiteList {
    /// Input as [`solve`](super::super::solve) has checked it: the outer two layers are empty.
    pub(super) fn new(medium: &Medium) -> SiteList {
        let n = medium.grid.lattice as usize;
        let row = |y: usize, z: usize| {
            let at = (z * n + y) * n;
            let (density, class) = (&medium.density[at..][..n], &medium.class[at..][..n]);
            let mut runs = vec![];
            let mut free = 0;
            while let Some(first) = (free..n).find(|&x| density[x] > 0.0) {
                let x = first.min(n - 1 - LANES);
                let rho = [Class::Leaf, Class::Wood].map(|of| {
                    let counts = |lane: usize| x + lane >= first && class[x + lane] == of;
                    Lanes(std::array::from_fn(|lane| if counts(lane) { density[x + lane] } else { 0.0 }))
                });
                runs.push(Run { y, x, rho, phi: Lanes::default() });
                free = x + LANES;
            }
            runs
        };
        SiteList { lattice: n, planes: (0..n).map(|z| (0..n).flat_map(|y| row(y, z)).collect()).collect() }
    }

    /// Forgets all light.
    pub(super) fn darken(&mut self) {
        self.planes.iter_mut().flatten().for_each(|run| run.phi = Lanes::default());
    }

    /// Puts the light of the non-empty sites into `phi`, `[z][y][x]`.
    pub(super) fn write(&self, phi: &mut [f32]) {
        let n = self.lattice;
        for (z, runs) in self.planes.iter().enumerate() {
            for run in runs {
                run.lanes().for_each(|lane| phi[(z * n + run.y) * n + run.x + lane] = run.phi.0[lane]);
            }
        }
    }
}

impl Run {
    /// Lanes of its non-empty sites.
    pub(super) fn lanes(&self) -> impl Iterator<Item = usize> {
        (0..LANES).filter(|&lane| self.rho[0].0[lane] + self.rho[1].0[lane] > 0.0)
    }

    /// Replaces the light that arrives, `[m - 1]`, by what is sent; lanes without density keep it. Sums of
    /// (phi - before)^2 and phi^2 over the run's non-empty sites.
    pub(super) fn collide(&mut self, gains: &[Gain; 2], light: &mut [Lanes; MOVING]) -> [f64; 2] {
        let arriving = *light;
        let (mut sent, mut of_class) = ([Lanes::default(); MOVING], Lanes::default());
        let mut phi = Lanes::default();
        for (gain, rho) in gains.iter().zip(&self.rho) {
            if rho.0.iter().all(|rho| *rho == 0.0) {
                continue;
            }
            gain.collide(rho, &arriving, &mut sent, &mut of_class);
            light.iter_mut().zip(&sent).for_each(|(light, sent)| choose(rho, sent, light));
            choose(rho, &of_class, &mut phi);
        }
        let mut sums = [0.0; 2];
        for lane in 0..LANES {
            let step = f64::from(phi.0[lane] - self.phi.0[lane]);
            sums[0] += step * step;
            sums[1] += f64::from(phi.0[lane]) * f64::from(phi.0[lane]);
        }
        self.phi = phi;
        sums
    }
}

/// Takes over the lanes that have density.
fn choose(rho: &Lanes, from: &Lanes, to: &mut Lanes) {
    for lane in 0..LANES {
        to.0[lane] = if rho.0[lane] > 0.0 { from.0[lane] } else { to.0[lane] };
    }
}
