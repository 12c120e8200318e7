//! Light between walls and the leaves that they enclose, in a box or deep in a pot.
//!
//! Elsewhere matter that a ray meets sends out the light of its site. A wall's site has one light for both of its
//! sides, so that a leaf behind the wall is lit by what falls before it. Here points on the walls and on the leaves
//! stand for the surfaces around them, each side by itself, and send light to each other by radiosity [G84]: of a side,
//!
//! ```text
//! light = straight + mean over its rays of (albedo x light of the side that the ray meets)
//! ```
//!
//! `straight` is the sky's and the suns' own light. Leaves elsewhere send what the solve found in their sites.

use flb_format::light::SunBasis;
use flb_format::progress::{Cancelled, Progress};
use flb_format::sun::harmonics;
use flb_scene::extents::Walls;
use flb_scene::rays::{Ray, RayMesh};
use flb_scene::sampling::{cosine_hemisphere, hash, r2_sequence};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::gather::{Gathered, Met, OPEN, Sent, Side, meet, place_near};
use super::points::{SolidPoint, SolidPoints, rays_of};
use super::ringing::Ringing;
use super::{Places, Solids};

/// Rounds after which light is left as it is: of walls that send back 0.9, 0.1 % is left then.
const MAX_ROUNDS: usize = 64;

/// Change of the mean light in a round that ends them.
const SETTLED: f64 = 1e-3;

/// Cosine between the normal of a hit and that of the point that stands for it, at least.
const ALIKE: f32 = 0.5;

/// Where a ray ended.
#[derive(Debug, Clone, Copy)]
enum End {
    Sky,
    /// Matter that sends nothing.
    Nothing,
    /// A leaf of a site that is not enclosed, by the place of the site.
    Cloud(u32),
    /// A side of a point.
    Side(u32),
}

/// What rays from a side found.
struct Traced {
    ends: Box<[End]>,
    /// Per item: light that comes straight from the sky or a sun.
    straight: Vec<f32>,
    /// Share of rays that do not meet a solid from its inside.
    open: f32,
}

/// Points of solids and of enclosed leaves, two sides each.
pub(super) struct Surfaces<'a> {
    solids: &'a Solids<'a>,
    rays: &'a RayMesh<'a>,
    places: &'a Places,
    wood: &'a SolidPoints,
    leaves: &'a SolidPoints,
    /// Rays from each side.
    count: u32,
    /// The non-empty sites.
    sites: Vec<u32>,
    /// Per point, those of solids first: the place of its site.
    place_of: Vec<Option<usize>>,
    /// Points per site, by place.
    by_site: Vec<Vec<u32>>,
}

impl<'a> Surfaces<'a> {
    pub(super) fn new(
        solids: &'a Solids<'a>,
        rays: &'a RayMesh<'a>,
        places: &'a Places,
        [wood, leaves]: [&'a SolidPoints; 2],
    ) -> Surfaces<'a> {
        let all = wood.points.iter().chain(&leaves.points);
        let place_of: Vec<_> = all.map(|point| place_near(solids, places, point.at, point.normal)).collect();
        let sites = solids.turbid.sites();
        let mut by_site = vec![Vec::new(); sites.len()];
        for (number, place) in (0u32..).zip(&place_of) {
            if let Some(place) = *place {
                by_site[place].push(number);
            }
        }
        let count = rays_of(place_of.len());
        Surfaces { solids, rays, places, wood, leaves, count, sites, place_of, by_site }
    }

    /// What comes to all sides, less the straight light of suns.
    pub(super) fn gather(&self, progress: &Progress<'_>) -> Result<Gathered, Cancelled> {
        let sent = Sent::new(self.solids);
        let traced: Vec<Traced> =
            (0..2 * self.place_of.len()).into_par_iter().map(|side| self.trace(side)).collect();
        progress(0.5)?;
        let light = self.balance(&traced, &sent);
        let (width, bands) = (sent.width, sent.bands);
        let grid = &self.solids.turbid.grid;
        let (mut sides, mut found) = (Vec::new(), Vec::new());
        let ringing = matches!(self.solids.walls, Walls::Enclosing(_)).then(Ringing::new);
        for ((number, traced), light) in traced.iter().enumerate().zip(light.chunks_exact(width)) {
            let (weight, offset) = match self.is_wood(number / 2) {
                true if traced.open < OPEN => continue,
                true => (self.wood.area as f32 * traced.open, flb_format::sample::SOLID_OFFSET),
                false => (self.leaves.area as f32, 0.0),
            };
            let (at, normal) = self.side(number);
            let at = at.as_dvec3() + normal.as_dvec3() * (offset * grid.spacing_m);
            let place = self.place_of[number / 2];
            sides.push(Side { sample: grid.lattice_from_model(at.to_array()), weight, place });
            let of_items = light.chunks_exact(bands).zip(&traced.straight).zip(&self.solids.total.items);
            found.extend(of_items.flat_map(|((light, straight), item)| {
                let own = if *item == 0 { 0.0 } else { *straight };
                light.iter().map(move |light| light - own)
            }));
            let end = found.len() - width;
            if let Some(ringing) = &ringing {
                self.settle_ringing(ringing, &mut found[end..], bands);
            }
        }
        progress(1.0)?;
        Ok(Gathered { sides, light: found, width, bands })
    }

    /// Keeps the harmonics of a side's light, `[item][band]`, from giving less than nothing.
    fn settle_ringing(&self, ringing: &Ringing, light: &mut [f32], bands: usize) {
        let SunBasis::Harmonics { .. } = self.solids.suns else { return };
        let Some(first) = self.solids.total.items.iter().position(|item| *item != 0) else { return };
        let harmonics = &mut light[first * bands..];
        for band in 0..bands {
            let coefficients: Vec<f32> = harmonics.iter().skip(band).step_by(bands).copied().collect();
            let kept = ringing.kept(&coefficients);
            harmonics.iter_mut().skip(band).step_by(bands).skip(1).for_each(|light| *light *= kept);
        }
    }

    fn point(&self, number: usize) -> &SolidPoint {
        self.wood.points.get(number).unwrap_or_else(|| &self.leaves.points[number - self.wood.points.len()])
    }

    fn is_wood(&self, point: usize) -> bool {
        point < self.wood.points.len()
    }

    /// Where a side is, and its normal.
    fn side(&self, number: usize) -> (Vec3, Vec3) {
        let point = self.point(number / 2);
        (point.at, if number.is_multiple_of(2) { point.normal } else { -point.normal })
    }

    fn trace(&self, number: usize) -> Traced {
        let (at, normal) = self.side(number);
        let triangle = self.point(number / 2).triangle;
        let origin = at + normal * self.wood.lift;
        let seed = hash(number as u32);
        let items = &self.solids.total.items;
        let mut straight = vec![0.0; items.len()];
        let mut inside = 0;
        let of_ray = |i: u32| {
            let [height, turn] = r2_sequence(seed, i);
            let ray = Ray { origin, direction: cosine_hemisphere(normal, height, turn) };
            let (end, from_inside) = self.end(ray, triangle);
            inside += u32::from(from_inside);
            if let End::Sky = end {
                self.add_sky(ray.direction, &mut straight);
            }
            end
        };
        let ends = (0..self.count).map(of_ray).collect();
        straight.iter_mut().for_each(|sum| *sum /= self.count as f32);
        for (straight, &item) in straight.iter_mut().zip(items) {
            let Some(sun) = self.solids.suns.sun_of(item) else { continue };
            let sun = DVec3::from(sun).as_vec3();
            let cos = normal.dot(sun);
            if cos > 0.0 && !self.rays.is_blocked(Ray { origin, direction: sun }, Some(triangle)) {
                *straight = 4.0 * cos;
            }
        }
        Traced { ends, straight, open: 1.0 - inside as f32 / self.count as f32 }
    }

    /// Adds a ray that meets nothing to what comes from the sky, and from the suns of each harmonic.
    fn add_sky(&self, direction: Vec3, straight: &mut [f32]) {
        let of_harmonics = match self.solids.suns {
            SunBasis::Harmonics { .. } => Some(harmonics::evaluate(direction.as_dvec3().to_array())),
            SunBasis::Lattice18 | SunBasis::Directions(_) => None,
        };
        for (straight, &item) in straight.iter_mut().zip(&self.solids.total.items) {
            match (item, of_harmonics) {
                (0, _) => *straight += 1.0,
                (_, Some(values)) => *straight += values[usize::from(item) - 1] as f32,
                (_, None) => {}
            }
        }
    }

    /// Where a ray ends, and whether that is a solid from its inside.
    fn end(&self, ray: Ray, except: u32) -> (End, bool) {
        let (is_wood, at, normal, inside) = match meet(self.solids, self.rays, self.wood.inward, ray, except)
        {
            Met::Sky => return (End::Sky, false),
            Met::Neither => return (End::Nothing, false),
            Met::Plant { is_wood, at, front, inside } => {
                (is_wood, at, front.unwrap_or(-ray.direction), inside)
            }
        };
        let Some(place) = place_near(self.solids, self.places, at, ray.direction) else {
            return (End::Nothing, inside);
        };
        if !is_wood && !self.places.is_enclosed(place) {
            return (End::Cloud(place as u32), inside);
        }
        let end = match self.standing_for(place, at, normal, is_wood) {
            Some(number) => {
                let is_back = self.point(number).normal.dot(ray.direction) >= 0.0;
                End::Side(2 * number as u32 + u32::from(is_back))
            }
            None => End::Nothing,
        };
        (end, inside)
    }

    /// The nearest point on a surface of a kind that lies as the surface which was met, in its site, else around it.
    fn standing_for(&self, place: usize, met: Vec3, normal: Vec3, is_wood: bool) -> Option<usize> {
        let nearest = |places: &mut dyn Iterator<Item = usize>| {
            let mut best: Option<(f32, usize)> = None;
            for number in places.flat_map(|place| &self.by_site[place]).map(|&number| number as usize) {
                let point = self.point(number);
                let distance = point.at.distance_squared(met);
                let fits = self.is_wood(number) == is_wood && point.normal.dot(normal).abs() > ALIKE;
                if fits && best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, number));
                }
            }
            best.map(|(_, number)| number)
        };
        let grid = &self.solids.turbid.grid;
        let around = || grid.cube_around(grid.site(self.sites[place] as usize));
        nearest(&mut std::iter::once(place))
            .or_else(|| nearest(&mut around().filter_map(|site| self.places.of(site))))
    }

    /// Light of all sides when what they send to each other has settled, `[side][item][band]`.
    fn balance(&self, traced: &[Traced], sent: &Sent) -> Vec<f32> {
        let (width, bands) = (sent.width, sent.bands);
        let mut outside = vec![0.0_f32; traced.len() * width];
        outside.par_chunks_mut(width).zip(traced).for_each(|(light, traced)| {
            for &end in &traced.ends {
                if let End::Cloud(place) = end {
                    sent.add(place as usize, false, light);
                }
            }
            light.iter_mut().for_each(|sum| *sum /= self.count as f32);
            for (light, straight) in light.chunks_exact_mut(bands).zip(&traced.straight) {
                light.iter_mut().for_each(|light| *light += straight);
            }
        });
        let mut light = outside.clone();
        for _ in 0..MAX_ROUNDS {
            let sending = self.sending(&light, sent);
            let mut next = outside.clone();
            next.par_chunks_mut(width).zip(traced).for_each(|(light, traced)| {
                let mut sum = vec![0.0_f32; width];
                for &end in &traced.ends {
                    if let End::Side(side) = end {
                        let from = &sending[side as usize * width..][..width];
                        sum.iter_mut().zip(from).for_each(|(sum, from)| *sum += from);
                    }
                }
                light.iter_mut().zip(sum).for_each(|(light, sum)| *light += sum / self.count as f32);
            });
            let change: f64 = light.iter().zip(&next).map(|(a, b)| f64::from((a - b).abs())).sum();
            let all: f64 = next.iter().map(|light| f64::from(light.abs())).sum();
            light = next;
            if change <= SETTLED * all {
                break;
            }
        }
        light
    }

    /// What each side sends out of its light. A leaf sends the mean of both sides to either.
    fn sending(&self, light: &[f32], sent: &Sent) -> Vec<f32> {
        let (width, bands) = (sent.width, sent.bands);
        let mut sending = vec![0.0_f32; light.len()];
        sending.par_chunks_mut(width).enumerate().for_each(|(number, sending)| {
            let (is_wood, place) = (self.is_wood(number / 2), self.place_of[number / 2]);
            let Some(place) = place else { return };
            let own = &light[number * width..][..width];
            let other = if is_wood { own } else { &light[(number ^ 1) * width..][..width] };
            for (i, sending) in sending.iter_mut().enumerate() {
                let [leaf, wood] = self.solids.received[i % bands][place];
                let albedo = if is_wood { wood.albedo } else { leaf.albedo };
                *sending = albedo * 0.5 * (own[i] + other[i]);
            }
        });
        sending
    }
}
