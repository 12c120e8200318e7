// What the segments of an axis added -> the sums of each site, segment by segment in the order of the axis. An
// invocation serves one site in one lane, so that no two write the same number.

// First slot of each site, and the end.
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
// [slot][parity][lane]
@group(0) @binding(3) var<storage, read> slots: array<f32>;
// [site][moment][lane]
@group(0) @binding(4) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn gather(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= params.sites * params.lanes {
        return;
    }
    let site = at / params.lanes;
    let lane = at % params.lanes;
    var added = vec2(0.0);
    for (var slot = offsets[site]; slot < offsets[site + 1u]; slot++) {
        added.x += slots[at_slot(slot, 0u, lane)];
        if params.parities == 2u {
            added.y += slots[at_slot(slot, 1u, lane)];
        }
    }
    for (var a = 0u; a < params.moments; a++) {
        sums[at_moment(site, a, lane)] += moment(a) * select(added.x, added.y, is_odd(a));
    }
}
