// Light of an instance's fields at a point of its model, in the units of the shading.
fn indirect(instance: u32, asked: Asked) -> vec3<f32> {
    let terms = species_terms[instance];
    if terms.species == NONE {
        return terms.constant;
    }
    if (terms.sky_count & UNEVEN) != 0u {
        return under_uneven_sky(terms, asked, 1.0, 1.0);
    }
    return bounded(terms, terms.constant + of_terms_from(terms, 0u, asked.point_model_m));
}
