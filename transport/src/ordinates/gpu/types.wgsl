// What the stages share. It stands before each stage's own file, which binds its buffers from 2 on.
//
// A lane is a sun, a harmonic of the sun's direction, or the sky; lanes lie side by side, lane fastest.

struct Params {
    sites: u32,
    lanes: u32,
    // Moments of the light per site: 1, 4 or 9.
    moments: u32,
    // Numbers of a segment and lane: 1, or 2 where there are moments that are odd in the direction.
    parities: u32,
}

// The rays along an ordinate, for both ways.
struct Axis {
    direction: vec3<f32>,
    // Its place in the list.
    index: u32,
    rays: u32,
    // Moments of the direction, four by four.
    moments: array<vec4<f32>, 3>,
}

// What a site scatters.
struct Matter {
    // Of the moments of degree 0, 1 and 2.
    even: f32,
    first: f32,
    second: f32,
    // Share of its light that escapes it.
    escape: f32,
    // Of the second moment about the vertical, where its leaves lean: added to what is sent out evenly.
    leaning: f32,
}

// A ray crosses a site.
struct Segment {
    // Site, in the list of those with matter.
    place: u32,
    // Where the segment puts what it adds: slots of a site lie side by side, in the order of the axis.
    slot: u32,
    transmittance: f32,
    adds: f32,
}

// Invocations of a workgroup.
const WORKGROUP: u32 = 64u;
// Runs of sites whose sums `measure` forms.
const PARTS: u32 = 1024u;

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<uniform> axis: Axis;

fn invocation(workgroup: vec3<u32>, workgroups: vec3<u32>, local: u32) -> u32 {
    return (workgroup.y * workgroups.x + workgroup.x) * WORKGROUP + local;
}

// Moment `a` of the direction there. Back, those of degree 1 have the opposite sign.
fn moment(a: u32) -> f32 {
    return axis.moments[a / 4u][a % 4u];
}

fn is_odd(a: u32) -> bool {
    return a >= 1u && a <= 3u;
}

// What matter scatters of moment `a`.
fn gain_of(matter: Matter, a: u32) -> f32 {
    return select(select(matter.second, matter.first, is_odd(a)), matter.even, a == 0u);
}

// Where moment `a` of a site is, in a list [site][moment][lane].
fn at_moment(site: u32, a: u32, lane: u32) -> u32 {
    return (site * params.moments + a) * params.lanes + lane;
}

// Where a slot is, in a list [slot][parity][lane].
fn at_slot(slot: u32, parity: u32, lane: u32) -> u32 {
    return (slot * params.parities + parity) * params.lanes + lane;
}
