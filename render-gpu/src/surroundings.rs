//! Ground and water as a view's uniform tells them, and a daylight as its uniform does.

use std::f64::consts::TAU;

use flb_render::forest::export::{SKY, glint_variance};
use flb_render::forest::{Forest, Land, Scenery, View, Water};
use flb_render::highlight::Highlights;
use flb_render::shading::Units;
use flb_render::{Indirect, Lighting, Look};
use flb_scene::sky::Sky;
use flb_scene::waves::WaveField;

use crate::layout::Words;
use crate::show::Show;

/// The forest's ground, with its heights as words among the others; and its water.
pub(crate) struct GroundAndWater {
    pub water: Option<Water>,
    field: Option<WaveField>,
    color: [f32; 3],
    shape: Shape,
}

enum Shape {
    None,
    Plane {
        height_m: f64,
    },
    Heights {
        first: u32,
        size: [u32; 2],
        origin_m: [f64; 3],
        spacing_m: [f64; 2],
        lift_m: f64,
        box_m: [[f64; 3]; 2],
    },
}

impl GroundAndWater {
    /// Heights are added to `words`, counted from the lowest, where floats are finest.
    pub(crate) fn new(forest: &Forest<'_>, words: &mut Vec<u32>) -> GroundAndWater {
        let (water, field) = (forest.water().copied(), forest.wave_field().cloned());
        let (Some(ground), Some((lift_m, box_m))) = (forest.ground(), forest.ground_reach()) else {
            return GroundAndWater { water, field, color: [0.0; 3], shape: Shape::None };
        };
        let shape = match &ground.land {
            Land::Plane { height_m } => Shape::Plane { height_m: *height_m },
            Land::Heights(heights) => {
                let first = words.len() as u32;
                let lowest = heights.height_m.iter().copied().fold(f32::INFINITY, f32::min);
                words.extend(heights.height_m.iter().map(|height| (height - lowest).to_bits()));
                Shape::Heights {
                    first,
                    size: [heights.columns, heights.rows],
                    origin_m: [heights.origin_m[0], f64::from(lowest), heights.origin_m[1]],
                    spacing_m: heights.spacing_m(),
                    lift_m,
                    box_m,
                }
            }
        };
        GroundAndWater { water, field, color: ground.color, shape }
    }

    /// `GROUND_NONE`, `GROUND_PLANE` or `GROUND_HEIGHTS`.
    pub(crate) fn kind(&self) -> u32 {
        match self.shape {
            Shape::None => 0,
            Shape::Plane { .. } => 1,
            Shape::Heights { .. } => 2,
        }
    }

    /// First word of the heights, columns, rows.
    pub(crate) fn heights(&self) -> [u32; 3] {
        match self.shape {
            Shape::Heights { first, size: [columns, rows], .. } => [first, columns, rows],
            _ => [0, 2, 2],
        }
    }

    /// Seen from a camera: where it begins, the box around it, how far above it rays start, its spacing.
    pub(crate) fn seen_from(&self, camera_m: [f64; 3]) -> ([f64; 3], [[f64; 3]; 2], f64, [f64; 2]) {
        let offset = |point: [f64; 3]| std::array::from_fn(|axis| point[axis] - camera_m[axis]);
        match &self.shape {
            Shape::None => ([0.0; 3], [[0.0; 3]; 2], 0.0, [1.0; 2]),
            Shape::Plane { height_m } => ([0.0, height_m - camera_m[1], 0.0], [[0.0; 3]; 2], 0.0, [1.0; 2]),
            Shape::Heights { origin_m, spacing_m, lift_m, box_m, .. } => {
                (offset(*origin_m), box_m.map(offset), *lift_m, *spacing_m)
            }
        }
    }

    /// Height of the water, seen from a camera above it: below 0.
    pub(crate) fn water_from(&self, camera_m: [f64; 3]) -> f64 {
        self.water.map_or(0.0, |water| water.height_m - camera_m[1])
    }

    /// The waves of a view, as `water.wgsl` reads them: their phases are those where the camera stands.
    pub(crate) fn wave_words(&self, view: &View) -> Vec<u32> {
        let [x, _, z] = view.eye.position_m;
        let mut words = Words::default();
        for wave in self.field.iter().flat_map(|field| &field.waves) {
            words
                .rounded(wave.wave_vector.map(|radians| radians / TAU))
                .rounded([wave.turns_at([x, z], view.time_s)])
                .rounded(wave.slope);
        }
        words.0
    }

    /// Variance of the slopes that make the sun's glint, where there is one.
    fn ripples(&self, units: Units) -> f32 {
        let field = self.field.as_ref().filter(|_| !units.has_highlights());
        field.map_or(0.0, |field| glint_variance(field) as f32)
    }

    /// The words of a `Daylight` of the shaders.
    pub(crate) fn daylight_words(
        &self,
        (lighting, look): (&Lighting, &Look),
        scenery: &Scenery,
        camera_m: [f64; 3],
        units: Units,
        show: Show,
        cells: u32,
    ) -> Vec<u32> {
        let is_sky_drawn = look.has_sky && look.indirect != Indirect::Only;
        let sky = SKY.map(|color| color.map(|v| if is_sky_drawn { v * scenery.sky_strength } else { 0.0 }));
        let direct = if look.indirect == Indirect::Only { 0.0 } else { 1.0 };
        let indirect = if look.indirect == Indirect::Off { 0.0 } else { units.indirect_scale(look) };
        let center = std::array::from_fn::<_, 3, _>(|axis| scenery.center_m[axis] - camera_m[axis]);
        let Highlights { leaf, wood, water } = units.highlights(look);
        let highlights = [leaf, wood, water];
        let mut words = Words::default();
        words
            .rounded(scenery.towards_sun)
            .float(scenery.sun_strength)
            .floats(self.color)
            .float(scenery.white_in_sun)
            .floats(sky[0])
            .whole(u32::from(look.has_backdrop))
            .floats(sky[1])
            .rounded([scenery.haze_m])
            .rounded(center)
            .float(direct)
            .floats(scenery.white_under_sky)
            .float(indirect)
            .floats(lighting.sun_color)
            .whole(units as u32)
            .floats(self.water.map_or([0.0; 3], |water| water.color))
            .whole(show as u32)
            .floats(lighting.dome.as_ref().map_or([lighting.daylight.sky; 3], Sky::fluence))
            .whole(cells)
            .whole(u32::from(is_sky_drawn && (lighting.dome.is_some() || lighting.backdrop.is_some())))
            .float(self.ripples(units))
            .whole(0)
            .whole(0)
            .floats(highlights.map(|one| one.strength))
            .whole(0)
            .floats(highlights.map(|one| one.exponent))
            .whole(0);
        words.0
    }
}
