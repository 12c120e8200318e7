// Adds to every row in echo what the echo adds to it: with u = p + a v and v = q + b u, u = (p + a q) / (1 - a b).
// Each pair of rows is served once, by the site of the lower index.

@compute @workgroup_size(64)
fn settle(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= params.sites * params.picks {
        return;
    }
    let index = at / params.picks;
    let lane = picks[at % params.picks];
    let site = sites[index];
    let gain = gains[site.wood * params.lanes + lane];
    for (var m = 0u; m < MOVING; m++) {
        let link = links[index * MOVING + (m ^ 1u)];
        let partner = link / MOVING;
        if (site.echoes >> m & 1u) == 0u || partner < index {
            continue;
        }
        let share = back(gain, m);
        let here = site.density * share;
        let there = sites[partner].density * share;
        let lost = 1.0 - here * there;
        if lost >= MIN_LOSS {
            let own = (index * MOVING + m) * params.lanes + lane;
            let other = link * params.lanes + lane;
            let p = after[own];
            let q = after[other];
            after[own] = (p + here * q) / lost;
            after[other] = (q + there * p) / lost;
        }
    }
}
