// Rays by way of the water, and how much of what comes from there is mirrored. The twin is forest/water.rs of the CPU's
// renderer.

struct Line {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

const REFRACTIVE_INDEX: f32 = 1.333;
const INTO_FROM_SKY: f32 = 0.9336;
// Of a fragment's triangle: what it tells was met by way of the water.
const BY_WATER: u32 = 0x80000000u;

// Distance at which a ray of the camera comes to the water's level, or NEVER. Ground that covers it is met before.
fn water_along(direction: vec3<f32>) -> f32 {
    return select(NEVER, view.water / direction.y, direction.y < 0.0);
}

// The ray that comes to the camera along another by way of the water.
fn mirrored(direction: vec3<f32>) -> Line {
    let along = direction.xz * (view.water / direction.y);
    return Line(vec3<f32>(along.x, view.water, along.y), vec3<f32>(direction.x, -direction.y, direction.z));
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
