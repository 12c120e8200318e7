// Light, step and the last two changes of the step -> their products, over runs of sites, in their order. The host adds
// the runs up.

struct Sums {
    // Squares of the step and of the light, of moment 0.
    step: f32,
    light: f32,
    // Products of the changes, and of each with the step, over all moments.
    a_a: f32,
    a_b: f32,
    b_b: f32,
    a_step: f32,
    b_step: f32,
    unused: f32,
}

// [site][moment][lane]
@group(0) @binding(2) var<storage, read> light: array<f32>;
@group(0) @binding(3) var<storage, read> steps: array<f32>;
@group(0) @binding(4) var<storage, read> a: array<f32>;
@group(0) @binding(5) var<storage, read> b: array<f32>;
// [part][lane]
@group(0) @binding(6) var<storage, read_write> parts: array<Sums>;

@compute @workgroup_size(64)
fn measure(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= PARTS * params.lanes {
        return;
    }
    let lane = at % params.lanes;
    let run = (params.sites + PARTS - 1u) / PARTS;
    let start = at / params.lanes * run;
    let end = min(start + run, params.sites);
    var sums = Sums();
    for (var site = start; site < end; site++) {
        let fluence = at_moment(site, 0u, lane);
        sums.step += steps[fluence] * steps[fluence];
        sums.light += light[fluence] * light[fluence];
        for (var m = 0u; m < params.moments; m++) {
            let place = at_moment(site, m, lane);
            sums.a_a += a[place] * a[place];
            sums.a_b += a[place] * b[place];
            sums.b_b += b[place] * b[place];
            sums.a_step += a[place] * steps[place];
            sums.b_step += b[place] * steps[place];
        }
    }
    parts[at] = sums;
}
