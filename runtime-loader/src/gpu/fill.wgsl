// Decodes a blend into an atlas (atlas.wgsl says how bricks lie); stands behind light.wgsl. A workgroup is a brick, an
// invocation one of its texels.

struct Fill {
    species: u32,
    first_term: u32,
    term_count: u32,
    // Bricks along an axis of the atlas.
    across: u32,
    // All of them, coarse ones included.
    bricks: u32,
    // Number of the first coarse brick.
    coarse: u32,
    coarse_bricks: u32,
    unused: u32,
}

const BRICK: u32 = 5u;
// Workgroups along x.
const WORKGROUPS: u32 = 32768u;

@group(0) @binding(0) var<uniform> fill: Fill;
// [brick]: Morton code of its block.
@group(0) @binding(1) var<storage, read> codes: array<u32>;
@group(0) @binding(2) var atlas: texture_storage_3d<rgba16float, write>;

@compute @workgroup_size(128)
fn decode(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) texel: u32) {
    let brick = group.y * WORKGROUPS + group.x;
    if brick >= fill.bricks || texel >= BRICK * BRICK * BRICK {
        return;
    }
    let local = vec3<u32>(texel % BRICK, texel / BRICK % BRICK, texel / (BRICK * BRICK));
    var light: vec3<f32>;
    if brick < fill.coarse {
        let block = vec3<u32>(gathered(codes[brick]), gathered(codes[brick] >> 1u), gathered(codes[brick] >> 2u));
        light = light_of(block * 4u + local);
    } else {
        let n = brick - fill.coarse;
        let b = fill.coarse_bricks;
        light = coarse_of(vec3<u32>(n % b, n / b % b, n / (b * b)) * 4u + local);
    }
    let corner = BRICK * vec3<u32>(brick % fill.across, brick / fill.across % fill.across, brick / (fill.across * fill.across));
    textureStore(atlas, corner + local, vec4<f32>(light, 1.0));
}

// Light of a texel; beyond the last one that of the last.
fn light_of(texel: vec3<u32>) -> vec3<f32> {
    let last = flb_species[fill.species].lattice - 1u;
    let at = min(texel, vec3<u32>(last));
    // The last texel is the upper one of its sample.
    let lower = min(at, vec3<u32>(last - 1u));
    return flb_light(fill.species, fill.first_term, fill.term_count, lower, vec3<f32>(at - lower));
}

// Light of a coarse average; beyond the last one that of the last.
fn coarse_of(at: vec3<u32>) -> vec3<f32> {
    let edge = flb_species[fill.species].coarse_edge;
    let code = flb_morton(min(at, vec3<u32>(edge - 1u)));
    var light = vec3<f32>(0.0);
    for (var t = fill.first_term; t < fill.first_term + min(fill.term_count, FLB_TERMS); t++) {
        let base = flb_terms[t].base;
        for (var c = 0u; c < flb_bases[base].components; c++) {
            let average = flb_coarse_average(flb_bases[base].coarse, c * edge * edge * edge + code);
            light += (flb_terms[t].factor * f32(16 * FLB_COARSE * average)) * flb_bases[base].colors[c].xyz;
        }
    }
    return light;
}

// Every third bit of a Morton code.
fn gathered(code: u32) -> u32 {
    var v = code & 0x09249249u;
    v = (v | (v >> 2u)) & 0x030c30c3u;
    v = (v | (v >> 4u)) & 0x0300f00fu;
    v = (v | (v >> 8u)) & 0x030000ffu;
    return (v | (v >> 16u)) & 0x3ffu;
}
