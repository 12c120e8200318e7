// Adds the light of fields: all that this renderer knows of it is `indirect`.

struct Lamp {
    // Light everywhere in its model.
    constant: vec3<f32>,
    // Number among the species with light, or NONE.
    species: u32,
    // Unit, of the model's frame.
    towards_sun: vec3<f32>,
    first_term: u32,
    term_count: u32,
    // Terms at the end that are of the near beam.
    near_count: u32,
    // Light is never less.
    least: f32,
    unused: u32,
}

// Places of a pixel from which the near beam around its points is estimated: each of its rays has an even share.
const OFFSETS: u32 = 4u;

const NONE: u32 = 0xffffffffu;

// In the order of the stand's tree.
@group(1) @binding(0) var<storage, read> lamps: array<Lamp>;

// Light of an instance's fields at a point of its model, in the units of the shading.
fn indirect(instance: u32, point_model_m: vec3<f32>) -> vec3<f32> {
    let lamp = lamps[instance];
    if lamp.species == NONE {
        return lamp.constant;
    }
    if lamp.near_count > 0u {
        let bits = bitcast<vec3<u32>>(point_model_m);
        let seed = hash(hash(hash(bits.x) ^ bits.y) ^ bits.z);
        let offsets = (OFFSETS + view.samples - 1u) / view.samples;
        let near = flb_near(lamp.species, point_model_m, lamp.towards_sun, offsets, seed);
        return flb_sample_near(lamp.species, lamp.first_term, lamp.term_count, lamp.near_count, point_model_m, near);
    }
    let light = flb_sample(lamp.species, lamp.first_term, lamp.term_count, point_model_m);
    return max(light, vec3<f32>(lamp.least));
}

@compute @workgroup_size(WORKGROUP)
fn light(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let task = task_of(workgroup.x, local);
    if !task.is_inside {
        return;
    }
    let seen = lit[task.ray];
    if seen.instance < GROUND && any(seen.share != vec3<f32>(0.0)) {
        lit[task.ray].color = seen.color + seen.share * indirect(seen.instance, seen.point_model_m);
    }
}
