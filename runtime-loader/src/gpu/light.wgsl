// Light of blocks near geometry, straight from their coefficients. Put this file before your own shader; it adds names
// that begin with flb_ or Flb, and one bind group:
//
//   @group(3) @binding(0)  uniform             species   where each lies, and which blocks it stores
//   @group(3) @binding(1)  storage, read only  bases     what turns integers of a base into light
//   @group(3) @binding(2)  storage, read only  words     block maps, records, nibbles, coarse averages, and more
//   @group(3) @binding(3)  storage, read only  terms     bases that an instance's light is made of, how much of each
//
// `flb_sample(species, first_term, term_count, point_model_m)` is the light at a point: red, green and blue; of fewer
// bands the rest is 0. Records and nibbles are laid out as pack.rs describes. The sums are those of CodedBase::sample
// in another order. Light of harmonics needs the near beam beside it: near.wgsl, which follows. Light of an uneven sky
// is in sky.wgsl.

struct FlbSpecies {
    // Model space, of the texel in the middle: x = y = z = lattice / 2.
    middle_m: vec3<f32>,
    sites_per_m: f32,
    lattice: u32,
    // First word of the block map: pairs of 32 bits and the number of stored blocks before them.
    map: u32,
    // Coarse averages along an edge; 0 where all blocks are stored.
    coarse_edge: u32,
    // 0: rows of `classed`, 1: of `haar`.
    haar: u32,
    // First word of the extinction, for near.wgsl; FLB_NONE where it is not there.
    extinction: u32,
    // Whether the fields need light scattered once.
    single: u32,
    // First word of the beams of skies, for sky.wgsl; FLB_NONE where they are not there. Means that they are of.
    sky: u32,
    sky_means: u32,
}

struct FlbBase {
    // [component]: light of an integer of 1; w is not used.
    colors: array<vec4<f32>, 3>,
    components: u32,
    // First word of the records.
    records: u32,
    // First word of the coarse averages: [component][Morton code], two a word.
    coarse: u32,
    unused: u32,
}

struct FlbTerm {
    // Index of the base.
    base: u32,
    factor: f32,
}

// Lower of the eight texels of a sample, and how far it lies towards the upper ones.
struct FlbPlace {
    texel: vec3<u32>,
    part: vec3<f32>,
}

// A place between blocks: in each of the blocks that it lies in, one for each subset of the axes along which it
// straddles two.
struct FlbBlocks {
    // [subset]: 0 to 3, and 4 to 7. No array, which some drivers keep in slow memory.
    low_ranks: vec4<u32>,
    high_ranks: vec4<u32>,
    // Bits of the axes along which two blocks are straddled: the last subset.
    straddled: u32,
    // Bit `subset` says that the block is not stored.
    missing: u32,
    // Weights of texels along each axis, in the lower block; and in the upper.
    low: vec3<f32>,
    high: vec3<f32>,
    // Of coefficients.
    low_x: FlbReals,
    low_y: FlbReals,
    low_z: FlbReals,
    high_x: FlbReals,
    high_y: FlbReals,
    high_z: FlbReals,
}

// Of the sums over a word's coefficients. `light_wgsl_f16` makes them f16.
alias FlbReals = vec4<f32>;

// What a record gives.
struct FlbShare {
    // [component]: in the integers of texels.
    parts: vec3<f32>,
    // Record of the digits above, or FLB_NONE.
    more: u32,
}

const FLB_SPECIES: u32 = 256u;
const FLB_TERMS: u32 = 22u;
const FLB_NONE: u32 = 0xffffffffu;
const FLB_WIDE: u32 = 0x2000000u;
const FLB_SHIFT: u32 = 26u;
// Coefficient 0 of an average of 1.
const FLB_AVERAGE: i32 = 16;
// What coefficient 0 gives to every texel.
const FLB_CONSTANT: f32 = 27.0;
// Integer of a texel of an average of 1 / 16.
const FLB_COARSE: i32 = 27;

@group(3) @binding(0) var<uniform> flb_species: array<FlbSpecies, FLB_SPECIES>;
@group(3) @binding(1) var<storage, read> flb_bases: array<FlbBase>;
@group(3) @binding(2) var<storage, read> flb_words: array<u32>;
@group(3) @binding(3) var<storage, read> flb_terms: array<FlbTerm>;

// Light at a point: the sum of the terms' factors times their bases' trilinear samples. Points outside the lattice take
// the value of the nearest point of it; where no block is stored the coarse level answers. At most FLB_TERMS terms are
// read.
fn flb_sample(species: u32, first_term: u32, term_count: u32, point_model_m: vec3<f32>) -> vec3<f32> {
    let place = flb_locate(species, point_model_m);
    return flb_light(species, first_term, term_count, place.texel, place.part);
}

// Counted from the middle, where floats are finest.
fn flb_locate(species: u32, point_model_m: vec3<f32>) -> FlbPlace {
    let half = i32(flb_species[species].lattice / 2u);
    let offset = (point_model_m - flb_species[species].middle_m) * flb_species[species].sites_per_m;
    let inside = clamp(offset, vec3<f32>(f32(-half)), vec3<f32>(f32(half - 1)));
    let lower = min(floor(inside), vec3<f32>(f32(half - 2)));
    // Clamped again, as what is not a number may become any integer.
    let texel = clamp(vec3<i32>(lower) + half, vec3<i32>(0), vec3<i32>(2 * half - 2));
    return FlbPlace(vec3<u32>(texel), inside - lower);
}

fn flb_light(species: u32, first_term: u32, term_count: u32, texel: vec3<u32>, part: vec3<f32>) -> vec3<f32> {
    return flb_light_near(species, first_term, term_count, texel, part, FLB_NONE, vec4<f32>(1.0));
}

// Terms from number `near_from` on are multiplied with `near`, one with each.
fn flb_light_near(
    species: u32,
    first_term: u32,
    term_count: u32,
    texel: vec3<u32>,
    part: vec3<f32>,
    near_from: u32,
    near: vec4<f32>,
) -> vec3<f32> {
    let blocks = flb_blocks(species, texel, part);
    let end = first_term + min(term_count, FLB_TERMS);
    var light = vec3<f32>(0.0);
    for (var t = first_term; t < end; t++) {
        light += flb_of_base(flb_terms[t].base, blocks, flb_factor(t, near_from, near));
    }
    if blocks.missing != 0u {
        light += flb_coarse_light(species, first_term, end, texel, part, blocks.straddled, blocks.missing, near_from, near);
    }
    return light;
}

// A base times a factor, as far as its blocks are stored.
fn flb_of_base(base: u32, blocks: FlbBlocks, factor: f32) -> vec3<f32> {
    let components = flb_bases[base].components;
    let records = flb_bases[base].records;
    var parts = vec3<f32>(0.0);
    var upper = 0u;
    var more = FLB_NONE;
    loop {
        let ranks = select(blocks.low_ranks, blocks.high_ranks, upper >= 4u);
        let pair = select(ranks.xy, ranks.zw, (upper & 2u) != 0u);
        let rank = select(pair.x, pair.y, (upper & 1u) != 0u);
        if rank != FLB_NONE {
            let x = select(blocks.low_x, blocks.high_x, (upper & 1u) != 0u);
            let y = select(blocks.low_y, blocks.high_y, (upper & 2u) != 0u);
            let z = select(blocks.low_z, blocks.high_z, (upper & 4u) != 0u);
            let weights = select(blocks.low, blocks.high, (vec3<u32>(upper) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
            let record = select(more, records + rank * (1u + components), more == FLB_NONE);
            let share = flb_block(record, components, weights.x * weights.y * weights.z, x, y, z);
            parts += share.parts;
            more = share.more;
        }
        if more == FLB_NONE {
            if upper == blocks.straddled {
                break;
            }
            upper = (upper - blocks.straddled) & blocks.straddled;
        }
    }
    // Colours of components that are not there are 0.
    var light = (factor * parts.x) * flb_bases[base].colors[0].xyz + (factor * parts.y) * flb_bases[base].colors[1].xyz;
    if components > 2u {
        light += (factor * parts.z) * flb_bases[base].colors[2].xyz;
    }
    return light;
}

fn flb_factor(term: u32, near_from: u32, near: vec4<f32>) -> f32 {
    let place = select(4u, term - near_from, term >= near_from);
    let is_one = vec4<u32>(place) == vec4<u32>(0u, 1u, 2u, 3u);
    return flb_terms[term].factor * select(dot(select(vec4<f32>(0.0), near, is_one), vec4<f32>(1.0)), 1.0, place >= 4u);
}

fn flb_blocks(species: u32, texel: vec3<u32>, part: vec3<f32>) -> FlbBlocks {
    let haar = flb_species[species].haar != 0u;
    let map = flb_species[species].map;
    let local = texel & vec3<u32>(3u);
    let straddles = select(vec3<u32>(0u), vec3<u32>(1u, 2u, 4u), (local == vec3<u32>(3u)) & (part > vec3<f32>(0.0)));
    var blocks: FlbBlocks;
    blocks.straddled = straddles.x | straddles.y | straddles.z;
    blocks.missing = 0u;
    var upper = 0u;
    loop {
        let block = (texel >> vec3<u32>(2u)) + ((vec3<u32>(upper) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u));
        let rank = flb_rank(map, block);
        blocks.low_ranks = select(blocks.low_ranks, vec4<u32>(rank), vec4<u32>(upper) == vec4<u32>(0u, 1u, 2u, 3u));
        blocks.high_ranks = select(blocks.high_ranks, vec4<u32>(rank), vec4<u32>(upper) == vec4<u32>(4u, 5u, 6u, 7u));
        blocks.missing |= select(0u, 1u << upper, rank == FLB_NONE);
        if upper == blocks.straddled {
            break;
        }
        upper = (upper - blocks.straddled) & blocks.straddled;
    }
    let first = flb_column(haar, 0u);
    blocks.low = select(vec3<f32>(1.0), vec3<f32>(1.0) - part, straddles != vec3<u32>(0u));
    blocks.high = part;
    blocks.low_x = flb_along(haar, local.x, part.x);
    blocks.low_y = flb_along(haar, local.y, part.y);
    blocks.low_z = flb_along(haar, local.z, part.z);
    blocks.high_x = FlbReals(first * part.x);
    blocks.high_y = FlbReals(first * part.y);
    blocks.high_z = FlbReals(first * part.z);
    return blocks;
}

// Number of a block among those that are stored, or FLB_NONE.
fn flb_rank(map: u32, block: vec3<u32>) -> u32 {
    let code = flb_morton(block);
    let bits = flb_words[map + (code >> 5u) * 2u];
    let before = flb_words[map + (code >> 5u) * 2u + 1u];
    let bit = 1u << (code & 31u);
    return select(FLB_NONE, before + countOneBits(bits & (bit - 1u)), (bits & bit) != 0u);
}

fn flb_morton(at: vec3<u32>) -> u32 {
    var v = (at | (at << vec3<u32>(16u))) & vec3<u32>(0x030000ffu);
    v = (v | (v << vec3<u32>(8u))) & vec3<u32>(0x0300f00fu);
    v = (v | (v << vec3<u32>(4u))) & vec3<u32>(0x030c30c3u);
    v = (v | (v << vec3<u32>(2u))) & vec3<u32>(0x09249249u);
    return v.x | (v.y << 1u) | (v.z << 2u);
}

// The four rows at a texel of a block.
fn flb_column(haar: bool, texel: u32) -> vec4<f32> {
    let sign = select(-1.0, 1.0, texel < 2u);
    let outer = texel == 0u || texel == 3u;
    let smooth_ = vec4<f32>(3.0, select(2.0, 4.0, outer) * sign, select(-4.0, 4.0, outer), select(-6.0, 3.0, outer) * sign);
    let step = select(-5.0, 5.0, (texel & 1u) == 0u);
    let stepped = vec4<f32>(3.0, 3.0 * sign, select(0.0, step, texel < 2u), select(step, 0.0, texel < 2u));
    return select(smooth_, stepped, haar);
}

// Weights of a lower texel and the one above it, where that is in the same block.
fn flb_along(haar: bool, texel: u32, part: f32) -> FlbReals {
    let above = select(part, 0.0, texel == 3u);
    return FlbReals(flb_column(haar, texel) * (1.0 - part) + flb_column(haar, (texel + 1u) & 3u) * above);
}

// Share of a record: its coefficients times their weights, its average times `weight`. All words are gone through in
// one loop, since lanes of a GPU wait for one another at the end of each.
fn flb_block(record: u32, components: u32, weight: f32, x: FlbReals, y: FlbReals, z: FlbReals) -> FlbShare {
    let head = flb_words[record];
    let first = flb_words[record + 1u];
    var second = 0u;
    var third = 0u;
    if components > 1u {
        second = flb_words[record + 2u];
    }
    if components > 2u {
        third = flb_words[record + 3u];
    }
    var sums = vec3<f32>(0.0);
    var at = head & (FLB_WIDE - 1u);
    // Of the first two components, then of the third.
    var mask = (first >> 16u) | (second & 0xffff0000u);
    var is_third = mask == 0u;
    mask = select(mask, third >> 16u, is_third);
    while mask != 0u {
        let bit = firstTrailingBit(mask);
        let component = select(bit >> 4u, 2u, is_third);
        let sum = flb_octet(flb_words[at], bit & 15u, x, y, z);
        sums += select(vec3<f32>(0.0), vec3<f32>(sum), vec3<u32>(component) == vec3<u32>(0u, 1u, 2u));
        at++;
        mask &= mask - 1u;
        let ends = mask == 0u && !is_third;
        mask = select(mask, third >> 16u, ends);
        is_third = is_third || ends;
    }
    let lead = FLB_CONSTANT * weight;
    let averages = vec3<f32>(flb_average(first), flb_average(second), flb_average(third));
    let scale = f32(1u << (head >> FLB_SHIFT));
    return FlbShare(averages * lead + scale * sums, select(FLB_NONE, at, (head & FLB_WIDE) != 0u));
}

// Coefficient 0 of a component.
fn flb_average(word: u32) -> f32 {
    return f32((bitcast<i32>(word << 16u) >> 16u) * FLB_AVERAGE);
}

// Eight coefficients times their weights; `bit` of the mask says which.
fn flb_octet(word: u32, bit: u32, x: FlbReals, y: FlbReals, z: FlbReals) -> f32 {
    let first = bitcast<vec4<i32>>(vec4<u32>(word) << vec4<u32>(28u, 24u, 20u, 16u)) >> vec4<u32>(28u);
    let second = bitcast<vec4<i32>>(vec4<u32>(word) << vec4<u32>(12u, 8u, 4u, 0u)) >> vec4<u32>(28u);
    let rows = select(y.xy, y.zw, (bit & 1u) != 0u);
    let pair = select(z.xy, z.zw, (bit & 4u) != 0u);
    let plane = f32(1u << ((bit >> 3u) * 4u));
    let sum = dot(FlbReals(first), x) * rows.x + dot(FlbReals(second), x) * rows.y;
    return plane * f32(select(pair.x, pair.y, (bit & 2u) != 0u) * sum);
}

// Share of the texels in blocks that are not stored.
fn flb_coarse_light(
    species: u32,
    first_term: u32,
    end_term: u32,
    texel: vec3<u32>,
    part: vec3<f32>,
    straddled: u32,
    missing: u32,
    near_from: u32,
    near: vec4<f32>,
) -> vec3<f32> {
    let edge = flb_species[species].coarse_edge;
    var light = vec3<f32>(0.0);
    for (var corner = 0u; corner < 8u && edge > 0u; corner++) {
        let upper = (vec3<u32>(corner) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
        let weights = select(vec3<f32>(1.0) - part, part, upper == vec3<u32>(1u));
        let weight = weights.z * weights.y * weights.x;
        if (missing & (1u << (corner & straddled))) == 0u || weight == 0.0 {
            continue;
        }
        for (var t = first_term; t < end_term; t++) {
            let base = flb_terms[t].base;
            let factor = flb_factor(t, near_from, near) * weight;
            for (var c = 0u; c < flb_bases[base].components; c++) {
                let integer = flb_coarse_texel(flb_bases[base].coarse, edge, c, texel + upper);
                light += (factor * f32(integer)) * flb_bases[base].colors[c].xyz;
            }
        }
    }
    return light;
}

// The integer of a texel in a block that is not stored, between coarse averages.
fn flb_coarse_texel(coarse: u32, edge: u32, component: u32, texel: vec3<u32>) -> i32 {
    let last = i32(edge) - 1;
    let place = clamp(2 * vec3<i32>(texel) - 15, vec3<i32>(0), vec3<i32>(last * 32));
    let part = place & vec3<i32>(31);
    var sum = 0;
    for (var corner = 0u; corner < 8u; corner++) {
        let upper = vec3<i32>((vec3<u32>(corner) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u));
        let weights = select(32 - part, part, upper == vec3<i32>(1));
        let at = min((place >> vec3<u32>(5u)) + upper, vec3<i32>(last));
        let index = component * edge * edge * edge + flb_morton(vec3<u32>(at));
        sum += weights.x * weights.y * weights.z * flb_coarse_average(coarse, index);
    }
    return (sum >> 11u) * FLB_COARSE;
}

fn flb_coarse_average(coarse: u32, index: u32) -> i32 {
    return bitcast<i32>(flb_words[coarse + (index >> 1u)] << (16u - 16u * (index & 1u))) >> 16u;
}

// The integer of a texel of a stored block, exact; `local` is its place in the block.
fn flb_texel(species: u32, base: u32, rank: u32, component: u32, local: vec3<u32>) -> i32 {
    let haar = flb_species[species].haar != 0u;
    let x = vec4<i32>(flb_column(haar, local.x));
    let y = vec4<i32>(flb_column(haar, local.y));
    let z = vec4<i32>(flb_column(haar, local.z));
    let components = flb_bases[base].components;
    var record = flb_bases[base].records + rank * (1u + components);
    var integer = 0;
    loop {
        let head = flb_words[record];
        var at = head & (FLB_WIDE - 1u);
        for (var c = 0u; c < components; c++) {
            let word = flb_words[record + 1u + c];
            if c == component {
                integer += (bitcast<i32>(word << 16u) >> 16u) * (FLB_AVERAGE * x.x * y.x * z.x);
                integer += flb_integers(at, word >> 16u, x, y, z) * (1 << (head >> FLB_SHIFT));
            }
            at += countOneBits(word >> 16u);
        }
        if (head & FLB_WIDE) == 0u {
            break;
        }
        record = at;
    }
    return integer;
}

// Sum of the words of a mask times integer weights.
fn flb_integers(first: u32, words: u32, x: vec4<i32>, y: vec4<i32>, z: vec4<i32>) -> i32 {
    var at = first;
    var sum = 0;
    for (var mask = words; mask != 0u; mask &= mask - 1u) {
        let bit = firstTrailingBit(mask);
        let plane = 1 << (4u * (bit >> 3u));
        for (var lane = 0u; lane < 8u; lane++) {
            let digit = bitcast<i32>(flb_words[at] << (28u - 4u * lane)) >> 28u;
            sum += digit * plane * x[lane & 3u] * y[(bit & 1u) * 2u + (lane >> 2u)] * z[(bit >> 1u) & 3u];
        }
        at++;
    }
    return sum;
}
