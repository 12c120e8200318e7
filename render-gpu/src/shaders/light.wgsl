// Adds the light of fields: all that this renderer knows of it is `indirect`, of light_isolated.wgsl, or of
// light_in_scene.wgsl where plants change each other's light.

struct SpeciesTerms {
    // Light everywhere in its model, beside that of the terms.
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
    // Terms at the beginning that are of the sky; with UNEVEN, of an uneven one, for flb_sky.
    sky_count: u32,
}

// What light of fields is asked for.
struct Asked {
    point_model_m: vec3<f32>,
    // Side of a solid, or 0.
    facing: vec3<f32>,
}

// Places of a pixel from which the near beam around its points is estimated: each of its rays has an even share.
const OFFSETS: u32 = 4u;

const NONE: u32 = 0xffffffffu;
const UNEVEN: u32 = 0x80000000u;

// In the order of the stand's tree.
@group(1) @binding(0) var<storage, read> species_terms: array<SpeciesTerms>;

// The near beam at a point, for species_terms that need it.
fn near_of(terms: SpeciesTerms, point_model_m: vec3<f32>) -> vec4<f32> {
    let bits = bitcast<vec3<u32>>(point_model_m);
    let seed = hash(hash(hash(bits.x) ^ bits.y) ^ bits.z);
    let offsets = (OFFSETS + view.samples - 1u) / view.samples;
    return flb_near(terms.species, point_model_m, terms.towards_sun, offsets, seed);
}

// Takes off what light is below its least. Where several rays make a pixel and the near beam is marched for, the pixel
// is bounded instead: cut off ray by ray, noise would make it too bright.
fn bounded(terms: SpeciesTerms, light: vec3<f32>) -> vec3<f32> {
    let is_shared = terms.near_count > 0u && view.samples > 1u;
    return select(max(light, vec3<f32>(terms.least)), light, is_shared);
}

// Light of a plant's terms but for so many of the first.
fn of_terms_from(terms: SpeciesTerms, skipped: u32, point_model_m: vec3<f32>) -> vec3<f32> {
    var near = vec4<f32>(1.0);
    var near_from = FLB_NONE;
    if terms.near_count > 0u {
        near = near_of(terms, point_model_m);
        near_from = terms.first_term + terms.term_count - terms.near_count;
    }
    let place = flb_locate(terms.species, point_model_m);
    let first = terms.first_term + skipped;
    return flb_light_near(terms.species, first, terms.term_count - skipped, place.texel, place.part, near_from, near);
}

// Light of a plant under an uneven sky: of the sun and of the sky, times these shares.
fn under_uneven_sky(terms: SpeciesTerms, asked: Asked, sun: f32, sky: f32) -> vec3<f32> {
    let of_sun = of_terms_from(terms, terms.sky_count & ~UNEVEN, asked.point_model_m);
    let light = bounded(terms, (terms.constant + of_sun) * sun) * daylight.sun_color;
    return light + flb_sky(terms.species, terms.first_term, asked.point_model_m, asked.facing) * sky;
}

@compute @workgroup_size(WORKGROUP)
fn light(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let task = task_of(workgroup.x, local);
    if !task.is_inside {
        return;
    }
    let seen = lit[task.ray];
    if seen.instance < GROUND && any(seen.share != vec3<f32>(0.0)) {
        let facing = vec3<f32>(unpack2x16snorm(seen.facing_xy), unpack2x16snorm(seen.facing_z).x);
        lit[task.ray].color = seen.color + seen.share * indirect(seen.instance, Asked(seen.point_model_m, facing));
    }
}
