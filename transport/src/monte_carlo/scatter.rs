//! Where light goes when it has met a leaf or wood.

use glam::DVec3;

use super::draw::Draw;
use crate::turbid::{BandScatter, INCLINATIONS, LeafAngles, Phase, Scatter};

/// Both kinds of matter in one band, ready to draw from.
pub(super) struct Scattering<'a> {
    leaf: Scatter,
    wood: Scatter,
    angles: &'a LeafAngles,
    /// Albedos of the sites in place of those of the matter.
    albedos: Option<&'a [[f32; 2]]>,
    /// Share of the leaf area up to and with each bin of inclination; `None` for leaves that favour no direction.
    cumulated: Option<[f64; INCLINATIONS]>,
}

impl<'a> Scattering<'a> {
    pub(super) fn new(
        scatter: &BandScatter,
        angles: &'a LeafAngles,
        albedos: Option<&'a [[f32; 2]]>,
    ) -> Scattering<'a> {
        let mut sum = 0.0;
        let cumulated = angles.shares().map(|share| {
            sum += share;
            sum
        });
        let cumulated = (*angles != LeafAngles::spherical()).then_some(cumulated);
        Scattering { leaf: scatter.leaf, wood: scatter.wood, angles, albedos, cumulated }
    }

    /// Extinction by leaves along a direction, relative to its mean over all.
    pub(super) fn relative(&self, direction: DVec3) -> f64 {
        if self.cumulated.is_some() { self.angles.relative(direction.y) } else { 1.0 }
    }

    /// The largest value of `relative`.
    pub(super) fn most_relative(&self) -> f64 {
        // The table is linear between places that are 1/256 apart.
        (0..=256).map(|i| self.relative(DVec3::Y * (f64::from(i) / 256.0))).fold(0.0, f64::max)
    }

    /// The larger albedo of a site.
    pub(super) fn albedo(&self, slot: u32) -> f64 {
        let [leaf, wood] = self.albedos(slot);
        leaf.max(wood)
    }

    fn albedos(&self, slot: u32) -> [f64; 2] {
        self.albedos.map_or([self.leaf.albedo, self.wood.albedo], |of| of[slot as usize].map(f64::from))
    }

    /// What light along `direction` meets in the site `slot` with this extinction by leaves and by wood.
    pub(super) fn meet(
        &self,
        slot: u32,
        [leaf, wood]: [f64; 2],
        direction: DVec3,
        draw: &mut Draw,
    ) -> Collision {
        let leaf = leaf * self.relative(direction);
        let [of_leaf, of_wood] = self.albedos(slot);
        match draw.unit() * (leaf + wood) < leaf {
            true => Collision { albedo: of_leaf, phase: self.leaf.phase, leaf: true },
            false => Collision { albedo: of_wood, phase: self.wood.phase, leaf: false },
        }
    }

    /// A direction after the collision.
    pub(super) fn turn(&self, met: &Collision, direction: DVec3, draw: &mut Draw) -> DVec3 {
        match met.phase {
            Phase::HenyeyGreenstein { g } => henyey_greenstein(g, direction, draw),
            Phase::BiLambert { transmitted } => {
                let normal = match &self.cumulated {
                    Some(cumulated) if met.leaf => inclined(cumulated, direction, draw),
                    // Density proportional to |n . d| over all normals.
                    _ => draw.lambert(-direction),
                };
                let through = draw.unit() < transmitted;
                draw.lambert(if through { -normal } else { normal })
            }
        }
    }
}

/// What a photon met.
pub(super) struct Collision {
    pub albedo: f64,
    phase: Phase,
    leaf: bool,
}

/// The cosine is the inverse of the cumulated function (Witt, 1977) with its division by g carried out, so that it
/// holds at g = 0, too.
fn henyey_greenstein(g: f64, direction: DVec3, draw: &mut Draw) -> DVec3 {
    let s = 2.0 * draw.unit() - 1.0;
    let base = 1.0 + g * s;
    let cosine = (s + g * (s * s + 3.0) / 2.0 + g * g * s + g * g * g * (s * s - 1.0) / 2.0) / (base * base);
    let cosine = cosine.clamp(-1.0, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt();
    let (x, y) = draw.turn();
    let (u, v) = direction.any_orthonormal_pair();
    (u * (x * sine) + v * (y * sine) + direction * cosine).normalize()
}

/// The normal of a leaf that light along `direction` meets, on the lit side: inclinations as they are distributed, even
/// azimuths, accepted in proportion to the area that they show.
fn inclined(cumulated: &[f64; INCLINATIONS], direction: DVec3, draw: &mut Draw) -> DVec3 {
    loop {
        let share = draw.unit() * cumulated[INCLINATIONS - 1];
        let bin = cumulated.partition_point(|&sum| sum <= share).min(INCLINATIONS - 1);
        let up = (bin as f64 + draw.unit()) / INCLINATIONS as f64;
        let level = (1.0 - up * up).sqrt();
        let (x, z) = draw.turn();
        let normal = DVec3::new(level * x, up, level * z);
        let shown = normal.dot(direction);
        if draw.unit() < shown.abs() {
            return if shown > 0.0 { -normal } else { normal };
        }
    }
}
