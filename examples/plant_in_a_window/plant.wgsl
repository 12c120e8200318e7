// Draws leaves and wood in the light of flb. The functions flb_near and flb_sample_near stand before this text, and
// take bind group 1.

struct Frame {
    clip_from_model: mat4x4<f32>,
    // Unit, and the sun's irradiance.
    towards_sun: vec4<f32>,
    eye: vec4<f32>,
    leaf_reflectance: vec4<f32>,
    leaf_transmittance: vec4<f32>,
    wood_reflectance: vec4<f32>,
    // Number of the species, of its terms, and of those at their end that are of the near beam; metres off a solid's
    // surface at which its light is sampled.
    counts: vec4<f32>,
}

struct Corner {
    @builtin(position) clip: vec4<f32>,
    // At rest: wind and bones would move `clip` alone.
    @location(0) point: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) is_wood: f32,
}

const PI: f32 = 3.14159265;
// A white surface that faces the sun is as bright as this; 1 is the brightest that a screen shows.
const EXPOSURE: f32 = 3.0;
// Points from which the near beam of a pixel is estimated: more of them, less noise.
const OFFSETS: u32 = 2u;

@group(0) @binding(0) var<uniform> frame: Frame;

@vertex
fn vertex(@location(0) point: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) is_wood: f32) -> Corner {
    return Corner(frame.clip_from_model * vec4<f32>(point, 1.0), point, normal, is_wood);
}

@fragment
fn fragment(at: Corner) -> @location(0) vec4<f32> {
    let species = u32(frame.counts.x);
    let sun = frame.towards_sun.xyz;
    // The baked light: what leaves and wood scattered, and the sky's.
    let seed = u32(at.clip.x) + 4096u * u32(at.clip.y);
    let is_wood = at.is_wood > 0.5;
    let is_seen_from_front = dot(at.normal, frame.eye.xyz - at.point) > 0.0;
    let seen_normal = select(-at.normal, at.normal, is_seen_from_front);
    let point = at.point + select(0.0, frame.counts.w, is_wood) * seen_normal;
    let near = flb_near(species, point, sun, OFFSETS, seed);
    let fluence = flb_sample_near(species, 0u, u32(frame.counts.y), u32(frame.counts.z), point, near);
    // The sun's own beam is the renderer's. With a mesh it is 1 or 0, by a shadow ray or a shadow map; of a medium a
    // part comes through, which is the first of the near beam's means.
    let beam = frame.towards_sun.w * near.x;

    // The lighting model, section 10.
    let cosine = dot(at.normal, sun);
    let is_lit_side = (cosine > 0.0) == is_seen_from_front;
    let reflectance = frame.leaf_reflectance.rgb;
    let transmittance = frame.leaf_transmittance.rgb;
    let leaf = (reflectance + transmittance) * fluence / (4.0 * PI)
        + select(transmittance, reflectance, is_lit_side) / PI * beam * abs(cosine);
    let bark = frame.wood_reflectance.rgb;
    let wood = bark * fluence / (4.0 * PI) + select(0.0, 1.0, is_lit_side) * bark / PI * beam * abs(cosine);
    return vec4<f32>(EXPOSURE * PI * select(leaf, wood, is_wood), 1.0);
}
