// What the stages share: the camera, the daylight, and what a ray met. A picture is squares of 8 x 8 pixels in rows; a
// workgroup serves one sample of a square, so that neighbouring rays run together. Points and directions are of the
// world unless named otherwise; points are counted from the camera, where floats are finest.

struct View {
    // Unit, into the middle of the picture; from there half its width to the right and half its height up.
    forward: vec3<f32>,
    samples: u32,
    right: vec3<f32>,
    sky_rays: u32,
    up: vec3<f32>,
    width: u32,
    // The camera, counted from the middle of the stand: the sum of both.
    eye_high: vec3<f32>,
    height: u32,
    eye_low: vec3<f32>,
    // GROUND_NONE, GROUND_PLANE or GROUND_HEIGHTS.
    ground: u32,
    // Around all plants, counted from the middle of the stand.
    stand_min: vec3<f32>,
    // First word of the heights.
    heights: u32,
    stand_max: vec3<f32>,
    columns: u32,
    // Of a plane, y; of heights, the first point at the lowest height.
    ground_origin: vec3<f32>,
    rows: u32,
    // Around the heights.
    ground_min: vec3<f32>,
    // How far above the ground a ray starts that leaves it.
    ground_lift: f32,
    ground_max: vec3<f32>,
    // First word of the grid over the picture.
    cells: u32,
    // Metres between neighbouring heights, along x and z.
    spacing: vec2<f32>,
    // Height of the water, where there is any: below 0.
    water: f32,
    // First word of the waves, or NONE.
    waves: u32,
    // The part of the picture that is at work, in pixels: where it begins, and its width and height.
    corner: vec2<u32>,
    size: vec2<u32>,
}

struct Daylight {
    towards_sun: vec3<f32>,
    sun_strength: f32,
    ground_color: vec3<f32>,
    white_in_sun: f32,
    // Colours of an even sky as it is drawn.
    horizon: vec3<f32>,
    // Whether the sky is drawn where it is not mirrored.
    has_backdrop: u32,
    zenith: vec3<f32>,
    haze_m: f32,
    // Middle of the stand.
    center: vec3<f32>,
    // Light of the sun itself: 0 or 1.
    direct: f32,
    white_under_sky: vec3<f32>,
    // Light of the fields, and its factor.
    indirect: f32,
    // Factor on the sun's light.
    sun_color: vec3<f32>,
    units: u32,
    water_color: vec3<f32>,
    // SHOW_PICTURE and so on.
    show: u32,
    // Of the sky, for light among neighbours.
    fluence: vec3<f32>,
    // First word of the grid across the sun's rays.
    cells: u32,
    // Whether the sky is drawn from a picture of it.
    has_dome: u32,
    // Variance of the slopes that make the sun's glint on waves; 0 without one.
    ripples: f32,
    unused_2: vec2<u32>,
    // Strengths and exponents of the sun's highlights on leaves, wood and water.
    highlights: vec3<f32>,
    unused_3: u32,
    exponents: vec3<f32>,
    unused_4: u32,
}

// Rows of squares that are at work.
struct Strip {
    // First row of squares.
    top: u32,
    // Squares in a row.
    columns: u32,
    // First workgroup of the dispatch.
    first: u32,
    unused: u32,
}

struct Fragment {
    // Place in the order of the stand's tree; or SKY, or GROUND.
    instance: u32,
    // Place in the order of the trees of models.
    triangle: u32,
    // Of the second and third corner.
    weights: vec2<f32>,
    distance_m: f32,
    // Of the ground: light of the sky as a share of that without plants. For what is met by way of the water, see
    // water.wgsl.
    sky: f32,
}

struct Lit {
    // What is seen but for the light of fields.
    color: vec3<f32>,
    // As in the fragment.
    instance: u32,
    // Share of the fields' light that is seen.
    share: vec3<f32>,
    // Side of a solid that is seen, in the model's frame, as 16 bits a component; 0 of a leaf.
    facing_xy: u32,
    point_model_m: vec3<f32>,
    facing_z: u32,
}

// What an invocation is to do.
struct Task {
    pixel: vec2<u32>,
    sample: u32,
    // Index of the ray in its strip.
    ray: u32,
    is_inside: bool,
}

const WORKGROUP: u32 = 64u;
const EDGE: u32 = 8u;
const SKY: u32 = 0xffffffffu;
const GROUND: u32 = 0xfffffffeu;
const GROUND_NONE: u32 = 0u;
const GROUND_PLANE: u32 = 1u;
const GROUND_HEIGHTS: u32 = 2u;
const UNITS_WHITE: u32 = 0u;
const SHOW_PICTURE: u32 = 0u;
const SHOW_INSTANCES: u32 = 1u;
const SHOW_NORMALS: u32 = 2u;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> daylight: Daylight;
@group(0) @binding(2) var<uniform> strip: Strip;

@group(2) @binding(0) var<storage, read_write> fragments: array<Fragment>;
@group(2) @binding(1) var<storage, read_write> lit: array<Lit>;

fn task_of(workgroup: u32, local: u32) -> Task {
    let number = strip.first + workgroup;
    let square = number / view.samples;
    let corner = vec2<u32>(square % strip.columns, strip.top + square / strip.columns) * EDGE;
    let pixel = corner + vec2<u32>(local % EDGE, local / EDGE);
    let is_inside = pixel.x < view.size.x && pixel.y < view.size.y;
    return Task(view.corner + pixel, number % view.samples, number * WORKGROUP + local, is_inside);
}

// Unit direction of a ray from the camera.
fn direction_of(task: Task) -> vec3<f32> {
    var offset = vec2<f32>(0.5);
    if view.samples > 1u {
        offset = sequence(task.pixel.x ^ hash(task.pixel.y), task.sample);
    }
    let at = (vec2<f32>(task.pixel) + offset) / vec2<f32>(f32(view.width), f32(view.height)) * 2.0 - vec2<f32>(1.0);
    return normalize(view.forward + view.right * at.x - view.up * at.y);
}

fn hash(value: u32) -> u32 {
    var v = value + 0x9e3779b9u;
    v = (v ^ (v >> 16u)) * 0x21f0aaadu;
    v = (v ^ (v >> 15u)) * 0x735a2d97u;
    return v ^ (v >> 15u);
}

// Points that fill the unit square evenly: the sequence of the CPU's renderer.
fn sequence(seed: u32, point: u32) -> vec2<f32> {
    let turn = hash(seed);
    let fractions = vec2<u32>(turn, hash(turn)) + vec2<u32>(point) * vec2<u32>(3242174889u, 2447445414u);
    return vec2<f32>(fractions >> vec2<u32>(8u)) / 16777216.0;
}
