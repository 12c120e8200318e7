// Light of an instance's fields at a point of its model, in the units of the shading.
fn indirect(instance: u32, point_model_m: vec3<f32>) -> vec3<f32> {
    let terms = species_terms[instance];
    if terms.species == NONE {
        return terms.constant;
    }
    if terms.near_count > 0u {
        let near = near_of(terms, point_model_m);
        let near_from = terms.first_term + terms.term_count - terms.near_count;
        let place = flb_locate(terms.species, point_model_m);
        let light = flb_light_near(
            terms.species,
            terms.first_term,
            terms.term_count,
            place.texel,
            place.part,
            near_from,
            near,
        );
        return bounded(terms, terms.constant + light);
    }
    let light = flb_sample(terms.species, terms.first_term, terms.term_count, point_model_m);
    return bounded(terms, terms.constant + light);
}
