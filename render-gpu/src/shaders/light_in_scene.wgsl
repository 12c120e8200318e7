// Light of an instance's fields among its neighbours: sun and sky are sampled apart, each is cut to the share that
// others leave of it, and what they add comes to both in its own colour. The twin is scene_light/at_sun.rs of the
// runtime.

// What the light of an instance lies between.
struct VolumeBlend {
    // Rows of what takes points of the model to the scene's lattice.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    // Volumes of its species alone, as their first words: the sky's, or NONE where others change nothing; then the
    // sun's three.
    volumes: vec4<u32>,
    // How much of each of the sun's there is, together 1; x is not used.
    weights: vec4<f32>,
}

// What others leave of light, and add to that of a source of 1.
struct Modulation {
    scale: f32,
    add: f32,
}

// Of the mean light of a species alone: what is added to both sides of a quotient.
const FLOOR: f32 = 0.02;
const LUMINANCE: vec3<f32> = vec3<f32>(0.2126, 0.7152, 0.0722);
// Where no light is known.
const UNKNOWN: f32 = -1.0;
// Words before a volume's values: where the lattice begins, sites a metre, sites along an edge, the mean.
const HEAD: u32 = 6u;

// In the order of the stand's tree.
@group(1) @binding(1) var<storage, read> blends: array<VolumeBlend>;
// First words of the scene's own volumes, the sky's and the sun's or NONE; bits of the sun's and the sky's light in an
// empty scene, where that is what the scene's light is compared with, else 0; then all volumes, their values [z][y][x]
// as bits of floats.
@group(1) @binding(2) var<storage, read> volumes: array<u32>;

fn indirect(instance: u32, asked: Asked) -> vec3<f32> {
    let point_model_m = asked.point_model_m;
    let terms = species_terms[instance];
    if terms.species == NONE {
        return terms.constant;
    }
    let blend = blends[instance];
    let sky = modulation_of_sky(blend, point_model_m);
    let sun = modulation_of_sun(blend, point_model_m);
    let added_by_sun = daylight.sun_strength * dot(daylight.sun_color, LUMINANCE) * sun.add;
    let added = added_by_sun + dot(daylight.fluence, LUMINANCE) * sky.add;
    if (terms.sky_count & UNEVEN) != 0u {
        return with_added(under_uneven_sky(terms, asked, sun.scale, sky.scale), added);
    }
    let of_sky = flb_sample(terms.species, terms.first_term, terms.sky_count, point_model_m);
    let of_sun = of_terms_from(terms, terms.sky_count, point_model_m);
    return with_added(bounded(terms, (terms.constant + of_sky) * sky.scale + of_sun * sun.scale), added);
}

// Light, and what others add to it, in its own colour.
fn with_added(light: vec3<f32>, added: f32) -> vec3<f32> {
    let luminance = dot(light, LUMINANCE);
    if added > 0.0 {
        return select(light + vec3<f32>(added), light * (1.0 + added / luminance), luminance > 0.0);
    }
    return light;
}

fn modulation_of_sky(blend: VolumeBlend, point_model_m: vec3<f32>) -> Modulation {
    let sky = blend.volumes.x;
    if sky == NONE {
        return Modulation(1.0, 0.0);
    }
    let scene = value_at(volumes[0], scene_lattice_of(blend, point_model_m));
    if volumes[3] != 0u {
        return modulation_of_empty(scene, bitcast<f32>(volumes[3]));
    }
    let alone = value_at(sky, lattice_of(sky, point_model_m));
    return modulation_of(scene, alone, mean_of(sky));
}

fn modulation_of_sun(blend: VolumeBlend, point_model_m: vec3<f32>) -> Modulation {
    let scene = volumes[1];
    if blend.volumes.x == NONE || scene == NONE {
        return Modulation(1.0, 0.0);
    }
    let of_scene = value_at(scene, scene_lattice_of(blend, point_model_m));
    if volumes[2] != 0u {
        return modulation_of_empty(of_scene, bitcast<f32>(volumes[2]));
    }
    var alone = 0.0;
    var mean = 0.0;
    for (var part = 1u; part < 4u; part++) {
        let weight = blend.weights[part];
        if weight > 0.0 {
            let volume = blend.volumes[part];
            let value = value_at(volume, lattice_of(volume, point_model_m));
            alone = select(alone + weight * value, UNKNOWN, alone == UNKNOWN || value == UNKNOWN);
            mean += weight * mean_of(volume);
        }
    }
    return modulation_of(of_scene, alone, mean);
}

// The papers' factor.
fn modulation_of_empty(scene: f32, empty: f32) -> Modulation {
    return Modulation(select(scene / empty, 1.0, scene == UNKNOWN), 0.0);
}

fn modulation_of(scene: f32, alone: f32, mean: f32) -> Modulation {
    if scene == UNKNOWN || alone == UNKNOWN {
        return Modulation(1.0, 0.0);
    }
    let floor_ = FLOOR * mean;
    return Modulation(select(1.0, (scene + floor_) / (alone + floor_), scene < alone), max(scene - alone, 0.0));
}

fn scene_lattice_of(blend: VolumeBlend, point_model_m: vec3<f32>) -> vec3<f32> {
    let point = vec4<f32>(point_model_m, 1.0);
    return vec3<f32>(dot(blend.x, point), dot(blend.y, point), dot(blend.z, point));
}

// In sites, from where the lattice begins.
fn lattice_of(volume: u32, point_m: vec3<f32>) -> vec3<f32> {
    let origin = bitcast<vec3<f32>>(vec3<u32>(volumes[volume], volumes[volume + 1u], volumes[volume + 2u]));
    return (point_m - origin) * bitcast<f32>(volumes[volume + 3u]);
}

fn mean_of(volume: u32) -> f32 {
    return bitcast<f32>(volumes[volume + 5u]);
}

// The mean of the known ones of the eight values around a place, by their trilinear weights, or UNKNOWN. Bits that are
// NONE are not known: shaders need not tell what is no number.
fn value_at(volume: u32, place: vec3<f32>) -> f32 {
    let lattice = volumes[volume + 4u];
    let at = clamp(place - vec3<f32>(0.5), vec3<f32>(0.0), vec3<f32>(f32(lattice - 1u)));
    let first = min(vec3<u32>(at), vec3<u32>(lattice - 2u));
    let part = at - vec3<f32>(first);
    var sum = 0.0;
    var weights = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let upper = (vec3<u32>(corner) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
        let site = first + upper;
        let bits = volumes[volume + HEAD + (site.z * lattice + site.y) * lattice + site.x];
        let along = select(vec3<f32>(1.0) - part, part, upper == vec3<u32>(1u));
        let weight = along.x * along.y * along.z;
        if weight > 0.0 && bits != NONE {
            sum += weight * bitcast<f32>(bits);
            weights += weight;
        }
    }
    return select(UNKNOWN, sum / weights, weights > 0.0);
}
