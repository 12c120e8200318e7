// What arrived in a pass -> the step to the next light, (x_1 + K W x - x) / (1 - W (1 - escape)). Twin: `become_step`
// in source_iteration.rs.

// [site]
@group(0) @binding(2) var<storage, read> matter: array<Matter>;
// [site][moment][lane], as those below: light scattered once, light that is sent out, all light.
@group(0) @binding(3) var<storage, read> first: array<f32>;
@group(0) @binding(4) var<storage, read> source: array<f32>;
@group(0) @binding(5) var<storage, read> light: array<f32>;
// What arrived beyond what is sent out; becomes the step.
@group(0) @binding(6) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn step_to(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= params.sites * params.lanes {
        return;
    }
    let site = at / params.lanes;
    let of_site = matter[site];
    let stays = 1.0 - of_site.escape;
    for (var a = 0u; a < params.moments; a++) {
        let place = at_moment(site, a, at % params.lanes);
        let gain = gain_of(of_site, a);
        let whole = 1.0 / (1.0 - gain * stays);
        sums[place] = whole * (first[place] + (source[place] + sums[place]) - light[place]);
    }
}
