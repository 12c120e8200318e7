// Light at the sites -> what they send out of it, W x. Nothing has arrived yet.

// [site]
@group(0) @binding(2) var<storage, read> matter: array<Matter>;
// [site][moment][lane], as those below.
@group(0) @binding(3) var<storage, read> light: array<f32>;
@group(0) @binding(4) var<storage, read_write> source: array<f32>;
@group(0) @binding(5) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn send(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= params.sites * params.lanes {
        return;
    }
    let site = at / params.lanes;
    for (var a = 0u; a < params.moments; a++) {
        let place = at_moment(site, a, at % params.lanes);
        let gain = gain_of(matter[site], a);
        source[place] = gain * light[place];
        sums[place] = 0.0;
    }
    if params.moments == 9u {
        // Twin: `up_moment` in moments.rs.
        let along_z = light[at_moment(site, 6u, at % params.lanes)];
        let across_z = light[at_moment(site, 8u, at % params.lanes)];
        let place = at_moment(site, 0u, at % params.lanes);
        source[place] += matter[site].leaning * (-0.5 * along_z - 0.8660254 * across_z);
    }
}
