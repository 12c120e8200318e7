// What every ray of the camera meets first, by way of the water too: plants, ground with the sky that it sees, or
// nothing. The twin is forest/fragments.rs of the CPU's renderer.

// As a share of the sky's light: plants that hide the sky from the ground.
const LEAVES_BEFORE_SKY: f32 = 0.25;

@compute @workgroup_size(WORKGROUP)
fn trace(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let task = task_of(workgroup.x, local);
    if !task.is_inside {
        return;
    }
    let seed = hash(task.pixel.x ^ hash(task.pixel.y ^ hash(task.sample)));
    var line = Line(vec3<f32>(0.0), direction_of(task));
    var met = nearest_in_view(task.pixel, line.direction);
    var ground = ground_along(line.origin, line.direction);
    let is_by_water = HAS_WATER && water_along(line.direction) < min(met.distance_m, ground);
    var sky_on_water = 1.0;
    if is_by_water {
        line = facet_along(line.direction).back;
        met = nearest(line.origin, line.direction);
        ground = ground_along(line.origin, line.direction);
        sky_on_water = open_sky(line.origin, vec3<f32>(0.0, 1.0, 0.0), seed);
    }
    if ground < NEVER && met.distance_m > ground {
        let point = line.origin + line.direction * ground;
        let origin = point + vec3<f32>(0.0, view.ground_lift, 0.0);
        met = Fragment(GROUND, 0u, vec2<f32>(0.0), ground, open_sky(origin, ground_normal(point), seed));
    }
    if is_by_water {
        met = by_water(met, sky_on_water);
    }
    fragments[task.ray] = met;
}

fn open_sky(origin: vec3<f32>, normal: vec3<f32>, seed: u32) -> f32 {
    if view.sky_rays == 0u {
        return 1.0;
    }
    var open = 0u;
    for (var ray = 0u; ray < view.sky_rays; ray++) {
        if !is_hidden(origin, around(normal, sequence(seed, ray)), NONE) {
            open++;
        }
    }
    let share = f32(open) / f32(view.sky_rays);
    return share + (1.0 - share) * LEAVES_BEFORE_SKY;
}

// A unit vector on the side of a normal, spread by its cosine.
fn around(normal: vec3<f32>, at: vec2<f32>) -> vec3<f32> {
    let y = 2.0 * at.x - 1.0;
    let level = sqrt(max(1.0 - y * y, 0.0));
    let turned = normal + vec3<f32>(level * cos(TAU * at.y), y, level * sin(TAU * at.y));
    return unit_or(turned, normal);
}

fn unit_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    return select(other, v / size, size > 0.0);
}
