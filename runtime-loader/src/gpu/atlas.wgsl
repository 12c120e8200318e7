// Sampling an atlas: put this file behind light.wgsl. A brick holds 5^3 texels, those of a block and the first ones of
// the blocks above it, so that hardware filters inside one brick. Bricks lie in rows, then layers; behind those of
// stored blocks come bricks of 4^3 coarse averages, where the lattice has a coarse level.
//
//   @group(2) @binding(0)  texture  bricks
//   @group(2) @binding(1)  sampler  linear, clamped
//   @group(2) @binding(2)  uniform  the atlas

struct FlbAtlas {
    species: u32,
    // Bricks along an axis.
    across: u32,
    // Number of the first coarse brick.
    coarse: u32,
    // Bricks of a coarse level along an edge.
    coarse_bricks: u32,
}

const FLB_BRICK: u32 = 5u;

@group(2) @binding(0) var flb_bricks: texture_3d<f32>;
@group(2) @binding(1) var flb_linear: sampler;
@group(2) @binding(2) var<uniform> flb_atlas: FlbAtlas;

// Light at a point, of the terms that the atlas was made of: one filtered fetch. As flb_sample where the block of the
// lower texel is stored, so at every surface; elsewhere the coarse level.
fn flb_sample_atlas(point_model_m: vec3<f32>) -> vec3<f32> {
    let place = flb_locate(flb_atlas.species, point_model_m);
    let rank = flb_rank(flb_species[flb_atlas.species].map, place.texel >> vec3<u32>(2u));
    var brick = rank;
    var local = vec3<f32>(place.texel & vec3<u32>(3u)) + place.part;
    if rank == FLB_NONE {
        let last = f32(flb_species[flb_atlas.species].coarse_edge) - 1.0;
        let texel = vec3<f32>(place.texel) + place.part;
        let coarse = clamp((texel - 7.5) / 16.0, vec3<f32>(0.0), vec3<f32>(last));
        let block = min(vec3<u32>(coarse) >> vec3<u32>(2u), vec3<u32>(flb_atlas.coarse_bricks - 1u));
        local = coarse - vec3<f32>(block * 4u);
        brick = flb_atlas.coarse + (block.z * flb_atlas.coarse_bricks + block.y) * flb_atlas.coarse_bricks + block.x;
    }
    let size = vec3<f32>(textureDimensions(flb_bricks));
    let at = (vec3<f32>(flb_brick_corner(brick, flb_atlas.across)) + local + 0.5) / size;
    return textureSampleLevel(flb_bricks, flb_linear, at, 0.0).xyz;
}

// First texel of a brick.
fn flb_brick_corner(brick: u32, across: u32) -> vec3<u32> {
    return FLB_BRICK * vec3<u32>(brick % across, brick / across % across, brick / (across * across));
}
