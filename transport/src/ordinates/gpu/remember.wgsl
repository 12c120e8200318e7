// Light and step of this pass and of the one before -> how they changed. Those of this pass are kept for the next one.

// [site][moment][lane], all.
@group(0) @binding(2) var<storage, read> light: array<f32>;
@group(0) @binding(3) var<storage, read> steps: array<f32>;
@group(0) @binding(4) var<storage, read_write> light_before: array<f32>;
@group(0) @binding(5) var<storage, read_write> step_before: array<f32>;
@group(0) @binding(6) var<storage, read_write> light_change: array<f32>;
@group(0) @binding(7) var<storage, read_write> step_change: array<f32>;

@compute @workgroup_size(64)
fn remember(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= params.sites * params.moments * params.lanes {
        return;
    }
    light_change[at] = light[at] - light_before[at];
    step_change[at] = steps[at] - step_before[at];
    light_before[at] = light[at];
    step_before[at] = steps[at];
}
