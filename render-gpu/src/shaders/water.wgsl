// Rays by way of the water, and how much of what comes from there is mirrored. The twin is forest/water.rs of the CPU's renderer.

struct Line {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

const REFRACTIVE_INDEX: f32 = 1.333;
const INTO_FROM_SKY: f32 = 0.9336;
// Of a fragment's triangle: what it tells was met by way of the water.
const BY_WATER: u32 = 0x80000000u;

// Distance at which a ray of the camera comes to water that no ground covers, or NEVER.
fn water_along(direction: vec3<f32>) -> f32 {
    if direction.y >= 0.0 {
        return NEVER;
    }
    let distance = view.water / direction.y;
    return select(distance, NEVER, is_under_ground(direction * distance));
}

// Whether a point of the water lies below the ground.
fn is_under_ground(point: vec3<f32>) -> bool {
    if view.ground != GROUND_HEIGHTS {
        return false;
    }
    let place = (point.xz - view.ground_origin.xz) / view.spacing;
    let last = vec2<f32>(f32(view.columns - 1u), f32(view.rows - 1u));
    let is_over = all(place >= vec2<f32>(0.0)) && all(place <= last);
    return is_over && view.water < view.ground_origin.y + height_at(place);
}

// The ray that comes to the camera along another by way of the water.
fn mirrored(direction: vec3<f32>) -> Line {
    let along = direction.xz * (view.water / direction.y);
    return Line(vec3<f32>(along.x, view.water, along.y), vec3<f32>(direction.x, -direction.y, direction.z));
}

// A fragment met by way of the water, with what share of the sky's light falls on the water: where the fragment has no use for it.
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
