// Light and step -> the light of the next pass, by the last two changes and their weights. Twin: `Mixing` in
// source_iteration.rs.

// [site][moment][lane]
@group(0) @binding(2) var<storage, read_write> light: array<f32>;
@group(0) @binding(3) var<storage, read> steps: array<f32>;
@group(0) @binding(4) var<storage, read> light_a: array<f32>;
@group(0) @binding(5) var<storage, read> step_a: array<f32>;
@group(0) @binding(6) var<storage, read> light_b: array<f32>;
@group(0) @binding(7) var<storage, read> step_b: array<f32>;
// [lane]: whether the lane is at work, and the weights of both changes.
@group(0) @binding(8) var<storage, read> weights: array<vec4<f32>>;

@compute @workgroup_size(64)
fn mix_light(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= params.sites * params.moments * params.lanes {
        return;
    }
    let of_lane = weights[at % params.lanes];
    if of_lane.x == 0.0 {
        return;
    }
    let changed = of_lane.y * (light_a[at] + step_a[at]) + of_lane.z * (light_b[at] + step_b[at]);
    light[at] = light[at] + steps[at] - changed;
}
