// The first scattering of beams along an axis: what each site scatters of them by its phase functions -> what each
// segment adds to its site. Twin: first.rs. An invocation takes a ray there and back, for one sun.

struct Slant {
    // Optical depth of the segment.
    depth: f32,
    // Site edges.
    length: f32,
    // Middle of the segment from the mean place of the axis's segments of the site: three signed bytes.
    offset: u32,
}

@group(0) @binding(2) var<storage, read> segments: array<Segment>;
@group(0) @binding(3) var<storage, read> starts: array<u32>;
@group(0) @binding(4) var<storage, read> slants: array<Slant>;
// [site][mean, slope along x, y, z][lane]: light of the beams.
@group(0) @binding(5) var<storage, read> lights: array<f32>;
// [site][leaf, wood]: albedo x share of the site's extinction.
@group(0) @binding(6) var<storage, read> albedos: array<vec2<f32>>;
// [axis][way][leaf, wood][lane]: what matter of albedo 1 scatters of the beam into the direction.
@group(0) @binding(7) var<storage, read> turned: array<f32>;
// [slot][parity][lane]: the sum of both ways, and the difference.
@group(0) @binding(8) var<storage, read_write> slots: array<f32>;

@compute @workgroup_size(64)
fn first(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= axis.rays * params.lanes {
        return;
    }
    let ray = at / params.lanes;
    let lane = at % params.lanes;
    let start = starts[ray];
    let end = starts[ray + 1u];
    let there = turned_by(0u, lane);
    let back = turned_by(1u, lane);
    var light = 0.0;
    for (var i = start; i < end; i++) {
        let crossed = cross_site(i, 1.0, there, lane, light);
        light = crossed.x;
        slots[at_slot(segments[i].slot, 0u, lane)] = crossed.y;
        if params.parities == 2u {
            slots[at_slot(segments[i].slot, 1u, lane)] = crossed.y;
        }
    }
    light = 0.0;
    for (var i = end; i > start; i--) {
        let crossed = cross_site(i - 1u, -1.0, back, lane, light);
        light = crossed.x;
        slots[at_slot(segments[i - 1u].slot, 0u, lane)] += crossed.y;
        if params.parities == 2u {
            slots[at_slot(segments[i - 1u].slot, 1u, lane)] -= crossed.y;
        }
    }
}

fn turned_by(way: u32, lane: u32) -> vec2<f32> {
    let at = (axis.index * 2u + way) * 2u * params.lanes + lane;
    return vec2(turned[at], turned[at + params.lanes]);
}

// The light that leaves segment `i`, and what the segment adds to the mean of its site over all directions.
fn cross_site(i: u32, way: f32, turned: vec2<f32>, lane: u32, arrives: f32) -> vec2<f32> {
    let segment = segments[i];
    let slant = slants[i];
    let gone = 1.0 - segment.transmittance;
    let s = slant.depth;
    // Light that rises by 1 along the segment, 0 in the middle: what leaves of it, and what stays.
    var mean = gone / s;
    var leaves = 1.0 - mean - 0.5 * gone;
    var stays = -leaves / s;
    // Series where the closed forms cancel.
    if s < 0.03 {
        mean = 1.0 - 0.5 * s;
        stays = -s / 12.0 * mean;
        leaves = -stays * s;
    }
    let at = segment.place * 4u * params.lanes + lane;
    let slope = vec3(lights[at + params.lanes], lights[at + 2u * params.lanes], lights[at + 3u * params.lanes]);
    let share = dot(albedos[segment.place], turned);
    let aside = share * dot(unpack4x8snorm(slant.offset).xyz, slope);
    let along = share * way * slant.length * dot(axis.direction, slope);
    let source = share * lights[at] + aside;
    let beyond = arrives - source;
    let light = source + segment.transmittance * beyond + leaves * along;
    let weight = segment.adds / mean;
    return vec2(light, segment.adds * beyond + weight * (source + stays * along));
}
