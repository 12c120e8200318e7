// Light of an instance's fields at a point of its model, in the units of the shading.
fn indirect(instance: u32, asked: Asked) -> vec3<f32> {
    let point_model_m = asked.point_model_m;
    let terms = species_terms[instance];
    if terms.species == NONE {
        return terms.constant;
    }
    if (terms.sky_count & UNEVEN) != 0u {
        return under_uneven_sky(terms, asked, 1.0, 1.0);
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
