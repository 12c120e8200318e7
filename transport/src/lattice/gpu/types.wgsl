// What the stages share: the types and the one bind group. It stands before each stage's own file.
//
// A lane is one base in one band; lanes lie side by side, lane fastest. Picks are the lanes at work.
// An invocation serves one pick at one site.

struct Params {
    sites: u32,
    lanes: u32,
    picks: u32,
    // Part of `sums` that `measure` writes.
    slot: u32,
}

struct Site {
    density: f32,
    // 0: leaf, 1: wood.
    wood: u32,
    // Bit m: this is wood, and what it sends along m goes first to wood, with which it is in echo.
    echoes: u32,
}

// One class in one lane, as kernel.rs splits the matrix; `back` is what goes straight back at density 1.
struct Gain {
    even_axis_axis: f32,
    even_axis_axis_excess: f32,
    even_axis_diagonal: f32,
    even_axis_plane_excess: f32,
    even_diagonal_axis: f32,
    even_diagonal_axis_excess: f32,
    even_diagonal_diagonal: f32,
    even_diagonal_plane_excess: f32,
    even_diagonal_self_excess: f32,
    odd_axis_self: f32,
    odd_axis_diagonal: f32,
    odd_diagonal_axis: f32,
    odd_diagonal_diagonal: f32,
    odd_diagonal_self_excess: f32,
    back_axis: f32,
    back_diagonal: f32,
}

const MOVING: u32 = 18u;
// Invocations of a workgroup.
const WORKGROUP: u32 = 64u;
// Runs of sites whose sums `measure` forms.
const PARTS: u32 = 1024u;
// Echoes that lose less than this per round are not summed; as in sweep.rs.
const MIN_LOSS: f32 = 1e-3;

@group(0) @binding(0) var<uniform> params: Params;
// [site][m]: row whose light arrives along m.
@group(0) @binding(1) var<storage, read> links: array<u32>;
@group(0) @binding(2) var<storage, read> sites: array<Site>;
// [wood][lane]
@group(0) @binding(3) var<storage, read> gains: array<Gain>;
@group(0) @binding(4) var<storage, read> picks: array<u32>;
// [row][lane]: outgoing light. Rows are [site][m], then 18 rows of boundary light. A row in echo holds the light
// without what the echo adds to it, until `settle` adds that.
@group(0) @binding(5) var<storage, read> before: array<f32>;
@group(0) @binding(6) var<storage, read_write> after: array<f32>;
// [site][lane]: phi, and how far it moved in the last iteration.
@group(0) @binding(7) var<storage, read_write> phi: array<vec2<f32>>;
// [slot][part][pick]: sums of the squares of moves and of phi.
@group(0) @binding(8) var<storage, read_write> sums: array<vec2<f32>>;

fn invocation(workgroup: vec3<u32>, workgroups: vec3<u32>, local: u32) -> u32 {
    return (workgroup.y * workgroups.x + workgroup.x) * WORKGROUP + local;
}

// Share that wood of density 1 sends straight back along m. The first six directions are axial.
fn back(gain: Gain, m: u32) -> f32 {
    return select(gain.back_diagonal, gain.back_axis, m < 6u);
}
