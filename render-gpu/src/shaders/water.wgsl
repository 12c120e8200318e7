// Rays by way of the water, and how much of what comes from there is mirrored. The twin is forest/water.rs of the CPU's
// renderer.

struct Line {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

const PI: f32 = 3.14159265;
const TAU: f32 = 6.2831853;
// Waves of a field.
const WAVE_COUNT: u32 = 96u;
const REFRACTIVE_INDEX: f32 = 1.333;
const INTO_FROM_SKY: f32 = 0.9336;
const NO_GLINT: f32 = 16.0;
// Of a fragment's triangle: what it tells was met by way of the water.
const BY_WATER: u32 = 0x80000000u;

// Distance at which a ray of the camera comes to the water's level, or NEVER. Ground that covers it is met before.
fn water_along(direction: vec3<f32>) -> f32 {
    return select(NEVER, view.water / direction.y, direction.y < 0.0);
}

// A point of the water that a ray of the camera comes to.
struct Facet {
    // Upward, unit.
    normal: vec3<f32>,
    // Share of light that is mirrored.
    share: f32,
    // The ray that comes to the camera by way of it.
    back: Line,
}

// The facet that a ray of the camera comes to.
fn facet_along(direction: vec3<f32>) -> Facet {
    let along = direction.xz * (view.water / direction.y);
    let origin = vec3<f32>(along.x, view.water, along.y);
    if view.waves == NONE {
        let back = vec3<f32>(direction.x, -direction.y, direction.z);
        return Facet(vec3<f32>(0.0, 1.0, 0.0), reflectance(back.y), Line(origin, back));
    }
    let slope = slope_at(along);
    let normal = normalize(vec3<f32>(-slope.x, 1.0, -slope.y));
    let cosine = max(-dot(direction, normal), 0.0);
    let back = direction + normal * (2.0 * cosine);
    return Facet(normal, reflectance(cosine), Line(origin, vec3<f32>(back.x, abs(back.y), back.z)));
}

// Slope of the waves, along x and z, at a point counted from the camera. A wave has five words: its wave vector, in
// turns per metre; its phase where the camera stands, in turns; its largest slope, along x and z.
fn slope_at(point: vec2<f32>) -> vec2<f32> {
    var slope = vec2<f32>(0.0);
    for (var wave = 0u; wave < WAVE_COUNT; wave++) {
        let word = view.waves + 5u * wave;
        let number = vec2<f32>(bitcast<f32>(words[word]), bitcast<f32>(words[word + 1u]));
        let turns = dot(number, point) + bitcast<f32>(words[word + 2u]);
        let largest = vec2<f32>(bitcast<f32>(words[word + 3u]), bitcast<f32>(words[word + 4u]));
        slope += largest * cos(TAU * (fract(turns + 0.5) - 0.5));
    }
    return slope;
}

// Glint of the sun in ripples with slopes of this variance.
fn glint(normal: vec3<f32>, looking: vec3<f32>, towards_sun: vec3<f32>, variance: f32) -> f32 {
    let between = towards_sun - looking;
    let size = length(between);
    let slant = dot(between, normal) / size;
    let of_sun = dot(between, towards_sun) / size;
    if size == 0.0 || slant <= 0.0 || of_sun <= 0.0 || towards_sun.y <= 0.0 {
        return 0.0;
    }
    let squared = slant * slant;
    let steep = (1.0 - squared) / squared / variance;
    if steep > NO_GLINT {
        return 0.0;
    }
    let density = exp(-steep) / (PI * variance);
    let cosine = max(-dot(looking, normal), sqrt(0.5 * variance));
    return PI * reflectance(of_sun) * density / (4.0 * cosine * squared * squared);
}

// A fragment met by way of the water, with what share of the sky's light falls on the water: where the fragment has no
// use for it.
fn by_water(met: Fragment, sky: f32) -> Fragment {
    var marked = met;
    marked.triangle |= BY_WATER;
    if met.instance == GROUND {
        marked.weights.x = sky;
    } else {
        marked.sky = sky;
    }
    return marked;
}

fn sky_on_water(marked: Fragment) -> f32 {
    return select(marked.sky, marked.weights.x, marked.instance == GROUND);
}

// Share of unpolarised light that water mirrors, by the cosine of its angle to the vertical.
fn reflectance(cosine_of_light: f32) -> f32 {
    let cosine = clamp(cosine_of_light, 0.0, 1.0);
    let inside = sqrt(REFRACTIVE_INDEX * REFRACTIVE_INDEX - 1.0 + cosine * cosine);
    let across = (cosine - inside) / (cosine + inside);
    let within = REFRACTIVE_INDEX * REFRACTIVE_INDEX * cosine;
    let along = (within - inside) / (within + inside);
    return 0.5 * (across * across + along * along);
}
