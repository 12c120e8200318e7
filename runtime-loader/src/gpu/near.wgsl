// The near beam of the sun, for species of harmonics: what part of the sun comes to a point unscattered, in the mean
// over cubes around it, and scattered once. The twin of near_beam/march.rs and extinction.rs, in the same order, but
// for rounding.
//
//   let near = flb_near(species, point_model_m, towards_sun_model, offsets, seed);
//   let light = flb_sample_near(species, first_term, term_count, near_count, point_model_m, near);
//
// Words of an extinction: pairs of 32 blocks' bits and the number of blocks with matter before them; FLB_RELATIVE
// floats; two pairs a block, each of 32 sites' bits, [z][y][x], and the place of their first word behind the floats; a
// word for each site with matter, of two binary16: optical depth along a site's edge by leaves (low half) and by wood.

const FLB_CANDIDATES: u32 = 16u;
const FLB_RELATIVE: u32 = 257u;
// Edges of cubes, in sites on either side: by one number of species without light scattered once, by the other of those
// with it.
const FLB_REACHES: vec3<i32> = vec3<i32>(1, 3, 8);
const FLB_REACH_WITH_SINGLE: i32 = 8;
// Where the extinction is not there.
const FLB_UNKNOWN_BEAM: f32 = 0.5;
const FLB_DARK: f32 = 18.5;
const FLB_STEEP: f32 = 1e-12;
// The last place within a site.
const FLB_LAST_WITHIN: f32 = 0.9999847;
const FLB_STEP: vec3<u32> = vec3<u32>(3518319155u, 2882110345u, 2360945575u);
// By which an offset becomes those of where light scattered once comes to, and of where in a site it was scattered.
const FLB_FROM: vec3<u32> = vec3<u32>(129u, 181u, 235u);
const FLB_WITHIN: vec3<u32> = vec3<u32>(5379u, 4695u, 8115u);

// A ray in lattice coordinates.
struct FlbRay {
    point: vec3<f32>,
    direction: vec3<f32>,
    // Extinction of leaves for this direction, relative to its mean.
    relative: f32,
}

// Where a ray ends: outside, behind an optical depth, or so many site edges from its start.
struct FlbTravel {
    stopped: bool,
    depth: f32,
    t: f32,
}

// The light of flb_sample for terms whose last `near_count` are of the near beam's means; never below 0.
fn flb_sample_near(
    species: u32,
    first_term: u32,
    term_count: u32,
    near_count: u32,
    point_model_m: vec3<f32>,
    near: vec4<f32>,
) -> vec3<f32> {
    let place = flb_locate(species, point_model_m);
    let near_from = first_term + term_count - near_count;
    return max(flb_light_near(species, first_term, term_count, place.texel, place.part, near_from, near), vec3<f32>(0.0));
}

// Means of the near beam between the sites around a point, for a sun along a unit vector of the model's frame.
// `offsets` places stand for each mean, 0 for the point itself; their error falls nearly with their number. `seed` says
// which: another one for every pixel and ray.
fn flb_near(species: u32, point_model_m: vec3<f32>, towards_sun: vec3<f32>, offsets: u32, seed: u32) -> vec4<f32> {
    let single = flb_species[species].single != 0u;
    if flb_species[species].extinction == FLB_NONE {
        return flb_everywhere(FLB_UNKNOWN_BEAM, single);
    }
    let n = i32(flb_species[species].lattice);
    let from_middle = (point_model_m - flb_species[species].middle_m) * flb_species[species].sites_per_m;
    let point = from_middle + vec3<f32>(f32(n / 2) + 0.5);
    let sun = flb_ray(species, point, towards_sun);
    if offsets == 0u {
        return flb_everywhere(flb_transmittance(species, sun), single);
    }
    let around = flb_around(species, point);
    var beam = 0.0;
    var light = vec3<f32>(0.0);
    var found = vec3<f32>(0.0);
    for (var i = 0u; i < offsets; i++) {
        let digits = flb_offset(seed, i);
        let place = flb_place(around, digits);
        let ray = FlbRay(place, towards_sun, sun.relative);
        beam += flb_transmittance(species, ray);
        let site = min(vec3<i32>(max(place, vec3<f32>(0.0))), vec3<i32>(n - 1));
        if single {
            let comes_to = flb_place(around, digits * FLB_FROM);
            light.y += flb_scattered_once(species, FlbRay(comes_to, towards_sun, sun.relative), digits);
            let one = flb_drawn(species, site, FLB_REACH_WITH_SINGLE, digits, offsets, sun);
            light.x += one.x;
            found.x += one.y;
        } else {
            let one = flb_drawn(species, site, FLB_REACHES.x, digits, offsets, sun);
            let two = flb_drawn(species, site, FLB_REACHES.y, digits, offsets, sun);
            let three = flb_drawn(species, site, FLB_REACHES.z, digits, offsets, sun);
            light += vec3<f32>(one.x, two.x, three.x);
            found += vec3<f32>(one.y, two.y, three.y);
        }
    }
    if single {
        found.y = f32(offsets);
        found.z = 0.0;
    }
    let near = flb_everywhere(beam / f32(offsets), single);
    let means = select(near.yzw, light / max(found, vec3<f32>(1e-30)), found > vec3<f32>(0.0));
    return vec4<f32>(near.x, means);
}

// Those of the eight sites around a point that hold matter.
struct FlbAround {
    point: vec3<f32>,
    low: vec3<f32>,
    // Trilinear, [y][x]; 0 of sites without matter: of the lower and of the upper plane.
    near_z: vec4<f32>,
    far_z: vec4<f32>,
}

fn flb_around(species: u32, point: vec3<f32>) -> FlbAround {
    let last = f32(flb_species[species].lattice - 1u);
    let at = min(max(point - vec3<f32>(0.5), vec3<f32>(0.0)), vec3<f32>(last));
    let low = floor(min(at, vec3<f32>(last - 1.0)));
    let part = at - low;
    var planes = array<vec4<f32>, 2>();
    for (var corner = 0u; corner < 8u; corner++) {
        let upper = (vec3<u32>(corner) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
        let depths = flb_depths(species, vec3<u32>(low) + upper);
        let along = select(vec3<f32>(1.0) - part, part, upper == vec3<u32>(1u));
        planes[corner >> 2u][corner & 3u] = select(0.0, along.x * along.y * along.z, depths.x + depths.y > 0.0);
    }
    return FlbAround(point, low, planes[0], planes[1]);
}

// A place in one of the sites: as many offsets lead to each as its weight says, even all over it.
fn flb_place(around: FlbAround, digits: vec3<u32>) -> vec3<f32> {
    let offset = flb_part(digits);
    let lower = around.near_z.x + around.near_z.y + (around.near_z.z + around.near_z.w);
    let upper = around.far_z.x + around.far_z.y + (around.far_z.z + around.far_z.w);
    if lower + upper == 0.0 {
        return around.point;
    }
    let z = flb_split(lower, upper, offset.z);
    let plane = select(around.near_z, around.far_z, z.x > 0.0);
    let y = flb_split(plane.x + plane.y, plane.z + plane.w, offset.y);
    let line = select(plane.xy, plane.zw, y.x > 0.0);
    let x = flb_split(line.x, line.y, offset.x);
    return around.low + vec3<f32>(x.x, y.x, z.x) + vec3<f32>(x.y, y.y, z.y);
}

// Which of two weights a number from 0 to below 1 falls to, 0 or 1, and where in it.
fn flb_split(low: f32, high: f32, number: f32) -> vec2<f32> {
    let share = low / (low + high);
    if number < share {
        return vec2<f32>(0.0, min(number / share, FLB_LAST_WITHIN));
    }
    return vec2<f32>(1.0, min((number - share) / (1.0 - share), FLB_LAST_WITHIN));
}

// The means where one beam lights all around and nothing scatters.
fn flb_everywhere(beam: f32, single: bool) -> vec4<f32> {
    return select(vec4<f32>(beam), vec4<f32>(beam, beam, 0.0, 0.0), single);
}

fn flb_ray(species: u32, point: vec3<f32>, direction: vec3<f32>) -> FlbRay {
    let table = flb_species[species].extinction + flb_map_words(species);
    let place = min(abs(direction.y), 1.0) * f32(FLB_RELATIVE - 1u);
    let first = min(u32(place), FLB_RELATIVE - 2u);
    let low = bitcast<f32>(flb_words[table + first]);
    let high = bitcast<f32>(flb_words[table + first + 1u]);
    return FlbRay(point, direction, low + (high - low) * (place - f32(first)));
}

fn flb_map_words(species: u32) -> u32 {
    let edge = flb_species[species].lattice / 4u;
    return (edge * edge * edge + 31u) / 32u * 2u;
}

// Share of the sun's light that comes along a ray.
fn flb_transmittance(species: u32, ray: FlbRay) -> f32 {
    let travel = flb_travel(species, ray, FLB_DARK);
    return select(exp(-travel.depth), 0.0, travel.stopped);
}

// Optical depths of a site by leaves and by wood; negative where its block has no matter.
fn flb_depths(species: u32, site: vec3<u32>) -> vec2<f32> {
    let rank = flb_rank(flb_species[species].extinction, site >> vec3<u32>(2u));
    if rank == FLB_NONE {
        return vec2<f32>(-1.0);
    }
    let local = site & vec3<u32>(3u);
    let blocks = flb_species[species].extinction + flb_map_words(species) + FLB_RELATIVE;
    let pair = blocks + 4u * rank + (local.z & 2u);
    let bits = flb_words[pair];
    let bit = 1u << (((local.z & 1u) * 4u + local.y) * 4u + local.x);
    if (bits & bit) == 0u {
        return vec2<f32>(0.0);
    }
    return unpack2x16float(flb_words[blocks + flb_words[pair + 1u] + countOneBits(bits & (bit - 1u))]);
}

// Follows a ray until it leaves the lattice or has crossed an optical depth.
fn flb_travel(species: u32, ray: FlbRay, most_depth: f32) -> FlbTravel {
    let n = i32(flb_species[species].lattice);
    let steep = select(vec3<f32>(FLB_STEEP), vec3<f32>(-FLB_STEEP), ray.direction < vec3<f32>(0.0));
    let direction = select(ray.direction, steep, abs(ray.direction) < vec3<f32>(FLB_STEEP));
    let inverse = 1.0 / direction;
    let ahead = direction > vec3<f32>(0.0);
    let first_faces = -ray.point * inverse;
    let last_faces = (vec3<f32>(f32(n)) - ray.point) * inverse;
    let enters = min(first_faces, last_faces);
    let leaves = max(first_faces, last_faces);
    var t = max(max(enters.x, 0.0), max(enters.y, enters.z));
    if t >= min(leaves.x, min(leaves.y, leaves.z)) {
        return FlbTravel(false, 0.0, 0.0);
    }
    var site = clamp(vec3<i32>(floor(ray.point + direction * t)), vec3<i32>(0), vec3<i32>(n - 1));
    var depth = 0.0;
    // A site is left for good at every step.
    for (var step = 0; step < 3 * n; step++) {
        let depths = flb_depths(species, vec3<u32>(site));
        let is_empty = depths.x < 0.0;
        let size = select(1, 4, is_empty);
        let per_edge = select(depths.x * ray.relative + depths.y, 0.0, is_empty);
        let low = site & vec3<i32>(-size);
        let faces = select(low, low + vec3<i32>(size), ahead);
        let ends = (vec3<f32>(faces) - ray.point) * inverse;
        let is_x = ends.x <= ends.y && ends.x <= ends.z;
        let is_y = !is_x && ends.y <= ends.z;
        let axis = vec3<bool>(is_x, is_y, !is_x && !is_y);
        let end = max(select(select(ends.z, ends.y, is_y), ends.x, is_x), t);
        depth += per_edge * (end - t);
        if depth > most_depth {
            return FlbTravel(true, most_depth, end - (depth - most_depth) / per_edge);
        }
        t = end;
        // Onwards only, and in the cell that is left, whatever was rounded.
        let within = clamp(
            vec3<i32>(floor(ray.point + direction * t)),
            select(low, site, ahead),
            select(site, low + vec3<i32>(size - 1), ahead),
        );
        site = select(within, select(low - vec3<i32>(1), low + vec3<i32>(size), ahead), axis);
        if any(site < vec3<i32>(0)) || any(site >= vec3<i32>(n)) {
            break;
        }
    }
    return FlbTravel(false, depth, 0.0);
}

// Light that comes to a point along one way after one scattering.
fn flb_scattered_once(species: u32, sun: FlbRay, digits: vec3<u32>) -> f32 {
    let offset = flb_part(digits);
    let z = 2.0 * offset.x - 1.0;
    let turn = 6.2831855 * offset.y;
    let across = sqrt(max(1.0 - z * z, 0.0));
    let back = vec3<f32>(across * cos(turn), across * sin(turn), z);
    let travel = flb_travel(species, flb_ray(species, sun.point, back), -log(1.0 - offset.z));
    if !travel.stopped {
        return 0.0;
    }
    let place = floor(sun.point + travel.t * back) + flb_part(digits * FLB_WITHIN);
    return flb_transmittance(species, FlbRay(place, sun.direction, sun.relative));
}

// Light of a place in a cube around a site, drawn by its extinction, times what its candidates have of that; and the
// latter.
fn flb_drawn(species: u32, site: vec3<i32>, reach: i32, first: vec3<u32>, count: u32, sun: FlbRay) -> vec2<f32> {
    let n = i32(flb_species[species].lattice);
    let low = max(site - vec3<i32>(reach), vec3<i32>(0));
    let high = min(site + vec3<i32>(reach + 1), vec3<i32>(n));
    var digits = first;
    var choice = flb_choice(first);
    var place = vec3<f32>(0.0);
    var matter = 0.0;
    for (var i = 0u; i < FLB_CANDIDATES; i++) {
        let candidate = vec3<f32>(low) + vec3<f32>(high - low) * flb_part(digits);
        let at = min(vec3<u32>(candidate), vec3<u32>(high) - vec3<u32>(1u));
        let depths = flb_depths(species, at);
        let depth = depths.x + depths.y;
        if depth > 0.0 {
            matter += depth;
            let share = depth / matter;
            if choice < share {
                place = candidate;
                choice /= share;
            } else {
                choice = (choice - share) / (1.0 - share);
            }
        }
        digits += FLB_STEP * count;
    }
    if matter == 0.0 {
        return vec2<f32>(0.0);
    }
    return vec2<f32>(matter * flb_transmittance(species, FlbRay(place, sun.direction, sun.relative)), matter);
}

// Digits of the offset of a number, in 2^-32: an additive sequence turned by a seed.
fn flb_offset(seed: u32, number: u32) -> vec3<u32> {
    let turn = vec3<u32>(flb_hash(seed), flb_hash(seed + 1u), flb_hash(seed + 2u));
    return (turn + FLB_STEP * number) & vec3<u32>(0xffffff00u);
}

// From 0 to below 1.
fn flb_part(digits: vec3<u32>) -> vec3<f32> {
    return vec3<f32>(digits >> vec3<u32>(8u)) / 16777216.0;
}

fn flb_choice(digits: vec3<u32>) -> f32 {
    let mixed = digits.x ^ ((digits.y << 11u) | (digits.y >> 21u)) ^ ((digits.z << 22u) | (digits.z >> 10u));
    return f32(flb_hash(mixed) >> 8u) / 16777216.0;
}

fn flb_hash(value: u32) -> u32 {
    var h = value;
    h = (h ^ (h >> 16u)) * 0x85ebca6bu;
    h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
    return h ^ (h >> 16u);
}
