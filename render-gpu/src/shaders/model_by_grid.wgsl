// Triangles of a model by a uniform grid, walked cell by cell. The twin is forest/model_grid.rs of the CPU's renderer,
// which makes it.
//
// Its words: where it begins; cells a metre along each axis; cells along each axis; first word of the lists, from here
// on; [z][y][x] and one more: where the list of each cell starts; the lists: triangles by their places in the order.

// Before where lists start.
const GRID_HEAD: u32 = 10u;
// Triangles are listed in cells that they miss by this share of one.
const GRID_PAD: f32 = 0.001;

// A ray in a cell.
struct Walk {
    cell: vec3<i32>,
    // Distances at which the ray leaves the cell along each axis.
    next: vec3<f32>,
    // In cells.
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    end: f32,
    is_over: bool,
}

fn begin_walk(head: u32, origin_m: vec3<f32>, direction_m: vec3<f32>, far: f32) -> Walk {
    let min_m = bitcast<vec3<f32>>(vec3<u32>(words[head], words[head + 1u], words[head + 2u]));
    let per_m = bitcast<vec3<f32>>(vec3<u32>(words[head + 3u], words[head + 4u], words[head + 5u]));
    let count = vec3<f32>(count_of(head));
    let direction = direction_m * per_m;
    let origin = (origin_m - min_m) * per_m;
    let inverse = inverse_of(direction);
    let a = (vec3<f32>(-GRID_PAD) - origin) * inverse;
    let b = (count + vec3<f32>(GRID_PAD) - origin) * inverse;
    let first = min(a, b);
    let last = max(a, b);
    let start = max(max(first.x, first.y), max(first.z, 0.0));
    let end = min(min(last.x, last.y), min(last.z, far));
    let cell = vec3<i32>(clamp(floor(origin + direction * start), vec3<f32>(0.0), count - vec3<f32>(1.0)));
    var walk = Walk(cell, vec3<f32>(0.0), origin, direction, inverse, end, start > end);
    walk.next = leaves_of(walk);
    return walk;
}

fn count_of(head: u32) -> vec3<u32> {
    return vec3<u32>(words[head + 6u], words[head + 7u], words[head + 8u]);
}

fn leaves_of(walk: Walk) -> vec3<f32> {
    let plane = walk.cell + select(vec3<i32>(0), vec3<i32>(1), walk.direction > vec3<f32>(0.0));
    let leaves = (vec3<f32>(plane) - walk.origin) * walk.inverse;
    return select(leaves, vec3<f32>(NEVER), abs(walk.direction) < vec3<f32>(LEVEL));
}

// First word of where the cell's list starts.
fn cell_of(head: u32, walk: Walk) -> u32 {
    let count = count_of(head);
    let at = vec3<u32>(walk.cell);
    return head + GRID_HEAD + (at.z * count.y + at.y) * count.x + at.x;
}

// The next cell, unless the ray has ended.
fn walked(head: u32, from_cell: Walk) -> Walk {
    var walk = from_cell;
    let leaves = walk.next;
    let is_x = leaves.x <= leaves.y && leaves.x <= leaves.z;
    let is_y = !is_x && leaves.y <= leaves.z;
    let axis = vec3<bool>(is_x, is_y, !is_x && !is_y);
    let leave = min(min(leaves.x, leaves.y), leaves.z);
    let forward = select(vec3<i32>(-1), vec3<i32>(1), walk.direction > vec3<f32>(0.0));
    walk.cell += select(vec3<i32>(0), forward, axis);
    walk.is_over = leave > walk.end || any(walk.cell < vec3<i32>(0)) || any(walk.cell >= vec3<i32>(count_of(head)));
    walk.next = select(walk.next, leaves_of(walk), axis);
    return walk;
}

// The nearest present triangle up to a distance.
fn find_in_model(root: u32, bottom: u32, origin: vec3<f32>, direction: vec3<f32>, far: f32) -> Found {
    var best = Found(far, NONE, vec2<f32>(0.0));
    var walk = begin_walk(root, origin, direction, far);
    let lists = root + words[root + 9u];
    while !walk.is_over {
        let cell = cell_of(root, walk);
        let end = words[cell + 1u];
        for (var item = words[cell]; item < end; item++) {
            let place = words[lists + item];
            best = nearer_triangle(best, place, origin, direction);
        }
        // Beyond this cell lies nothing that is nearer.
        if best.triangle != NONE && best.distance <= min(min(walk.next.x, walk.next.y), walk.next.z) {
            break;
        }
        walk = walked(root, walk);
    }
    return best;
}

// Whether anything present of a model but one triangle stands in the way.
fn is_blocked_in_model(root: u32, bottom: u32, origin: vec3<f32>, direction: vec3<f32>, except: u32) -> bool {
    var walk = begin_walk(root, origin, direction, NEVER);
    let lists = root + words[root + 9u];
    while !walk.is_over {
        let cell = cell_of(root, walk);
        let end = words[cell + 1u];
        for (var item = words[cell]; item < end; item++) {
            let place = words[lists + item];
            if place != except && meet(place, origin, direction).distance < NEVER {
                return true;
            }
        }
        walk = walked(root, walk);
    }
    return false;
}
