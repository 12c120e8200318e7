// Takes the light at each point of a list; `light_at` is one of the ways.

struct Ask { species: u32, lattice: u32, count: u32, unused: u32 }
@group(0) @binding(0) var<uniform> ask: Ask;
// w: the bits of the first term of the point's instance.
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> found: array<vec4<f32>>;

@compute @workgroup_size(64)
fn sweep(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < ask.count {
        let point = points[at.x];
        found[at.x] = vec4<f32>(light_at(bitcast<u32>(point.w), point.xyz), 1.0);
    }
}
