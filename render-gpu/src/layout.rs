//! Rust values to the words of the WGSL structs. Each struct has the list of its members and their words, which a test holds against what
//! naga reads from the shaders.

/// A member's name and its words.
#[cfg_attr(not(test), allow(dead_code))]
pub type Member = (&'static str, usize);

/// Invocations of a workgroup, and pixels of a square; `WORKGROUP`.
pub const WORKGROUP: u32 = 64;
/// Pixels along the edge of a square; `EDGE`.
pub const EDGE: u32 = 8;
/// Most species; `MODELS`.
pub const MOST_MODELS: usize = 256;
/// Most materials of all species; `MATERIALS`.
pub const MOST_MATERIALS: usize = 512;
/// Boxes that a ray can have waiting; `STACK`.
pub const STACK: u32 = 96;
/// What a fragment of the sky has as its instance; `SKY`.
pub const SKY: u32 = u32::MAX;
/// Of the ground; `GROUND`.
pub const GROUND: u32 = u32::MAX - 1;
/// No word; `NONE`.
pub const NONE: u32 = u32::MAX;
/// No texel at all; `NOTHING`.
pub const NOTHING: u32 = u32::MAX - 1;
/// Of a triangle's material: alpha has to be looked up; `TRIANGLE_CUT`.
pub const TRIANGLE_CUT: u32 = 1 << 31;
/// `CLASS_LEAF`
pub const CLASS_LEAF: u32 = 1;

/// Bytes between two uniforms of one buffer: the alignment that WebGPU asks for.
pub const UNIFORM_STRIDE: u64 = 256;

#[cfg_attr(not(test), allow(dead_code))]
pub const VIEW: [Member; 22] = [
    ("forward", 3),
    ("samples", 1),
    ("right", 3),
    ("sky_rays", 1),
    ("up", 3),
    ("width", 1),
    ("eye_high", 3),
    ("height", 1),
    ("eye_low", 3),
    ("ground", 1),
    ("stand_min", 3),
    ("heights", 1),
    ("stand_max", 3),
    ("columns", 1),
    ("ground_origin", 3),
    ("rows", 1),
    ("ground_min", 3),
    ("ground_lift", 1),
    ("ground_max", 3),
    ("unused", 1),
    ("spacing", 2),
    ("unused_2", 2),
];
#[cfg_attr(not(test), allow(dead_code))]
pub const DAYLIGHT: [Member; 14] = [
    ("towards_sun", 3),
    ("sun_strength", 1),
    ("ground_color", 3),
    ("white_in_sun", 1),
    ("horizon", 3),
    ("white_under_sky", 1),
    ("zenith", 3),
    ("specular", 1),
    ("center", 3),
    ("haze_m", 1),
    ("direct", 1),
    ("indirect", 1),
    ("is_physical", 1),
    ("show", 1),
];
#[cfg_attr(not(test), allow(dead_code))]
pub const STRIP: [Member; 4] = [("top", 1), ("columns", 1), ("first", 1), ("unused", 1)];
#[cfg_attr(not(test), allow(dead_code))]
pub const FRAGMENT: [Member; 5] =
    [("instance", 1), ("triangle", 1), ("weights", 2), ("distance_m", 1), ("sky", 1)];
#[cfg_attr(not(test), allow(dead_code))]
pub const LIT: [Member; 6] =
    [("color", 3), ("instance", 1), ("share", 3), ("unused", 1), ("point_model_m", 3), ("unused_2", 1)];
#[cfg_attr(not(test), allow(dead_code))]
pub const BOX: [Member; 4] = [("min", 3), ("first", 1), ("max", 3), ("count", 1)];
#[cfg_attr(not(test), allow(dead_code))]
pub const MODEL: [Member; 4] = [("min", 3), ("root", 1), ("max", 3), ("lift", 1)];
#[cfg_attr(not(test), allow(dead_code))]
pub const TRIANGLE: [Member; 5] = [("a", 1), ("b", 1), ("c", 1), ("number", 1), ("material", 1)];
#[cfg_attr(not(test), allow(dead_code))]
pub const VERTEX: [Member; 4] = [("point", 3), ("u", 1), ("normal", 3), ("v", 1)];
#[cfg_attr(not(test), allow(dead_code))]
pub const INSTANCE: [Member; 9] = [
    ("x", 4),
    ("y", 4),
    ("z", 4),
    ("place_low", 3),
    ("scale", 1),
    ("species", 1),
    ("number", 1),
    ("unused", 1),
    ("unused_2", 1),
];
#[cfg_attr(not(test), allow(dead_code))]
pub const MATERIAL: [Member; 16] = [
    ("tint", 3),
    ("kind", 1),
    ("mean", 3),
    ("image", 1),
    ("reflectance", 3),
    ("image_size", 1),
    ("transmittance", 3),
    ("cut", 1),
    ("image_u", 3),
    ("cut_size", 1),
    ("image_v", 3),
    ("wrap", 1),
    ("cut_u", 3),
    ("unused", 1),
    ("cut_v", 3),
    ("unused_2", 1),
];
#[cfg_attr(not(test), allow(dead_code))]
pub const LAMP: [Member; 8] = [
    ("constant", 3),
    ("species", 1),
    ("towards_sun", 3),
    ("first_term", 1),
    ("term_count", 1),
    ("near_count", 1),
    ("least", 1),
    ("unused", 1),
];
/// Words of a `Lamp`.
pub const LAMP_WORDS: usize = 12;

/// Bytes of a `Fragment`.
pub const FRAGMENT_BYTES: u64 = 24;
/// Bytes of a `Lit`.
pub const LIT_BYTES: u64 = 48;

/// Words in the order of a struct's members.
#[derive(Default)]
pub struct Words(pub Vec<u32>);

impl Words {
    pub fn whole(&mut self, word: u32) -> &mut Words {
        self.0.push(word);
        self
    }

    pub fn float(&mut self, value: f32) -> &mut Words {
        self.whole(value.to_bits())
    }

    pub fn floats(&mut self, values: impl IntoIterator<Item = f32>) -> &mut Words {
        self.0.extend(values.into_iter().map(f32::to_bits));
        self
    }

    /// f64 rounded.
    pub fn rounded(&mut self, values: impl IntoIterator<Item = f64>) -> &mut Words {
        self.floats(values.into_iter().map(|value| value as f32))
    }
}

/// A coordinate as two floats whose sum it is.
pub fn split(value: f64) -> [f32; 2] {
    let high = value as f32;
    [high, (value - f64::from(high)) as f32]
}
