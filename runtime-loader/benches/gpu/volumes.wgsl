// Uncoded fields: [base][z][y][x][band] of f32 in a storage buffer.

@group(1) @binding(0) var<storage, read> volumes: array<f32>;

fn texel_at(at: u32) -> vec3<f32> {
    return vec3<f32>(volumes[at], volumes[at + 1u], volumes[at + 2u]);
}

fn light_at(first_term: u32, point: vec3<f32>) -> vec3<f32> {
    let place = flb_locate(ask.species, point);
    let n = ask.lattice;
    let first = ((place.texel.z * n + place.texel.y) * n + place.texel.x) * 3u;
    let p = place.part;
    let q = vec3<f32>(1.0) - p;
    var light = vec3<f32>(0.0);
    for (var t = first_term; t < first_term + 4u; t++) {
        let term = flb_terms[t];
        let at = term.base * n * n * n * 3u + first;
        let row = 3u * n;
        let plane = row * n;
        let a = texel_at(at) * q.x + texel_at(at + 3u) * p.x;
        let b = texel_at(at + row) * q.x + texel_at(at + row + 3u) * p.x;
        let c = texel_at(at + plane) * q.x + texel_at(at + plane + 3u) * p.x;
        let d = texel_at(at + plane + row) * q.x + texel_at(at + plane + row + 3u) * p.x;
        light += ((a * q.y + b * p.y) * q.z + (c * q.y + d * p.y) * p.z) * term.factor;
    }
    return light;
}
