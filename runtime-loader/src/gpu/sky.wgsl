// The light of an uneven sky on a plant, in place of an even one: light/sky.rs and light/sky/beams.rs in WGSL, in the
// same order but for rounding.
//
//   let light = flb_sky(species, first_term, point_model_m, facing);
//
// Words of a species' beams: how many words of masks its extinction has; then for each site with matter, in the order
// of the extinction, and for each mean (the beam itself, then those of the near beam) 16 binary16, its harmonics.
//
// Terms of the sky over a plant: the number of bases of the sun (low 16 bits) and of near ones; the base of the even
// sky, those of the sun and the near ones, each once; then rows of four reals, two terms a row:
//   fluence of the sky (r, g, b, 0)
//   of each base of the sun: its factor under the even sky, and beyond that under the sky (r, g, b)
//   where no matter is near: four means of the near beam; light of the even sky and of the sky (r, g, b), and that
//   times its direction: x, y, z; what the even sky (1) and the sky (r, g, b) give each of the means
//   [4 harmonics at a time][light, and times its direction x, y, z, and as often as its near beam counts][even, r, g,
//   b]: factors of harmonics

// What the sky brings to a point: of the even sky, and of the sky (r, g, b).
struct FlbSkySite {
    // The beam itself.
    light: vec4<f32>,
    // Means of the near beam, as often as they count.
    near_0: vec4<f32>,
    near_1: vec4<f32>,
    near_2: vec4<f32>,
    near_3: vec4<f32>,
    // Light times the direction it comes from.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
}

// Rows where no matter is near.
const FLB_SKY_OPEN: u32 = 6u;
// Words of a mean's harmonics.
const FLB_SKY_WORDS: u32 = 8u;
// Least part of the beams around that is taken to fall on a solid.
const FLB_SKY_LEAST: f32 = 0.02;

// Light per band of the sky whose terms begin there, at a point of the model, as it falls on a leaf, or on a solid that
// faces some way (a unit vector; 0 for a leaf).
fn flb_sky(species: u32, first_term: u32, point_model_m: vec3<f32>, facing: vec3<f32>) -> vec3<f32> {
    let counts = flb_terms[first_term].base;
    let of_sun = counts & 0xffffu;
    let of_near = counts >> 16u;
    let bases = first_term + 1u;
    let rows = bases + 1u + of_sun + of_near;
    let place = flb_locate(species, point_model_m);
    let blocks = flb_blocks(species, place.texel, place.part);
    let fluence = flb_sky_row(rows, 0u).xyz;
    let site = flb_sky_at(species, rows, 1u + of_sun, place);
    let stored = flb_sky_base(species, bases, blocks, place);
    var scattered = vec3<f32>(0.0);
    var beyond = vec3<f32>(0.0);
    for (var i = 0u; i < of_sun; i++) {
        let light = flb_sky_base(species, bases + 1u + i, blocks, place);
        let factors = flb_sky_row(rows, 1u + i);
        scattered += factors.x * light;
        beyond += factors.yzw * light;
    }
    for (var j = 0u; j < of_near; j++) {
        let light = flb_sky_base(species, bases + 1u + of_sun + j, blocks, place);
        let near = select(select(site.near_0, site.near_1, j == 1u), select(site.near_2, site.near_3, j == 3u), j >= 2u);
        scattered += near.x * light;
        beyond += (near.yzw - fluence * near.x) * light;
    }
    let direct = clamp(stored - scattered, vec3<f32>(0.0), max(stored, vec3<f32>(0.0)));
    let light = fluence * stored + beyond + direct * (flb_sky_share(site, facing) - fluence);
    return max(light, vec3<f32>(0.0));
}

fn flb_sky_row(rows: u32, row: u32) -> vec4<f32> {
    let first = flb_terms[rows + 2u * row];
    let second = flb_terms[rows + 2u * row + 1u];
    return vec4<f32>(bitcast<f32>(first.base), first.factor, bitcast<f32>(second.base), second.factor);
}

// A base at a place.
fn flb_sky_base(species: u32, term: u32, blocks: FlbBlocks, place: FlbPlace) -> vec3<f32> {
    var light = flb_of_base(flb_terms[term].base, blocks, 1.0);
    if blocks.missing != 0u {
        light += flb_coarse_light(
            species,
            term,
            term + 1u,
            place.texel,
            place.part,
            blocks.straddled,
            blocks.missing,
            FLB_NONE,
            vec4<f32>(1.0),
        );
    }
    return light;
}

// What comes from the sky itself, relative to an even one of fluence 1: a mean over where the site sees it; of a solid
// by the cosine, to the first order of directions.
fn flb_sky_share(site: FlbSkySite, facing: vec3<f32>) -> vec3<f32> {
    let along = facing.x * site.x + facing.y * site.y + facing.z * site.z;
    let on_solid = max(site.light / 4.0 + along / 2.0, site.light * FLB_SKY_LEAST);
    let on = select(on_solid, site.light, all(facing == vec3<f32>(0.0)));
    return select(vec3<f32>(0.0), max(on.yzw / max(on.x, 1e-30), vec3<f32>(0.0)), on.x > 0.0);
}

// Means over those of the eight sites around a place that hold matter, by their trilinear weights.
fn flb_sky_at(species: u32, rows: u32, open: u32, place: FlbPlace) -> FlbSkySite {
    let means = flb_species[species].sky_means;
    let first = flb_species[species].sky + 1u;
    var site: FlbSkySite;
    var weights = 0.0;
    for (var quarter = 0u; quarter < 4u; quarter++) {
        var own = vec4<f32>(0.0);
        var second = vec4<f32>(0.0);
        var third = vec4<f32>(0.0);
        var fourth = vec4<f32>(0.0);
        for (var corner = 0u; corner < 8u; corner++) {
            let upper = (vec3<u32>(corner) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
            let along = select(vec3<f32>(1.0) - place.part, place.part, upper == vec3<u32>(1u));
            let weight = along.x * along.y * along.z;
            let number = flb_sky_site(species, place.texel + upper);
            if number == FLB_NONE || weight == 0.0 {
                continue;
            }
            let word = first + number * means * FLB_SKY_WORDS + 2u * quarter;
            own += weight * flb_sky_harmonics(word);
            if means > 1u {
                second += weight * flb_sky_harmonics(word + FLB_SKY_WORDS);
                third += weight * flb_sky_harmonics(word + 2u * FLB_SKY_WORDS);
            }
            if means > 3u {
                fourth += weight * flb_sky_harmonics(word + 3u * FLB_SKY_WORDS);
            }
            weights += select(0.0, weight, quarter == 0u);
        }
        let row = open + FLB_SKY_OPEN + 20u * quarter;
        site.light += flb_sky_sums(rows, row, own);
        site.near_0 += flb_sky_sums(rows, row + 16u, own);
        site.near_1 += flb_sky_sums(rows, row + 16u, second);
        site.near_2 += flb_sky_sums(rows, row + 16u, third);
        site.near_3 += flb_sky_sums(rows, row + 16u, fourth);
        site.x += flb_sky_sums(rows, row + 4u, own);
        site.y += flb_sky_sums(rows, row + 8u, own);
        site.z += flb_sky_sums(rows, row + 12u, own);
    }
    if weights > 0.0 {
        return FlbSkySite(
            site.light / weights,
            site.near_0 / weights,
            site.near_1 / weights,
            site.near_2 / weights,
            site.near_3 / weights,
            site.x / weights,
            site.y / weights,
            site.z / weights,
        );
    }
    // No matter is near: every beam is whole.
    let near = flb_sky_row(rows, open);
    let of_near = flb_sky_row(rows, open + 5u);
    return FlbSkySite(
        flb_sky_row(rows, open + 1u),
        near.x * of_near,
        near.y * of_near,
        near.z * of_near,
        near.w * of_near,
        flb_sky_row(rows, open + 2u),
        flb_sky_row(rows, open + 3u),
        flb_sky_row(rows, open + 4u),
    );
}

// Number of a site among those with matter, or FLB_NONE.
fn flb_sky_site(species: u32, site: vec3<u32>) -> u32 {
    if flb_species[species].sky == FLB_NONE {
        return FLB_NONE;
    }
    let rank = flb_rank(flb_species[species].extinction, site >> vec3<u32>(2u));
    if rank == FLB_NONE {
        return FLB_NONE;
    }
    let local = site & vec3<u32>(3u);
    let pair = flb_species[species].extinction + flb_map_words(species) + FLB_RELATIVE + 4u * rank + (local.z & 2u);
    let bits = flb_words[pair];
    let bit = 1u << (((local.z & 1u) * 4u + local.y) * 4u + local.x);
    let number = flb_words[pair + 1u] - flb_words[flb_species[species].sky] + countOneBits(bits & (bit - 1u));
    return select(FLB_NONE, number, (bits & bit) != 0u);
}

fn flb_sky_harmonics(word: u32) -> vec4<f32> {
    return vec4<f32>(unpack2x16float(flb_words[word]), unpack2x16float(flb_words[word + 1u]));
}

fn flb_sky_sums(rows: u32, row: u32, harmonics: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(
        dot(harmonics, flb_sky_row(rows, row)),
        dot(harmonics, flb_sky_row(rows, row + 1u)),
        dot(harmonics, flb_sky_row(rows, row + 2u)),
        dot(harmonics, flb_sky_row(rows, row + 3u)),
    );
}
