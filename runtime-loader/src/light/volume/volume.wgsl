// The whole light of plants as volumes (LightVolume::words). Put this file before your own shader; it adds names that
// begin with flb_ or FLB, and one binding:
//
//   @group(0) @binding(0)  storage, read only  volumes, one behind the other in any order
//
// `flb_volume(volume, point_m)` is the light at a point of the model at rest, red, green and blue, of eight
// texels. `volume` is the word at which a volume begins.
//
// `flb_light(forest, plant, point_m)` is that of a plant of a forest (ForestBuffer): the sum of up to eight volumes.
// `forest` is the word at which its buffer begins, `plant` the number of the plant there.

// Words of a volume's head.
const FLB_VOLUME_LATTICE: u32 = 1u;
const FLB_VOLUME_MIDDLE: u32 = 2u;
const FLB_VOLUME_SITES_PER_M: u32 = 5u;
const FLB_VOLUME_MAP: u32 = 6u;
const FLB_VOLUME_RANGES: u32 = 7u;
const FLB_VOLUME_CODES: u32 = 8u;
const FLB_VOLUME_COARSE: u32 = 9u;
const FLB_VOLUME_COARSE_EDGE: u32 = 10u;
const FLB_VOLUME_LEAST: u32 = 11u;

const FLB_VOLUME_NO_BLOCK: u32 = 0xffffffffu;
// Sites from one coarse value to the next.
const FLB_VOLUME_COARSE_SITES: f32 = 16.0;

@group(0) @binding(0) var<storage, read> flb_volumes: array<u32>;

fn flb_volume_floats(at: u32) -> vec3<f32> {
    let words = vec3<u32>(flb_volumes[at], flb_volumes[at + 1u], flb_volumes[at + 2u]);
    return bitcast<vec3<f32>>(words);
}

// Bits of a coordinate, two apart.
fn flb_volume_spread(coordinate: u32) -> u32 {
    var v = (coordinate | coordinate << 16u) & 0x030000ffu;
    v = (v | v << 8u) & 0x0300f00fu;
    v = (v | v << 4u) & 0x030c30c3u;
    return (v | v << 2u) & 0x09249249u;
}

// Number of a block among the stored ones.
fn flb_volume_rank(map: u32, block: vec3<u32>) -> u32 {
    let code = flb_volume_spread(block.x) | flb_volume_spread(block.y) << 1u | flb_volume_spread(block.z) << 2u;
    let at = map + 2u * (code >> 5u);
    let bits = flb_volumes[at];
    let bit = 1u << (code & 31u);
    if (bits & bit) == 0u {
        return FLB_VOLUME_NO_BLOCK;
    }
    return flb_volumes[at + 1u] + countOneBits(bits & (bit - 1u));
}

// What stands in for a texel where no block is stored.
fn flb_volume_coarse(volume: u32, texel: vec3<u32>) -> vec3<f32> {
    let first = volume + flb_volumes[volume + FLB_VOLUME_COARSE];
    let edge = flb_volumes[volume + FLB_VOLUME_COARSE_EDGE];
    let place = (vec3<f32>(texel) + 0.5) / FLB_VOLUME_COARSE_SITES - 0.5;
    let inside = clamp(place, vec3<f32>(0.0), vec3<f32>(f32(edge) - 1.0));
    let low = vec3<u32>(inside);
    let part = inside - vec3<f32>(low);
    var light = vec3<f32>(0.0);
    for (var corner = 0u; corner < 8u; corner += 1u) {
        let upper = (vec3<u32>(corner) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
        let at = min(low + upper, vec3<u32>(edge - 1u));
        let weights = mix(1.0 - part, part, vec3<f32>(upper));
        let value = flb_volume_floats(first + 3u * ((at.z * edge + at.y) * edge + at.x));
        light += weights.x * weights.y * weights.z * value;
    }
    return light;
}

// Light of a plant at a point of its model at rest, metres. A point outside takes the light of the nearest one inside.
fn flb_volume(volume: u32, point_m: vec3<f32>) -> vec3<f32> {
    let lattice = flb_volumes[volume + FLB_VOLUME_LATTICE];
    let sites_per_m = bitcast<f32>(flb_volumes[volume + FLB_VOLUME_SITES_PER_M]);
    let from_middle = (point_m - flb_volume_floats(volume + FLB_VOLUME_MIDDLE)) * sites_per_m;
    let last = f32(lattice) - 1.0;
    let place = clamp(from_middle + 0.5 * last, vec3<f32>(0.0), vec3<f32>(last));
    let texel = min(vec3<u32>(place), vec3<u32>(lattice - 2u));
    let part = place - vec3<f32>(texel);
    let map = volume + flb_volumes[volume + FLB_VOLUME_MAP];
    let ranges = volume + flb_volumes[volume + FLB_VOLUME_RANGES];
    let codes = volume + flb_volumes[volume + FLB_VOLUME_CODES];
    var block = texel >> vec3<u32>(2u);
    var rank = flb_volume_rank(map, block);
    var light = vec3<f32>(0.0);
    for (var corner = 0u; corner < 8u; corner += 1u) {
        let upper = (vec3<u32>(corner) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
        let at = texel + upper;
        let weights = mix(1.0 - part, part, vec3<f32>(upper));
        let weight = weights.x * weights.y * weights.z;
        let its_block = at >> vec3<u32>(2u);
        if any(its_block != block) {
            block = its_block;
            rank = flb_volume_rank(map, block);
        }
        if rank == FLB_VOLUME_NO_BLOCK {
            light += weight * flb_volume_coarse(volume, at);
        } else {
            let inside = at & vec3<u32>(3u);
            let code = flb_volumes[codes + 64u * rank + (inside.z * 4u + inside.y) * 4u + inside.x];
            let channels = vec3<f32>((vec3<u32>(code) >> vec3<u32>(0u, 8u, 16u)) & vec3<u32>(255u));
            let range = ranges + 6u * rank;
            light += weight * (flb_volume_floats(range) + flb_volume_floats(range + 3u) * channels);
        }
    }
    let least = bitcast<f32>(flb_volumes[volume + FLB_VOLUME_LEAST]);
    return max(light, vec3<f32>(least));
}

// Words of a forest, of a species, and of a plant.
const FLB_FOREST_PLANTS: u32 = 1u;
const FLB_FOREST_MAX_PLANTS: u32 = 2u;
const FLB_SPECIES_FACTOR: u32 = 1u;
const FLB_SPECIES_REST: u32 = 3u;
const FLB_SPECIES_STEP_DEG: u32 = 6u;
const FLB_SPECIES_SUNS: u32 = 8u;
const FLB_SPECIES_VOLUMES: u32 = 24u;
// Words of a sun, which begins with a unit vector.
const FLB_SUN: u32 = 8u;
const FLB_SUN_AZIMUTH: u32 = 3u;
const FLB_SUN_ELEVATION: u32 = 4u;
const FLB_SUN_OWN_ROW: u32 = 5u;
const FLB_SUN_TOP_ROW: u32 = 6u;
const FLB_SUN_STRIDE: u32 = 7u;
const FLB_PLANT: u32 = 4u;
const FLB_PLANT_TILTED: u32 = 0x80000000u;

// The two rows and yaws between which a plant's sun lies, with the shares of the second ones.
struct FlbCells {
    rows: vec2<u32>,
    yaws: vec2<u32>,
    second_row: f32,
    second_yaw: f32,
}

// A share of less than a thousandth is none, and one of nearly all is all.
fn flb_share(share: f32) -> f32 {
    return select(select(0.0, share, share >= 0.001), 1.0, share > 0.999);
}

// Where a plant lies whose record begins at a word, under a sun that begins at another.
fn flb_cells(record: u32, species: u32, sun: u32) -> FlbCells {
    let yaws = flb_volumes[species];
    let own = flb_volumes[sun + FLB_SUN_OWN_ROW];
    let stride = flb_volumes[sun + FLB_SUN_STRIDE];
    if stride >= yaws {
        // One volume for all.
        return FlbCells(vec2<u32>(own), vec2<u32>(0u), 0.0, 0.0);
    }
    var turn = bitcast<f32>(flb_volumes[record + 1u]);
    var rows = vec2<u32>(own);
    var second_row = 0.0;
    if flb_volumes[record] >= FLB_PLANT_TILTED {
        let v = flb_volume_floats(record + 1u);
        let w = sqrt(max(0.0, 1.0 - dot(v, v)));
        let towards_sun = flb_volume_floats(sun);
        let once = cross(v, towards_sun);
        // The world's direction in the model's frame.
        let seen = towards_sun + 2.0 * (cross(v, once) - w * once);
        let across = length(seen.xz);
        var azimuth_deg = 0.0;
        if across > 0.0 {
            azimuth_deg = degrees(atan2(seen.x, -seen.z));
        }
        let elevation_deg = degrees(atan2(seen.y, max(across, 1e-9)));
        // More than a whole turn is added, as the rest of a negative number is negative.
        let sun_azimuth_deg = bitcast<f32>(flb_volumes[sun + FLB_SUN_AZIMUTH]);
        turn = ((sun_azimuth_deg - azimuth_deg) / 360.0 + 2.0) * f32(yaws);
        turn -= floor(turn / f32(yaws)) * f32(yaws);
        let sun_deg = bitcast<f32>(flb_volumes[sun + FLB_SUN_ELEVATION]);
        let step_deg = bitcast<f32>(flb_volumes[species + FLB_SPECIES_STEP_DEG]);
        let wide = f32(stride);
        let low = f32(own) + floor((elevation_deg - sun_deg) / (step_deg * wide)) * wide;
        let between = clamp(vec2<f32>(low, low + wide), vec2<f32>(0.0), vec2<f32>(f32(flb_volumes[sun + FLB_SUN_TOP_ROW])));
        let heights_deg = clamp(sun_deg + (between - f32(own)) * step_deg, vec2<f32>(-90.0), vec2<f32>(90.0));
        rows = vec2<u32>(between);
        second_row = flb_share((elevation_deg - heights_deg.x) / max(heights_deg.y - heights_deg.x, 0.001));
    }
    let first = min(u32(turn), yaws - 1u) / stride * stride;
    let span = min(stride, yaws - first);
    let second_yaw = flb_share((turn - f32(first)) / f32(span));
    return FlbCells(rows, vec2<u32>(first, (first + span) % yaws), second_row, second_yaw);
}

// Light of a plant of a forest at a point of its model at rest, metres; a plant that is not there has none.
fn flb_light(forest: u32, plant: u32, point_m: vec3<f32>) -> vec3<f32> {
    if plant >= flb_volumes[forest + FLB_FOREST_MAX_PLANTS] {
        return vec3<f32>(0.0);
    }
    let record = forest + flb_volumes[forest + FLB_FOREST_PLANTS] + FLB_PLANT * plant;
    if flb_volumes[record] == 0u {
        return vec3<f32>(0.0);
    }
    let species = forest + (flb_volumes[record] & ~FLB_PLANT_TILTED);
    let yaws = flb_volumes[species];
    var light = flb_volume_floats(species + FLB_SPECIES_REST);
    // Of what is shown, and of what was before it.
    for (var age = 0u; age < 2u; age += 1u) {
        let factor = bitcast<f32>(flb_volumes[species + FLB_SPECIES_FACTOR + age]);
        if factor == 0.0 {
            continue;
        }
        let cells = flb_cells(record, species, species + FLB_SPECIES_SUNS + FLB_SUN * age);
        // Two yaws of two rows.
        for (var part = 0u; part < 4u; part += 1u) {
            let is_second = vec2<bool>((part & 1u) == 1u, part >= 2u);
            let of_yaw = select(1.0 - cells.second_yaw, cells.second_yaw, is_second.x);
            let of_row = select(1.0 - cells.second_row, cells.second_row, is_second.y);
            let share = factor * of_yaw * of_row;
            if share == 0.0 {
                continue;
            }
            let row = select(cells.rows.x, cells.rows.y, is_second.y);
            let cell = row * yaws + select(cells.yaws.x, cells.yaws.y, is_second.x);
            let volume = flb_volumes[species + FLB_SPECIES_VOLUMES + 2u * cell + age];
            if volume != 0u {
                light += share * flb_volume(forest + volume, point_m);
            }
        }
    }
    return light;
}
