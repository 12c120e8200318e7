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

use flb_format::SunBasis;
use flb_format::direction::DIRECTIONS;
use flb_format::sun::harmonics;
use flb_scene::MaterialClass;
use flb_scene::rays::{Ray, RayMesh};
use flb_scene::sampling::{around, hash, sequence};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::gather::{Gathered, OPEN, RAYS, Sent, Side, place_near};
use super::points::{SolidPoint, SolidPoints};
use super::{Places, Solids};

/// Rounds after which light is left as it is: of walls that send back 0.9, 0.1 % is left then.
const MOST_ROUNDS: usize = 64;

/// Change of the mean light in a round that ends them.
const SETTLED: f64 = 1e-3;

/// Cosine between the normal of a hit and that of the point that stands for it, at least.
const ALIKE: f32 = 0.5;

/// What a ray met.
#[derive(Debug, Clone, Copy)]
enum End {
    /// Nothing, or matter that sends nothing.
    Nothing,
    /// A leaf of a site that is not enclosed, by the place of the site.
    Cloud(u32),
    /// A side of a point.
    Side(u32),
}

/// What rays from a side found.
struct Traced {
    ends: [End; RAYS as usize],
    /// Per item: light that comes straight from the sky or a sun.
    straight: Vec<f32>,
    /// Share of rays that do not meet a solid from its inside.
    open: f32,
}

/// Points of solids and of enclosed leaves.
pub struct Surfaces<'a> {
    pub solids: &'a Solids<'a>,
    pub rays: &'a RayMesh<'a>,
    pub places: &'a Places,
    pub wood: &'a SolidPoints,
    pub leaves: &'a SolidPoints,
}

impl Surfaces<'_> {
    /// What comes to all sides, less the straight light of suns.
    pub fn gather(&self, progress: &(dyn Fn(f64) + Sync)) -> Gathered {
        let sent = Sent::new(self.solids);
        let by_site = self.by_site();
        let traced: Vec<Traced> =
            (0..2 * self.count()).into_par_iter().map(|side| self.trace(side, &by_site)).collect();
        progress(0.5);
        let light = self.balance(&traced, &sent);
        let (width, bands) = (sent.width, sent.bands);
        let mut sides = Vec::new();
        let mut found = Vec::new();
        for (number, traced) in traced.iter().enumerate() {
            let (point, turn, is_wood) = self.side(number);
            if is_wood && traced.open < OPEN {
                continue;
            }
            let (open, area, offset) = match is_wood {
                true => (traced.open, self.wood.area, flb_format::SOLID_OFFSET),
                false => (1.0, self.leaves.area, 0.0),
            };
            let grid = &self.solids.turbid.grid;
            let normal = turn * point.normal;
            let at = point.at.as_dvec3() + normal.as_dvec3() * (offset * grid.spacing_m);
            let place = place_near(self.solids, self.places, point.at, normal);
            sides.push(Side {
                sample: grid.lattice_from_model(at.to_array()),
                weight: area as f32 * open,
                place,
            });
            let of_side =
                light[number * width..][..width].chunks_exact(bands).zip(&traced.straight).enumerate();
            found.extend(of_side.flat_map(|(item, (light, straight))| {
                let own = if self.solids.total.items[item] == 0 { 0.0 } else { *straight };
                light.iter().map(move |light| light - own)
            }));
        }
        progress(1.0);
        Gathered { sides, light: found, width, bands }
    }

    fn count(&self) -> usize {
        self.wood.points.len() + self.leaves.points.len()
    }

    fn point(&self, number: usize) -> &SolidPoint {
        self.wood.points.get(number).unwrap_or_else(|| &self.leaves.points[number - self.wood.points.len()])
    }

    /// The point of a side, which way the side faces, and whether it is wood.
    fn side(&self, number: usize) -> (&SolidPoint, f32, bool) {
        let turn = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        (self.point(number / 2), turn, number / 2 < self.wood.points.len())
    }

    /// Points per site, by place.
    fn by_site(&self) -> Vec<Vec<u32>> {
        let mut by_site = vec![Vec::new(); self.solids.turbid.sites().len()];
        for number in 0..self.count() {
            let point = self.point(number);
            if let Some(place) = place_near(self.solids, self.places, point.at, point.normal) {
                by_site[place].push(number as u32);
            }
        }
        by_site
    }

    fn trace(&self, number: usize, by_site: &[Vec<u32>]) -> Traced {
        let (point, turn, _) = self.side(number);
        let normal = turn * point.normal;
        let lift = self.wood.lift;
        let origin = point.at + normal * lift;
        let seed = hash(number as u32);
        let items = &self.solids.total.items;
        let mut straight = vec![0.0; items.len()];
        let mut inside = 0;
        let ends = std::array::from_fn(|i| {
            let [height, turn] = sequence(seed, i as u32);
            let ray = Ray { origin, direction: around(normal, height, turn) };
            let (end, from_inside) = self.end(ray, point.triangle, by_site);
            inside += u32::from(from_inside);
            let Some(end) = end else {
                self.add_sky(ray.direction, &mut straight);
                return End::Nothing;
            };
            end
        });
        straight.iter_mut().for_each(|sum| *sum /= RAYS as f32);
        for (straight, &item) in straight.iter_mut().zip(items) {
            let Some(sun) = sun_of(item, self.solids.suns) else { continue };
            let cos = normal.dot(sun);
            if cos > 0.0 && !self.rays.is_blocked(Ray { origin, direction: sun }, Some(point.triangle)) {
                *straight = 4.0 * cos;
            }
        }
        Traced { ends, straight, open: 1.0 - inside as f32 / RAYS as f32 }
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

    /// What a ray meets, `None` for the sky; and whether that is a solid from its inside.
    fn end(&self, ray: Ray, except: u32, by_site: &[Vec<u32>]) -> (Option<End>, bool) {
        let Some(found) = self.rays.find(ray, f32::INFINITY, Some(except)) else { return (None, false) };
        let Some(is_wood) = self.is_wood(found.triangle) else { return (Some(End::Nothing), false) };
        let met = ray.origin + ray.direction * found.distance;
        let normal = self.rays.front(found.triangle).unwrap_or(-ray.direction);
        let inside = is_wood && (normal.dot(ray.direction) > 0.0) != self.wood.inward;
        let Some(place) = place_near(self.solids, self.places, met, ray.direction) else {
            return (Some(End::Nothing), inside);
        };
        if !is_wood && !self.solids.is_enclosed(place) {
            return (Some(End::Cloud(place as u32)), inside);
        }
        let end = match self.standing_for(place, met, normal, is_wood, by_site) {
            Some(number) => {
                let faces = self.point(number).normal.dot(ray.direction) < 0.0;
                End::Side(2 * number as u32 + u32::from(!faces))
            }
            None => End::Nothing,
        };
        (Some(end), inside)
    }

    /// Whether a triangle is wood or leaf; `None` where it is neither.
    fn is_wood(&self, triangle: u32) -> Option<bool> {
        let material = self.rays.mesh.triangle_material[triangle as usize];
        match self.solids.classed.classes[material as usize] {
            MaterialClass::Leaf => Some(false),
            MaterialClass::Wood => Some(true),
            MaterialClass::Neither => None,
        }
    }

    /// The nearest point on a surface of a kind that lies as the surface which was met, in its site, else around it.
    fn standing_for(
        &self,
        place: usize,
        met: Vec3,
        normal: Vec3,
        is_wood: bool,
        by_site: &[Vec<u32>],
    ) -> Option<usize> {
        let nearest = |places: &mut dyn Iterator<Item = usize>| {
            let mut best: Option<(f32, usize)> = None;
            for number in places.flat_map(|place| &by_site[place]).map(|&number| number as usize) {
                let point = self.point(number);
                let distance = point.at.distance_squared(met);
                let fits =
                    (number < self.wood.points.len()) == is_wood && point.normal.dot(normal).abs() > ALIKE;
                if fits && best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, number));
                }
            }
            best.map(|(_, number)| number)
        };
        nearest(&mut std::iter::once(place)).or_else(|| nearest(&mut self.around(met)))
    }

    /// Places of the sites in the cube of three around a point's.
    fn around(&self, point: Vec3) -> impl Iterator<Item = usize> + '_ {
        let grid = &self.solids.turbid.grid;
        let middle = grid.lattice_from_model(point.as_dvec3().to_array()).map(|c| c.floor() as i64);
        (0..27).filter_map(move |i: i64| {
            let site = [middle[0] + i % 3 - 1, middle[1] + i / 3 % 3 - 1, middle[2] + i / 9 - 1];
            let within = site.iter().all(|c| (0..i64::from(grid.lattice)).contains(c));
            within
                .then(|| self.places.of(grid.index(site[0] as u32, site[1] as u32, site[2] as u32)))
                .flatten()
        })
    }

    /// Light of all sides when what they send to each other has settled, `[side][item][band]`.
    fn balance(&self, traced: &[Traced], sent: &Sent) -> Vec<f32> {
        let (width, bands) = (sent.width, sent.bands);
        let mut outside = vec![0.0_f32; traced.len() * width];
        outside.par_chunks_mut(width).zip(traced).for_each(|(light, traced)| {
            for end in traced.ends {
                if let End::Cloud(place) = end {
                    sent.add(place as usize, false, light);
                }
            }
            light.iter_mut().for_each(|sum| *sum /= RAYS as f32);
            for (light, straight) in light.chunks_exact_mut(bands).zip(&traced.straight) {
                light.iter_mut().for_each(|light| *light += straight);
            }
        });
        let mut light = outside.clone();
        for _ in 0..MOST_ROUNDS {
            let sending = self.sending(&light, sent);
            let mut next = outside.clone();
            next.par_chunks_mut(width).zip(traced).for_each(|(light, traced)| {
                let mut sum = vec![0.0_f32; width];
                for end in traced.ends {
                    if let End::Side(side) = end {
                        let from = &sending[side as usize * width..][..width];
                        sum.iter_mut().zip(from).for_each(|(sum, from)| *sum += from);
                    }
                }
                light.iter_mut().zip(sum).for_each(|(light, sum)| *light += sum / RAYS as f32);
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
            let (point, _, is_wood) = self.side(number);
            let Some(place) = place_near(self.solids, self.places, point.at, point.normal) else { return };
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

/// The direction towards the sun of an item, for bases whose items are suns.
fn sun_of(item: u8, suns: &SunBasis) -> Option<Vec3> {
    let towards = match suns {
        SunBasis::Harmonics { .. } => return None,
        SunBasis::Lattice18 => -DVec3::from(DIRECTIONS[usize::from(item)].map(f64::from)),
        SunBasis::Directions(list) => DVec3::from(*list.directions().get(usize::from(item).checked_sub(1)?)?),
    };
    towards.try_normalize().map(|towards| towards.as_vec3())
}
