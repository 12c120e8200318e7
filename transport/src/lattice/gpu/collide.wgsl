// One iteration: the light that the links bring to a site -> the light that it sends. Twins: `Gain::collide` in
// kernel.rs, same order of operations, and twin.rs around it.
//
// Written out pair by pair, without loops or arrays indexed at run time: those would live in memory, not in registers.

// Who this invocation is.
var<private> index: u32;
var<private> lane: u32;
var<private> site: Site;
var<private> gain: Gain;

// Light of a pair of opposite directions, 2 p and 2 p + 1.
struct Pair {
    even: f32,
    odd: f32,
    // What the site throws back at once, along each, of what its partner in echo sends.
    returned: vec2<f32>,
}

@compute @workgroup_size(64)
fn collide(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = invocation(workgroup, workgroups, local);
    if at >= params.sites * params.picks {
        return;
    }
    index = at / params.picks;
    lane = picks[at % params.picks];
    site = sites[index];
    gain = gains[site.wood * params.lanes + lane];
    // Halves, because f_m = (even + odd) / 2.
    let scattered = 0.5 * site.density;
    let straight = 0.5 * (1.0 - site.density);

    let x = pair(0u);
    let y = pair(1u);
    let z = pair(2u);
    let xy = pair(3u);
    let x_y = pair(4u);
    let xz = pair(5u);
    let x_z = pair(6u);
    let yz = pair(7u);
    let y_z = pair(8u);

    // plane.a: the two diagonal pairs perpendicular to axis a.
    let axis = vec3(x.even, y.even, z.even);
    let plane = vec3(yz.even + y_z.even, xz.even + x_z.even, xy.even + x_y.even);
    let axes = axis.x + axis.y + axis.z;
    let diagonals = plane.x + plane.y + plane.z;
    let to_axis = gain.even_axis_axis * axes + gain.even_axis_diagonal * diagonals;
    let to_diagonal = gain.even_diagonal_axis * axes + gain.even_diagonal_diagonal * diagonals;
    let axis_even = straight * axis
        + scattered * (to_axis + (gain.even_axis_axis_excess * axis + gain.even_axis_plane_excess * plane));
    let to_plane =
        to_diagonal + (gain.even_diagonal_plane_excess * plane + gain.even_diagonal_axis_excess * axis);

    let difference = vec3(x.odd, y.odd, z.odd);
    // along.a: flux of the diagonals along axis a.
    let along = vec3(
        (xy.odd + x_y.odd) + (xz.odd + x_z.odd),
        (xy.odd - x_y.odd) + (yz.odd + y_z.odd),
        (xz.odd - x_z.odd) + (yz.odd - y_z.odd),
    );
    let axis_odd =
        straight * difference + scattered * (gain.odd_axis_self * difference + gain.odd_axis_diagonal * along);
    let drift = gain.odd_diagonal_diagonal * along + gain.odd_diagonal_axis * difference;

    send(0u, x, axis_even.x, axis_odd.x);
    send(1u, y, axis_even.y, axis_odd.y);
    send(2u, z, axis_even.z, axis_odd.z);
    send_diagonal(3u, xy, to_plane.z, drift.x + drift.y);
    send_diagonal(4u, x_y, to_plane.z, drift.x - drift.y);
    send_diagonal(5u, xz, to_plane.y, drift.x + drift.z);
    send_diagonal(6u, x_z, to_plane.y, drift.x - drift.z);
    send_diagonal(7u, yz, to_plane.x, drift.y + drift.z);
    send_diagonal(8u, y_z, to_plane.x, drift.y - drift.z);

    let place = index * params.lanes + lane;
    let light = axes + diagonals;
    phi[place] = vec2(light, light - phi[place].x);
}

fn pair(p: u32) -> Pair {
    let up = arriving(2u * p);
    let down = arriving(2u * p + 1u);
    // What arrives one way is thrown back the other way.
    return Pair(up.x + down.x, up.x - down.x, vec2(down.y, up.y));
}

// The light that arrives along m, and how much of it the site throws back into an echo that is summed.
fn arriving(m: u32) -> vec2<f32> {
    let link = links[index * MOVING + m];
    let light = before[link * params.lanes + lane];
    // Opposites are neighbours: what leaves along m ^ 1 meets the partner whose light arrives along m.
    let leaving = m ^ 1u;
    if (site.echoes >> leaving & 1u) == 0u {
        return vec2(light, 0.0);
    }
    let share = back(gain, m);
    let here = site.density * share;
    let there = sites[link / MOVING].density * share;
    let lost = 1.0 - here * there;
    if lost < MIN_LOSS {
        return vec2(light, 0.0);
    }
    let own = before[(index * MOVING + leaving) * params.lanes + lane];
    let settled = (light + there * own) / lost;
    return vec2(settled, here * settled);
}

fn send_diagonal(p: u32, pair: Pair, to_plane: f32, drift: f32) {
    let scattered = 0.5 * site.density;
    let straight = 0.5 * (1.0 - site.density);
    let even = straight * pair.even + scattered * (to_plane + gain.even_diagonal_self_excess * pair.even);
    let odd = straight * pair.odd + scattered * (gain.odd_diagonal_self_excess * pair.odd + drift);
    send(p, pair, even, odd);
}

fn send(p: u32, pair: Pair, even: f32, odd: f32) {
    let row = index * MOVING + 2u * p;
    after[row * params.lanes + lane] = even + odd - pair.returned.x;
    after[(row + 1u) * params.lanes + lane] = even - odd - pair.returned.y;
}
