// The mean of a pixel's samples, not below 0. A workgroup serves a square.

// [y][x], linear; w is 1.
@group(1) @binding(0) var<storage, read_write> picture: array<vec4<f32>>;

@compute @workgroup_size(WORKGROUP)
fn resolve(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let square = strip.first + workgroup.x;
    let corner = vec2<u32>(square % strip.columns, strip.top + square / strip.columns) * EDGE;
    let pixel = corner + vec2<u32>(local % EDGE, local / EDGE);
    if pixel.x >= view.size.x || pixel.y >= view.size.y {
        return;
    }
    var sum = vec3<f32>(0.0);
    for (var sample = 0u; sample < view.samples; sample++) {
        sum += lit[(square * view.samples + sample) * WORKGROUP + local].color;
    }
    let mean = max(sum / f32(view.samples), vec3<f32>(0.0));
    picture[pixel.y * view.size.x + pixel.x] = vec4<f32>(mean, 1.0);
}
