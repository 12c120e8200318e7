//! Multiple scattering of a group of suns at once, in one band: x = x_1 + K W x by fixed-point steps and Anderson
//! mixing.
//!
//! x holds the moments of the scattered light per site, x_1 those of the light scattered once, W what a site scatters
//! of each degree, K one pass of the [`march`](super::march). Light that a site sends to itself is summed exactly (the
//! step is divided by 1 - W (1 - escape)): dense sites would creep otherwise.
//!
//! As K loses no light and W is at most the albedo, the error is at most the step over 1 - albedo; the rate of the last
//! steps gives a tighter estimate, and the smaller of both counts.

use super::halves::add_each;
use super::lanes::{LANES, Lanes};
use super::march::March;
use super::moments::{Exchange, Moments, ScatteringMoments, degree, up_moment};

/// Steps that the mixing remembers (Anderson, 1965).
pub(super) const MEMORY: usize = 2;

/// Scattered light and how it was reached.
pub(super) struct Relaxed<const M: usize> {
    /// Moments of the scattered light; the first is its fluence.
    pub light: Moments<M>,
    /// Passes done.
    pub passes: u32,
    /// Estimated relative L2 error of the fluence, the worst of the lanes.
    pub error_estimate: f64,
}

/// K W x: what arrives of the light x, scattered once more.
pub(super) fn arrives<const M: usize>(
    march: &March,
    gains: &ScatteringMoments,
    light: &Moments<M>,
) -> Moments<M> {
    let mut sites: Vec<Exchange<M>> = sending_out(gains, light).collect();
    march.pass(&mut sites);
    sites.iter().map(Exchange::arrives).collect()
}

/// Sites that send out W x, where nothing has arrived.
fn sending_out<const M: usize>(
    gains: &ScatteringMoments,
    light: &Moments<M>,
) -> impl Iterator<Item = Exchange<M>> {
    light.iter().zip(&gains.gains).zip(&gains.leaning).map(|((light, gain), leaning)| {
        let mut source = std::array::from_fn(|a| gain[degree(a)] * light[a]);
        if let Some(&[a, b, c, d, e]) = light.get(4..9) {
            source[0] += *leaning * up_moment([a, b, c, d, e]);
        }
        Exchange { source, excess: [Lanes::default(); M] }
    })
}

/// Iterates from `start`, else from the light scattered once, until the estimated error of every lane is within
/// `tolerance`, or `most` passes are done. Errors are relative to the light of the lane, or to a greater one: `sizes`
/// are sums of squares.
pub(super) fn source_iteration<const M: usize>(
    march: &March,
    gains: &ScatteringMoments,
    first: &Moments<M>,
    start: Option<Moments<M>>,
    sizes: [f64; LANES],
    tolerance: f64,
    most: u32,
) -> Relaxed<M> {
    let mut light = start.unwrap_or_else(|| first.clone());
    let mut sites = Vec::with_capacity(first.len());
    let mut step = vec![[Lanes::default(); M]; first.len()];
    let mut mixing = Mixing { before: None, kept: Vec::new() };
    let mut course = Course::new(gains);
    while course.passes < most {
        sites.clear();
        sites.extend(sending_out(gains, &light));
        march.pass(&mut sites);
        course.note(become_step(march, gains, first, &sites, &light, &mut step, sizes));
        if course.error_estimate <= tolerance {
            add_each(light.as_flattened_mut(), step.as_flattened());
            break;
        }
        mixing.advance(&mut light, &step);
    }
    Relaxed { light, passes: course.passes, error_estimate: course.error_estimate }
}

/// How far a group of suns has come.
pub(super) struct Course {
    albedo: f64,
    pub passes: u32,
    /// Estimated relative L2 error of the fluence, the worst of the lanes.
    pub error_estimate: f64,
    residual: f64,
}

impl Course {
    pub(super) fn new(gains: &ScatteringMoments) -> Course {
        let unknown = f64::INFINITY;
        Course { albedo: gains.albedo(), passes: 0, error_estimate: unknown, residual: unknown }
    }

    /// Takes the residual that a pass left.
    pub(super) fn note(&mut self, residual: f64) {
        self.passes += 1;
        let rate = (residual / self.residual).min(0.999);
        self.residual = residual;
        let of_rate = if self.passes > 2 { residual / (1.0 - rate) } else { f64::INFINITY };
        self.error_estimate =
            if self.albedo < 1.0 { of_rate.min(residual / (1.0 - self.albedo)) } else { of_rate };
        if residual == 0.0 {
            self.error_estimate = 0.0;
        }
    }
}

/// `step` becomes (x_1 + K W x - x) / (1 - W (1 - escape)). Gives its size relative to
/// the light, the worst of the lanes.
fn become_step<const M: usize>(
    march: &March,
    gains: &ScatteringMoments,
    first: &Moments<M>,
    sites: &[Exchange<M>],
    light: &Moments<M>,
    step: &mut Moments<M>,
    sizes: [f64; LANES],
) -> f64 {
    let (mut change, mut norm) = ([0.0_f64; LANES], [0.0_f64; LANES]);
    for (site, step) in step.iter_mut().enumerate() {
        let (gain, stays, arrives) = (&gains.gains[site], 1.0 - march.escape[site], sites[site].arrives());
        for a in 0..M {
            let whole = 1.0 / (1.0 - gain[degree(a)] * stays);
            step[a] = whole * (first[site][a] + arrives[a] - light[site][a]);
        }
        for lane in 0..LANES {
            let (step, light) = (f64::from(step[0].0[lane]), f64::from(light[site][0].0[lane]));
            change[lane] += step * step;
            norm[lane] += light * light;
        }
    }
    residual(&change, &norm, &sizes)
}

/// Size of a step relative to the light, from their sums of squares: the worst of the lanes.
pub(super) fn residual(change: &[f64; LANES], norm: &[f64; LANES], sizes: &[f64; LANES]) -> f64 {
    let relative = |lane: usize| match (change[lane], norm[lane].max(sizes[lane])) {
        (0.0, _) => 0.0,
        (_, 0.0) => 1.0,
        (change, norm) => libm::sqrt(change / norm),
    };
    (0..LANES).map(relative).fold(0.0, f64::max)
}

/// Anderson mixing: the next start is x + f - sum over k of gamma_k (dx_k + df_k), gamma minimising |f - sum gamma_k
/// df_k| in each lane.
struct Mixing<const M: usize> {
    /// The last x and f.
    before: Option<(Moments<M>, Moments<M>)>,
    /// Changes of x and f, the oldest first.
    kept: Vec<(Moments<M>, Moments<M>)>,
}

impl<const M: usize> Mixing<M> {
    fn advance(&mut self, light: &mut Moments<M>, step: &Moments<M>) {
        match self.before.take() {
            Some((mut x, mut f)) => {
                let full = self.kept.len() == MEMORY;
                let mut spare = if full { self.kept.remove(0) } else { (x.clone(), f.clone()) };
                become_change(&mut x, light);
                become_change(&mut f, step);
                self.kept.push((x, f));
                spare.0.copy_from_slice(light);
                spare.1.copy_from_slice(step);
                self.before = Some(spare);
            }
            None => self.before = Some((light.clone(), step.clone())),
        }
        let gamma = self.gamma(step);
        for (site, light) in light.iter_mut().enumerate() {
            for a in 0..M {
                for lane in 0..LANES {
                    let mut value = light[a].0[lane] + step[site][a].0[lane];
                    for ((dx, df), gamma) in self.kept.iter().zip(&gamma) {
                        value -= gamma[lane] * (dx[site][a].0[lane] + df[site][a].0[lane]);
                    }
                    light[a].0[lane] = value;
                }
            }
        }
    }

    /// Least squares by the normal equations, two by two at most.
    fn gamma(&self, step: &Moments<M>) -> [[f32; LANES]; MEMORY] {
        let mut gamma = [[0.0; LANES]; MEMORY];
        let products: Vec<Vec<[f64; LANES]>> = self
            .kept
            .iter()
            .map(|(_, a)| self.kept.iter().map(|(_, b)| b).chain([step]).map(|b| dot(a, b)).collect())
            .collect();
        for lane in 0..LANES {
            let of_lane = least_squares(products.len(), |i, j| products[i][j][lane]);
            gamma.iter_mut().zip(of_lane).for_each(|(gamma, of_lane)| gamma[lane] = of_lane);
        }
        gamma
    }
}

/// Weights of the `kept` last changes, the oldest first. `p` gives the products of the changes of f with each other,
/// and with f itself, which comes last.
pub(super) fn least_squares(kept: usize, p: impl Fn(usize, usize) -> f64) -> [f32; MEMORY] {
    match kept {
        1 if p(0, 0) > 0.0 => [(p(0, 1) / p(0, 0)) as f32, 0.0],
        2 if p(0, 0) > 0.0 && p(1, 1) > 0.0 => {
            let determinant = p(0, 0) * p(1, 1) - p(0, 1) * p(1, 0);
            // Nearly parallel changes: the last one alone.
            if determinant > 1e-8 * p(0, 0) * p(1, 1) {
                let first = ((p(0, 2) * p(1, 1) - p(1, 2) * p(0, 1)) / determinant) as f32;
                [first, ((p(1, 2) * p(0, 0) - p(0, 2) * p(1, 0)) / determinant) as f32]
            } else {
                [0.0, (p(1, 2) / p(1, 1)) as f32]
            }
        }
        _ => [0.0; MEMORY],
    }
}

/// `before` becomes `now - before`.
fn become_change<const M: usize>(before: &mut Moments<M>, now: &Moments<M>) {
    for (before, now) in before.iter_mut().zip(now) {
        for a in 0..M {
            for lane in 0..LANES {
                before[a].0[lane] = now[a].0[lane] - before[a].0[lane];
            }
        }
    }
}

/// Scalar products per lane, summed in the order of the sites.
fn dot<const M: usize>(a: &Moments<M>, b: &Moments<M>) -> [f64; LANES] {
    let mut sum = [0.0_f64; LANES];
    for (a, b) in a.iter().zip(b) {
        for (a, b) in a.iter().zip(b) {
            for ((sum, a), b) in sum.iter_mut().zip(a.0).zip(b.0) {
                *sum += f64::from(a * b);
            }
        }
    }
    sum
}
