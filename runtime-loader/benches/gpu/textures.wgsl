// Uncoded fields: 3D textures, filtered by hardware.

@group(1) @binding(0) var volume0: texture_3d<f32>;
@group(1) @binding(1) var volume1: texture_3d<f32>;
@group(1) @binding(2) var volume2: texture_3d<f32>;
@group(1) @binding(3) var volume3: texture_3d<f32>;
@group(1) @binding(4) var linear: sampler;

fn light_at(first_term: u32, point: vec3<f32>) -> vec3<f32> {
    let species = flb_species[ask.species];
    let n = f32(ask.lattice);
    let uvw = ((point - species.middle_m) * species.sites_per_m + 0.5 * n + 0.5) / n;
    return textureSampleLevel(volume0, linear, uvw, 0.0).xyz * flb_terms[first_term].factor
        + textureSampleLevel(volume1, linear, uvw, 0.0).xyz * flb_terms[first_term + 1u].factor
        + textureSampleLevel(volume2, linear, uvw, 0.0).xyz * flb_terms[first_term + 2u].factor
        + textureSampleLevel(volume3, linear, uvw, 0.0).xyz * flb_terms[first_term + 3u].factor;
}
