//! The members of the WGSL structs, as Rust writes them.

/// A member's name and its words.
pub(crate) type Member = (&'static str, usize);

pub(crate) const VIEW: [Member; 25] = [
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
    ("cells", 1),
    ("spacing", 2),
    ("water", 1),
    ("waves", 1),
    ("corner", 2),
    ("size", 2),
];
pub(crate) const DAYLIGHT: [Member; 25] = [
    ("towards_sun", 3),
    ("sun_strength", 1),
    ("ground_color", 3),
    ("white_in_sun", 1),
    ("horizon", 3),
    ("has_backdrop", 1),
    ("zenith", 3),
    ("haze_m", 1),
    ("center", 3),
    ("direct", 1),
    ("white_under_sky", 3),
    ("indirect", 1),
    ("sun_color", 3),
    ("units", 1),
    ("water_color", 3),
    ("show", 1),
    ("fluence", 3),
    ("cells", 1),
    ("has_dome", 1),
    ("ripples", 1),
    ("unused_2", 2),
    // Of leaves, wood and water.
    ("highlights", 3),
    ("unused_3", 1),
    ("exponents", 3),
    ("unused_4", 1),
];
pub(crate) const STRIP: [Member; 4] = [("top", 1), ("columns", 1), ("first", 1), ("unused", 1)];
pub(crate) const FRAGMENT: [Member; 5] =
    [("instance", 1), ("triangle", 1), ("weights", 2), ("distance_m", 1), ("sky", 1)];
pub(crate) const LIT: [Member; 6] =
    [("color", 3), ("instance", 1), ("share", 3), ("facing_xy", 1), ("point_model_m", 3), ("facing_z", 1)];
pub(crate) const BOX: [Member; 4] = [("min", 3), ("first", 1), ("max", 3), ("count", 1)];
pub(crate) const MODEL: [Member; 4] = [("min", 3), ("root", 1), ("max", 3), ("lift", 1)];
pub(crate) const TRIANGLE: [Member; 5] = [("a", 1), ("b", 1), ("c", 1), ("number", 1), ("material", 1)];
pub(crate) const VERTEX: [Member; 4] = [("point", 3), ("u", 1), ("normal", 3), ("v", 1)];
pub(crate) const INSTANCE: [Member; 9] = [
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
pub(crate) const MATERIAL: [Member; 16] = [
    ("tint", 3),
    ("kind", 1),
    ("unit", 3),
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
    ("solid_offset_m", 1),
    ("cut_v", 3),
    ("colors", 1),
];
pub(crate) const SPECIES_TERMS: [Member; 8] = [
    ("constant", 3),
    ("species", 1),
    ("towards_sun", 3),
    ("first_term", 1),
    ("term_count", 1),
    ("near_count", 1),
    ("least", 1),
    ("sky_count", 1),
];
pub(crate) const VOLUME_BLEND: [Member; 5] = [("x", 4), ("y", 4), ("z", 4), ("volumes", 4), ("weights", 4)];
