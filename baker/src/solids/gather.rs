//! What comes to points of solids out of the open hemisphere.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::progress::{Cancelled, Progress};
use flb_scene::MaterialClass;
use flb_scene::rays::{Ray, RayMesh};
use flb_scene::sampling::{cosine_hemisphere, hash, r2_sequence};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::points::{SolidPoint, SolidPoints, rays_of};
use super::{Places, Solids};

/// The first of them, which tell whether a side is inside of a solid.
const SCOUTS: u32 = 8;

/// A side of which fewer rays than this share get out of the solid is seen by no camera.
pub(super) const OPEN: f32 = 1.0 / 16.0;

/// One side of a point, and what comes to it.
pub(super) struct Side {
    /// Point at which readers sample, in lattice coordinates (site i covers i..i+1).
    pub sample: [f64; 3],
    /// Weight of the side: the area that it stands for, in faces of a site, times the share of its rays that do not end
    /// inside of a solid.
    pub weight: f32,
    /// Place of its own site.
    pub place: Option<usize>,
}

/// A side with the light that comes to it, `[item][band]`.
type LitSide = (Side, Vec<f32>);

/// All sides that something comes to.
pub(super) struct Gathered {
    pub sides: Vec<Side>,
    /// `[side][item][band]`: four times the irradiance.
    pub light: Vec<f32>,
    /// Items times bands.
    pub width: usize,
    pub bands: usize,
}

impl Gathered {
    /// What comes to a side.
    pub(super) fn of(&self, side: usize, column: usize, band: usize) -> f32 {
        self.light[side * self.width + column * self.bands + band]
    }
}

/// Light that matter sends out.
pub(super) struct Sent {
    /// `[place][item][band]`: all light of the site.
    light: Vec<f32>,
    /// `[place][item]`: what leaves meet beyond that of the beams; empty where they favour no inclination.
    beyond: Vec<f32>,
    /// `[place][leaf, wood][band]`: albedo times what matter receives of it.
    factors: Vec<f32>,
    pub bands: usize,
    pub width: usize,
}

impl Sent {
    pub(super) fn new(solids: &Solids) -> Sent {
        let Solids { total, received, .. } = solids;
        let (items, bands_count) = (total.items.len(), received.len());
        let sites = total.values.first().and_then(|of_band| of_band.first()).map_or(0, Vec::len);
        let width = items * bands_count;
        let mut light = vec![0.0; sites * width];
        light.par_chunks_mut(width.max(1)).enumerate().for_each(|(place, out)| {
            for (band, of_band) in total.values.iter().enumerate() {
                for (item, of_item) in of_band.iter().enumerate() {
                    out[item * bands_count + band] = of_item[place];
                }
            }
        });
        let skies = total.items.iter().take_while(|item| **item == 0).count();
        let mut beyond = vec![0.0; if total.beyond.is_empty() { 0 } else { sites * items }];
        beyond.par_chunks_mut(items.max(1)).enumerate().for_each(|(place, out)| {
            out[skies..].iter_mut().zip(&total.beyond).for_each(|(out, beyond)| *out = beyond[place]);
        });
        let mut factors = vec![0.0; sites * 2 * bands_count];
        factors.par_chunks_mut(2 * bands_count).enumerate().for_each(|(place, out)| {
            for (band, received) in received.iter().enumerate() {
                let [leaf, wood] = received[place];
                out[band] = leaf.total * leaf.albedo;
                out[bands_count + band] = wood.total * wood.albedo;
            }
        });
        Sent { light, beyond, factors, bands: bands_count, width }
    }

    /// Adds what a kind of matter in a site sends out, four pi times its radiance.
    pub(super) fn add(&self, place: usize, wood: bool, out: &mut [f32]) {
        let factors = &self.factors[(2 * place + usize::from(wood)) * self.bands..][..self.bands];
        let light = &self.light[place * self.width..][..self.width];
        let items = self.width / self.bands;
        let beyond = self.beyond.get(place * items..(place + 1) * items).filter(|_| !wood);
        let of_items = out.chunks_exact_mut(self.bands).zip(light.chunks_exact(self.bands));
        for (item, (out, light)) in of_items.enumerate() {
            let beyond = beyond.map_or(0.0, |beyond| beyond[item]);
            for ((out, light), factor) in out.iter_mut().zip(light).zip(factors) {
                *out += (light + beyond) * factor;
            }
        }
    }
}

/// Gathers at both sides of all points.
pub(super) fn gather(
    solids: &Solids,
    rays: &RayMesh,
    places: &Places,
    points: &SolidPoints,
    progress: &Progress<'_>,
) -> Result<Gathered, Cancelled> {
    let sent = Sent::new(solids);
    let sky = solids.total.items.first() == Some(&0);
    let count = rays_of(points.points.len());
    let tracer = Tracer { solids, rays, places, sent: &sent, points, sky, count };
    let done = AtomicUsize::new(0);
    let of_point = |(number, point): (usize, &SolidPoint)| {
        let found = [1.0, -1.0].map(|side| tracer.side(number as u32, point, side));
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_multiple_of(1024) {
            progress(count as f64 / points.points.len() as f64)?;
        }
        Ok(found)
    };
    let found = points.points.par_iter().enumerate().map(of_point);
    let found = found.collect::<Result<Vec<[Option<LitSide>; 2]>, Cancelled>>()?;
    let (sides, light): (Vec<Side>, Vec<Vec<f32>>) = found.into_iter().flatten().flatten().unzip();
    Ok(Gathered { sides, light: light.concat(), width: sent.width, bands: sent.bands })
}

/// Where a ray ended.
enum End {
    Sky,
    /// Matter of the site at a place, and whether it is wood.
    Matter(usize, bool),
    /// Behind the surface of a solid.
    Inside,
    /// Matter that is none of the plant's.
    Nothing,
}

struct Tracer<'a> {
    solids: &'a Solids<'a>,
    rays: &'a RayMesh<'a>,
    places: &'a Places,
    sent: &'a Sent,
    points: &'a SolidPoints,
    sky: bool,
    /// Rays from each side.
    count: u32,
}

impl Tracer<'_> {
    fn side(&self, number: u32, point: &SolidPoint, side: f32) -> Option<LitSide> {
        let normal = side * point.normal;
        let seed = hash(2 * number + u32::from(side < 0.0));
        let mut light = vec![0.0; self.sent.width];
        let mut inside = 0;
        for i in 0..self.count {
            if i == SCOUTS && inside == SCOUTS {
                return None;
            }
            let [height, turn] = r2_sequence(seed, i);
            let origin = point.at + normal * self.points.lift;
            let ray = Ray { origin, direction: cosine_hemisphere(normal, height, turn) };
            match self.end(ray, point.triangle) {
                End::Sky if self.sky => light[..self.sent.bands].iter_mut().for_each(|sum| *sum += 1.0),
                End::Matter(place, wood) => self.sent.add(place, wood, &mut light),
                End::Inside => inside += 1,
                End::Sky | End::Nothing => {}
            }
        }
        let open = 1.0 - inside as f32 / self.count as f32;
        if open < OPEN {
            return None;
        }
        light.iter_mut().for_each(|sum| *sum /= self.count as f32);
        let grid = &self.solids.turbid.grid;
        let at =
            point.at.as_dvec3() + normal.as_dvec3() * (flb_format::sample::SOLID_OFFSET * grid.spacing_m);
        let place = place_near(self.solids, self.places, point.at, normal);
        let weight = self.points.area as f32 * open;
        Some((Side { sample: grid.lattice_from_model(at.to_array()), weight, place }, light))
    }

    fn end(&self, ray: Ray, except: u32) -> End {
        match meet(self.solids, self.rays, self.points.inward, ray, except) {
            Met::Sky => End::Sky,
            Met::Neither => End::Nothing,
            Met::Plant { inside: true, .. } => End::Inside,
            Met::Plant { is_wood, at, .. } => match place_near(self.solids, self.places, at, ray.direction) {
                Some(place) => End::Matter(place, is_wood),
                None => End::Nothing,
            },
        }
    }
}

/// What a ray meets first.
pub(super) enum Met {
    Sky,
    /// Matter that is none of the plant's.
    Neither,
    Plant {
        is_wood: bool,
        at: Vec3,
        /// Of the triangle; `None` where it has no area.
        front: Option<Vec3>,
        /// Whether that is the surface of a solid from behind.
        inside: bool,
    },
}

/// What a ray meets but for the triangle `except`; solids face inwards or outwards.
pub(super) fn meet(solids: &Solids, rays: &RayMesh, inward: bool, ray: Ray, except: u32) -> Met {
    let Some(found) = rays.find(ray, f32::INFINITY, Some(except)) else { return Met::Sky };
    let material = rays.mesh.triangle_material[found.triangle as usize];
    let is_wood = match solids.classed.classes[material as usize] {
        MaterialClass::Leaf => false,
        MaterialClass::Wood => true,
        MaterialClass::Neither => return Met::Neither,
    };
    let front = rays.front(found.triangle);
    let is_behind = |front: Vec3| {
        let outward = if inward { -front } else { front };
        outward.dot(ray.direction) > 0.0
    };
    let inside = is_wood && front.is_some_and(is_behind);
    Met::Plant { is_wood, at: ray.origin + ray.direction * found.distance, front, inside }
}

/// The place of the site of a point on a surface; a little way along a direction where rounding put it on the wrong
/// side of a border.
pub(super) fn place_near(solids: &Solids, places: &Places, met: Vec3, direction: Vec3) -> Option<usize> {
    let grid = &solids.turbid.grid;
    let at = |point: DVec3| {
        let site = grid.lattice_from_model(point.to_array()).map(|c| c.floor());
        let within = site.iter().all(|c| (0.0..f64::from(grid.lattice)).contains(c));
        within.then(|| places.of(grid.index(site[0] as u32, site[1] as u32, site[2] as u32))).flatten()
    };
    let step = direction.as_dvec3() * (grid.spacing_m * 1e-3);
    at(met.as_dvec3()).or_else(|| at(met.as_dvec3() + step)).or_else(|| at(met.as_dvec3() - step))
}
