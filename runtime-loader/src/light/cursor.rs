//! The light of one plant at points that lie near one another.

use flb_format::beam::MAX_MEANS;
use flb_format::blocks::{CodedBase, Cursor, EDGE, TEXELS};

use super::instance::InstanceLight;
use super::sky::SkyCursor;
use super::volume::texel_at;
use crate::scene_light::Modulations;

/// Asks one plant's light as [`InstanceLight::at`] does, with a memory of the blocks last read ([`Cursor`]): of three
/// bands 64 KiB for a blend of bases, 256 KiB at most where the near beam has bases of its own or neighbours are
/// counted.
///
/// Where several points lie in each block, as the pixels of a near plant do, a point costs about as much as one of
/// uncoded fields, and less the more bases there are; where points lie far apart it costs several times that of
/// [`InstanceLight::at`] (`cargo bench -p flb-runtime --bench blend`). Whatever was asked before, a point has the same
/// light, and that of [`InstanceLight::at`] but for the rounding of sums in another order. Fields that are not coded as
/// `classed` or `haar`, and those that are expanded, are asked as [`InstanceLight::at`] asks them.
pub struct LightCursor<'a> {
    light: &'a InstanceLight<'a>,
    /// `None` where there is nothing to be kept.
    kept: Option<CachedSums<'a>>,
    /// Of an uneven sky.
    sky: Option<SkyCursor<'a>>,
}

impl InstanceLight<'_> {
    /// Samples points that lie near one another for less; one for each thread.
    pub fn cursor(&self) -> LightCursor<'_> {
        LightCursor::new(self)
    }
}

/// Sums over bases, each added up once for a block.
struct CachedSums<'a> {
    /// Of the blend, of each basis of the near beam, of the sky: those that there are, in this order.
    cursor: Cursor<'a>,
    has_blend: bool,
    near_count: usize,
    /// Whether the sky is a sum of its own: neighbours leave another share of it.
    has_sky: bool,
    /// Factors of what is added to each band: with the sun's share, and with the sky's.
    constants: [f32; 2],
    /// `[sum][band]`
    found: Vec<f32>,
}

type Sum<'a> = Vec<(&'a CodedBase, f32)>;

/// What is added up. The factors have the strengths of the sun and of the sky in them.
#[derive(Default)]
struct Parts<'a> {
    sun: Sum<'a>,
    near: Sum<'a>,
    sky: Sum<'a>,
    constants: [f32; 2],
}

impl<'a> LightCursor<'a> {
    pub(super) fn new(light: &'a InstanceLight<'a>) -> LightCursor<'a> {
        let kept = Parts::of(light).and_then(|parts| CachedSums::new(parts, light));
        let sky = light.uneven().filter(|_| kept.is_some()).and_then(|sky| sky.cursor(light.species));
        LightCursor { light, kept, sky }
    }

    /// Light per band at a point of the model at rest, as [`InstanceLight::at`] has it.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at(&mut self, point_m: [f32; 3], out: &mut [f32]) {
        self.at_facing(point_m, None, out);
    }

    /// Light per band at a point before a solid that faces some way, as [`InstanceLight::at_facing`] has it.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at_facing(&mut self, point_m: [f32; 3], facing: Option<[f32; 3]>, out: &mut [f32]) {
        let light = self.light;
        let Some(kept) = &mut self.kept else { return light.at_facing(point_m, facing, out) };
        let out = &mut out[..light.bands()];
        let near = if kept.near_count > 0 { light.near(point_m) } else { Default::default() };
        let modulation = light.modulation(point_m);
        kept.cursor.sample(light.species.grid().lattice_from_model(point_m.map(f64::from)), &mut kept.found);
        kept.add_up(light, &kept.found, near, &modulation, out);
        light.bound(out);
        self.sky(point_m, facing, &modulation, out);
    }

    /// Light per band at the centres of the texels of a block that lies in the lattice, with these means of the near
    /// beam, `[z][y][x][band]`. It may be below 0.
    pub(super) fn block(&mut self, first: [usize; 3], near: &[[f32; MAX_MEANS]; TEXELS], out: &mut [f32]) {
        let (light, bands) = (self.light, self.light.bands());
        let mut all = Vec::new();
        if let Some(kept) = &mut self.kept {
            all.resize(TEXELS * kept.found.len(), 0.0);
            kept.cursor.block(first.map(|texel| (texel / EDGE) as u32), &mut all);
        }
        for (number, out) in out.chunks_exact_mut(bands).enumerate() {
            let center = texel_at(first, number).map(|texel| texel as f64 + 0.5);
            let point_m = light.species.grid().model_from_lattice(center).map(|x| x as f32);
            let Some(kept) = &self.kept else {
                light.at(point_m, out);
                continue;
            };
            let modulation = light.modulation(point_m);
            kept.add_up(light, &all[number * kept.found.len()..], near[number], &modulation, out);
            self.sky(point_m, None, &modulation, out);
        }
    }

    /// Colours the light of the sun, and adds that of an uneven sky and of neighbours.
    fn sky(
        &mut self,
        point_m: [f32; 3],
        facing: Option<[f32; 3]>,
        modulation: &Modulations,
        out: &mut [f32],
    ) {
        let light = self.light;
        light.color(out);
        let scale = modulation.sky.scale;
        match (&mut self.sky, light.uneven()) {
            (Some(cursor), _) => cursor.add(point_m, facing, scale, out),
            (None, Some(of_sky)) => of_sky.add(light.species, point_m, facing, scale, out),
            (None, None) => {}
        }
        light.add(modulation, out);
    }
}

impl<'a> CachedSums<'a> {
    fn new(mut parts: Parts<'a>, light: &InstanceLight) -> Option<CachedSums<'a>> {
        if !light.is_among() {
            parts.sun.append(&mut parts.sky);
        }
        let Parts { sun, near, sky, constants } = parts;
        let (has_blend, near_count, has_sky) = (!sun.is_empty(), near.len(), !sky.is_empty());
        let near = near.into_iter().map(|one| vec![one]);
        let sums: Vec<Sum> =
            has_blend.then_some(sun).into_iter().chain(near).chain(has_sky.then_some(sky)).collect();
        if sums.is_empty() {
            return None;
        }
        let found = vec![0.0; sums.len() * light.bands()];
        Some(CachedSums { cursor: Cursor::of_sums(sums), has_blend, near_count, has_sky, constants, found })
    }

    /// Adds up sums that were found at a point: light of the sun, and of a sky that is even.
    fn add_up(
        &self,
        light: &InstanceLight,
        found: &[f32],
        near: [f32; MAX_MEANS],
        modulation: &Modulations,
        out: &mut [f32],
    ) {
        let [sun, sky] = [modulation.sun.scale, modulation.sky.scale];
        let constants = [sun * self.constants[0], sky * self.constants[1]];
        light.species.fill(&light.terms, constants, out);
        let factors = self
            .has_blend
            .then_some(sun)
            .into_iter()
            .chain(near[..self.near_count].iter().map(|near| sun * near))
            .chain(self.has_sky.then_some(sky));
        for (sum, factor) in found.chunks_exact(out.len()).zip(factors) {
            out.iter_mut().zip(sum).for_each(|(out, light)| *out += factor * light);
        }
    }
}

impl<'a> Parts<'a> {
    /// `None` where a basis is not coded near geometry, and where the fields are expanded.
    fn of(light: &'a InstanceLight<'a>) -> Option<Parts<'a>> {
        if light.is_expanded() {
            return None;
        }
        let (species, terms) = (light.species, &light.terms);
        let coded = |place: u16| species.base(usize::from(place));
        let scaled = |scale: f32| move |(place, factor): (u16, f32)| Some((coded(place)?, scale * factor));
        let [of_sun, of_sky] = [terms.factors([1.0, 0.0]), terms.factors([0.0, 1.0])];
        let mut sun: Sum = terms.sun().map(scaled(of_sun.sun)).collect::<Option<_>>()?;
        let mut sky = Sum::new();
        if let Some(place) = terms.sky() {
            let of_place = |factor: f32| (factor != 0.0).then_some((place, factor));
            sun.extend(of_place(of_sun.sky).into_iter().map(scaled(1.0)).collect::<Option<Sum>>()?);
            sky = of_place(of_sky.sky).into_iter().map(scaled(1.0)).collect::<Option<_>>()?;
        }
        let near: Option<Sum> =
            terms.near_bases().0.map(|place| Some((coded(place)?, of_sun.near))).collect();
        Some(Parts { sun, near: near?, sky, constants: [of_sun.constants[0], of_sky.constants[1]] })
    }
}
