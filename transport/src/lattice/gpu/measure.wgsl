// How far an iteration moved phi: sums over runs of sites, in their order. The host adds the runs up.

@compute @workgroup_size(64)
fn measure(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= PARTS * params.picks {
        return;
    }
    let lane = picks[at % params.picks];
    let run = (params.sites + PARTS - 1u) / PARTS;
    let start = at / params.picks * run;
    let end = min(start + run, params.sites);
    var sum = vec2(0.0);
    for (var site = start; site < end; site++) {
        let light = phi[site * params.lanes + lane];
        sum += vec2(light.y * light.y, light.x * light.x);
    }
    sums[params.slot * PARTS * params.picks + at] = sum;
}
