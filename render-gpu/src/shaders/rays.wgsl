// Rays to the triangles that they meet. A ray is taken into an instance's frame and starts where it enters the model's
// box. How triangles of a model are found is told by model_by_tree.wgsl or model_by_grid.wgsl, how instances are by
// stand_by_tree.wgsl, view_by_*.wgsl and sun_by_*.wgsl. The twin is forest/trace.rs of the CPU's renderer.

struct Box {
    min: vec3<f32>,
    // Of the two boxes in it, or of its items.
    first: u32,
    max: vec3<f32>,
    // Items; 0 for a box of boxes.
    count: u32,
}

struct Model {
    min: vec3<f32>,
    // First box of its tree, or first word of its grid.
    root: u32,
    max: vec3<f32>,
    // How far from a surface a ray starts.
    lift: f32,
}

struct Triangle {
    // Vertices.
    a: u32,
    b: u32,
    c: u32,
    // In its mesh.
    number: u32,
    // Index of its material, and TRIANGLE_CUT, TRIANGLE_FRONT or TRIANGLE_BACK.
    material: u32,
}

struct Vertex {
    point: vec3<f32>,
    u: f32,
    // 0 where the mesh has none.
    normal: vec3<f32>,
    v: f32,
}

struct Instance {
    // Rows of the rotation from world to model; w is its place, counted from the middle of the stand.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    // What the place's floats leave of it.
    place_low: vec3<f32>,
    scale: f32,
    species: u32,
    // In the scene.
    number: u32,
    unused: u32,
    unused_2: u32,
}

struct Material {
    tint: vec3<f32>,
    // CLASS_LEAF or another.
    kind: u32,
    // Of the `physical` shading: a colour, and what a surface of that colour reflects and lets through.
    unit: vec3<f32>,
    // First word of its image, or NONE.
    image: u32,
    reflectance: vec3<f32>,
    // Width and height of the image, 16 bits each.
    image_size: u32,
    transmittance: vec3<f32>,
    // First word of its cut, NONE for all of it, NOTHING for nothing.
    cut: u32,
    // Texel from (u, v, 1): of the image, from texel centres.
    image_u: vec3<f32>,
    cut_size: u32,
    image_v: vec3<f32>,
    // Two bits an axis: WRAP_REPEAT and so on, of the image and of the cut.
    wrap: u32,
    cut_u: vec3<f32>,
    // How far off the surface its light is sampled, metres of the model; below 0: at it, and half of it falls on a
    // solid.
    solid_offset_m: f32,
    cut_v: vec3<f32>,
    // Word of the colour of the first vertex of all species, three words a vertex; NONE where vertices are white. Less
    // than the first word of its own species' colours.
    colors: u32,
}

// A ray within a model's box.
struct Inside {
    origin: vec3<f32>,
    // Distance in the model's frame from the ray's own origin.
    start: f32,
    direction: vec3<f32>,
    is_met: bool,
}

struct Found {
    distance: f32,
    triangle: u32,
    weights: vec2<f32>,
}

const MODELS: u32 = 256u;
const MATERIALS: u32 = 512u;
// Boxes that wait for their turn.
const STACK: u32 = 96u;
const NONE: u32 = 0xffffffffu;
const NOTHING: u32 = 0xfffffffeu;
const TRIANGLE_CUT: u32 = 0x80000000u;
const TRIANGLE_FRONT: u32 = 0x40000000u;
const TRIANGLE_BACK: u32 = 0x20000000u;
const CLASS_LEAF: u32 = 1u;
const WRAP_REPEAT: u32 = 0u;
const WRAP_CLAMP: u32 = 1u;
const WRAP_MIRROR: u32 = 2u;
// Beside the wraps of a material: its colours are those of the nearest texels.
const NEAREST: u32 = 256u;
const NEVER: f32 = 3.0e38;
// A direction's part nearer to 0 is taken to be this, so that nothing is divided by 0.
const LEVEL: f32 = 1e-18;

@group(1) @binding(0) var<uniform> models: array<Model, MODELS>;
@group(1) @binding(1) var<uniform> materials: array<Material, MATERIALS>;
@group(1) @binding(2) var<storage, read> boxes: array<Box>;
@group(1) @binding(3) var<storage, read> triangles: array<Triangle>;
@group(1) @binding(4) var<storage, read> vertices: array<Vertex>;
// sRGB to linear light, images, cuts, heights and grids.
@group(1) @binding(5) var<storage, read> words: array<u32>;
@group(1) @binding(6) var<storage, read> stand: array<Box>;
// In the order of the stand's tree.
@group(1) @binding(7) var<storage, read> instances: array<Instance>;

var<private> stack: array<u32, STACK>;

fn inverse_of(direction: vec3<f32>) -> vec3<f32> {
    return 1.0 / select(direction, select(vec3<f32>(LEVEL), vec3<f32>(-LEVEL), direction < vec3<f32>(0.0)), abs(direction) < vec3<f32>(LEVEL));
}

// Where a ray enters a box, not before 0, or NEVER.
fn enter(found: Box, origin: vec3<f32>, inverse: vec3<f32>, far: f32) -> f32 {
    let a = (found.min - origin) * inverse;
    let b = (found.max - origin) * inverse;
    let first = min(a, b);
    let last = max(a, b);
    let start = max(max(first.x, first.y), max(first.z, 0.0));
    let end = min(min(last.x, last.y), min(last.z, far));
    return select(NEVER, start, start <= end);
}

// Where an instance stands.
fn place_of(instance: Instance) -> vec3<f32> {
    let high = vec3<f32>(instance.x.w, instance.y.w, instance.z.w);
    return (high - view.eye_high) + (instance.place_low - view.eye_low);
}

fn into_model(instance: Instance, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(instance.x.xyz, direction), dot(instance.y.xyz, direction), dot(instance.z.xyz, direction));
}

fn out_of_model(instance: Instance, point_model_m: vec3<f32>) -> vec3<f32> {
    let p = point_model_m;
    return place_of(instance) + (instance.x.xyz * p.x + instance.y.xyz * p.y + instance.z.xyz * p.z) * instance.scale;
}

fn enter_model(instance: Instance, origin: vec3<f32>, direction: vec3<f32>) -> Inside {
    let begin = into_model(instance, origin - place_of(instance)) / instance.scale;
    let along = into_model(instance, direction);
    let model = models[instance.species];
    let start = enter(Box(model.min, 0u, model.max, 0u), begin, inverse_of(along), NEVER);
    return Inside(begin + along * min(start, NEVER * 0.5), start, along, start < NEVER);
}

fn wrapped(at: f32, size: u32, wrap: u32) -> u32 {
    let count = i32(size);
    let texel = i32(clamp(at, -1e9, 1e9));
    if wrap == WRAP_CLAMP {
        return u32(clamp(texel, 0, count - 1));
    }
    let period = select(count, 2 * count, wrap == WRAP_MIRROR);
    var inside = texel % period;
    inside = select(inside, inside + period, inside < 0);
    return u32(select(inside, period - 1 - inside, inside >= count));
}

fn uv_at(triangle: Triangle, weights: vec2<f32>) -> vec3<f32> {
    let a = vec2<f32>(vertices[triangle.a].u, vertices[triangle.a].v);
    let b = vec2<f32>(vertices[triangle.b].u, vertices[triangle.b].v);
    let c = vec2<f32>(vertices[triangle.c].u, vertices[triangle.c].v);
    return vec3<f32>(a * (1.0 - weights.x - weights.y) + b * weights.x + c * weights.y, 1.0);
}

// Whether alpha leaves a point of a triangle that is cut.
fn is_present(triangle: Triangle, weights: vec2<f32>) -> bool {
    let index = triangle.material & 0xffffu;
    let cut = materials[index].cut;
    if cut >= NOTHING {
        return cut == NONE;
    }
    let uv = uv_at(triangle, weights);
    let size = materials[index].cut_size;
    let wrap = materials[index].wrap;
    let width = size & 0xffffu;
    let x = wrapped(floor(dot(materials[index].cut_u, uv)), width, (wrap >> 4u) & 3u);
    let y = wrapped(floor(dot(materials[index].cut_v, uv)), size >> 16u, (wrap >> 6u) & 3u);
    // Rows are of whole pairs of words.
    let row = ((width + 63u) / 64u) * 2u;
    return ((words[cut + y * row + x / 32u] >> (x % 32u)) & 1u) == 1u;
}

// The triangle at a place of the order, if a ray meets it; else at the distance NEVER (Moeller and Trumbore 1997).
fn meet(place: u32, origin: vec3<f32>, direction: vec3<f32>) -> Found {
    let triangle = triangles[place];
    let a = vertices[triangle.a].point;
    let e1 = vertices[triangle.b].point - a;
    let e2 = vertices[triangle.c].point - a;
    let p = cross(direction, e2);
    let determinant = dot(e1, p);
    let inverse = 1.0 / determinant;
    let s = origin - a;
    let u = dot(s, p) * inverse;
    let q = cross(s, e1);
    let v = dot(direction, q) * inverse;
    let distance = dot(e2, q) * inverse;
    // Above 0 where the ray comes from the side from which the vertices run counter-clockwise.
    let refuses = select(TRIANGLE_FRONT, TRIANGLE_BACK, determinant > 0.0);
    let is_met = determinant != 0.0 && (triangle.material & refuses) == 0u && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0 && distance < NEVER;
    let found = Found(select(NEVER, distance, is_met), place, vec2<f32>(u, v));
    if is_met && (triangle.material & TRIANGLE_CUT) != 0u && !is_present(triangle, found.weights) {
        return Found(NEVER, place, found.weights);
    }
    return found;
}

// What a ray meets nearest of a model: the triangle at a place, if it is nearer than what was found so far. Of two at
// one distance the one with the lower number counts.
fn nearer_triangle(best: Found, place: u32, origin: vec3<f32>, direction: vec3<f32>) -> Found {
    let found = meet(place, origin, direction);
    if found.distance < best.distance {
        return found;
    }
    if found.distance == best.distance && found.distance < NEVER {
        if best.triangle == NONE || triangles[place].number < triangles[best.triangle].number {
            return found;
        }
    }
    return best;
}

// What a ray meets nearest: that of an instance, if it is nearer than what was found so far. Of two at one distance the
// one with the lower number counts.
fn nearer_of(best: Fragment, place: u32, bottom: u32, origin: vec3<f32>, direction: vec3<f32>) -> Fragment {
    let instance = instances[place];
    let inside = enter_model(instance, origin, direction);
    let reach = select((best.distance_m / instance.scale) * (1.0 + 1e-6) - inside.start, NEVER, best.distance_m == NEVER);
    if !inside.is_met || reach < 0.0 {
        return best;
    }
    let found = find_in_model(models[instance.species].root, bottom, inside.origin, inside.direction, reach);
    let distance_m = (inside.start + found.distance) * instance.scale;
    if found.triangle == NONE || distance_m > best.distance_m {
        return best;
    }
    if distance_m < best.distance_m || instance.number < instances[best.instance].number {
        return Fragment(place, found.triangle, found.weights, distance_m, 1.0);
    }
    return best;
}

// Whether an instance stands in the way of a ray.
fn is_in_the_way(place: u32, bottom: u32, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    let instance = instances[place];
    let inside = enter_model(instance, origin, direction);
    return inside.is_met && is_blocked_in_model(models[instance.species].root, bottom, inside.origin, inside.direction, NONE);
}
