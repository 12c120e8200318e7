// Light of an instance's fields at a point of its model, in the units of the shading.
fn indirect(instance: u32, point_model_m: vec3<f32>) -> vec3<f32> {
    let lamp = lamps[instance];
    if lamp.species == NONE {
        return lamp.constant;
    }
    if lamp.near_count > 0u {
        let near = near_of(lamp, point_model_m);
        return lamp.constant + flb_sample_near(lamp.species, lamp.first_term, lamp.term_count, lamp.near_count, point_model_m, near);
    }
    let light = flb_sample(lamp.species, lamp.first_term, lamp.term_count, point_model_m);
    return max(lamp.constant + light, vec3<f32>(lamp.least));
}
