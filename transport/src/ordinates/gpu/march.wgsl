// One pass along an axis: what each site sends out -> what each segment adds to its site beyond that. Twin: `cross` in
// march.rs. An invocation takes a ray there and back, for one lane.

@group(0) @binding(2) var<storage, read> segments: array<Segment>;
// First segment of each ray, and the end.
@group(0) @binding(3) var<storage, read> starts: array<u32>;
// [site][moment][lane]: light that is sent out.
@group(0) @binding(4) var<storage, read> source: array<f32>;
// [slot][parity][lane]: the sum of both ways, and the difference.
@group(0) @binding(5) var<storage, read_write> slots: array<f32>;

@compute @workgroup_size(64)
fn march(
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
    var light = 0.0;
    for (var i = start; i < end; i++) {
        let segment = segments[i];
        let sent = sent_by(segment.place, lane);
        let q = sent.x + sent.y;
        let beyond = light - q;
        light = q + segment.transmittance * beyond;
        let adds = segment.adds * beyond;
        slots[at_slot(segment.slot, 0u, lane)] = adds;
        if params.parities == 2u {
            slots[at_slot(segment.slot, 1u, lane)] = adds;
        }
    }
    light = 0.0;
    for (var i = end; i > start; i--) {
        let segment = segments[i - 1u];
        let sent = sent_by(segment.place, lane);
        let q = sent.x - sent.y;
        let beyond = light - q;
        light = q + segment.transmittance * beyond;
        let adds = segment.adds * beyond;
        slots[at_slot(segment.slot, 0u, lane)] += adds;
        if params.parities == 2u {
            slots[at_slot(segment.slot, 1u, lane)] -= adds;
        }
    }
}

// What a site sends along the axis: the part that is the same both ways, and the part that changes its sign.
fn sent_by(place: u32, lane: u32) -> vec2<f32> {
    var sent = vec2(moment(0u) * source[at_moment(place, 0u, lane)], 0.0);
    for (var a = 1u; a < params.moments; a++) {
        let of_moment = moment(a) * source[at_moment(place, a, lane)];
        sent += select(vec2(of_moment, 0.0), vec2(0.0, of_moment), is_odd(a));
    }
    return sent;
}
