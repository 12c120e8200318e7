// Rays to a plane or to a height field. The twin is forest/ground.rs of the CPU's renderer.

// Distance at which a ray comes through the ground, or NEVER.
fn ground_along(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    if view.ground == GROUND_PLANE {
        let above = origin.y - view.ground_origin.y;
        return select(NEVER, above / -direction.y, above > 0.0 && direction.y < 0.0);
    }
    if view.ground == GROUND_HEIGHTS {
        return heights_along(origin, direction);
    }
    return NEVER;
}

// Whether a ray from above the ground is stopped by it. What stands below a plane is seen through it, and lit through
// it too.
fn is_stopped(origin: vec3<f32>, direction: vec3<f32>) -> bool {
    if view.ground == GROUND_PLANE {
        return direction.y <= 0.0;
    }
    return view.ground == GROUND_HEIGHTS && heights_along(origin, direction) < NEVER;
}

fn ground_normal(point: vec3<f32>) -> vec3<f32> {
    if view.ground != GROUND_HEIGHTS {
        return vec3<f32>(0.0, 1.0, 0.0);
    }
    let place = (point.xz - view.ground_origin.xz) / view.spacing;
    let rise = vec2<f32>(
        height_at(place + vec2<f32>(1.0, 0.0)) - height_at(place - vec2<f32>(1.0, 0.0)),
        height_at(place + vec2<f32>(0.0, 1.0)) - height_at(place - vec2<f32>(0.0, 1.0)),
    );
    let slope = rise / (2.0 * view.spacing);
    return normalize(vec3<f32>(-slope.x, 1.0, -slope.y));
}

fn height_of(column: i32, row: i32) -> f32 {
    return bitcast<f32>(words[view.heights + u32(row) * view.columns + u32(column)]);
}

// Height in a square of the field, above the lowest: two triangles.
fn height_within(square: vec2<i32>, share: vec2<f32>) -> f32 {
    let right = height_of(square.x + 1, square.y);
    let down = height_of(square.x, square.y + 1);
    if share.x + share.y <= 1.0 {
        let corner = height_of(square.x, square.y);
        return corner + share.x * (right - corner) + share.y * (down - corner);
    }
    let corner = height_of(square.x + 1, square.y + 1);
    return corner + (1.0 - share.x) * (down - corner) + (1.0 - share.y) * (right - corner);
}

// The same at any place, in squares; beyond the edge that of the nearest place of the edge.
fn height_at(place: vec2<f32>) -> f32 {
    let last = vec2<f32>(f32(view.columns - 1u), f32(view.rows - 1u));
    let inside = clamp(place, vec2<f32>(0.0), last);
    let square = min(floor(inside), last - vec2<f32>(1.0));
    return height_within(vec2<i32>(square), inside - square);
}

fn height_above(origin: vec3<f32>, direction: vec3<f32>, distance: f32, square: vec2<i32>, place: vec2<f32>) -> f32 {
    let share = clamp(place - vec2<f32>(square), vec2<f32>(0.0), vec2<f32>(1.0));
    return origin.y + direction.y * distance - view.ground_origin.y - height_within(square, share);
}

// Walks the squares under a ray; in each the ray's height above the ground changes in two straight pieces.
fn heights_along(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let inverse = inverse_of(direction);
    let start = enter(Box(view.ground_min, 0u, view.ground_max, 0u), origin, inverse, NEVER);
    if start == NEVER {
        return NEVER;
    }
    let far = max((view.ground_min - origin) * inverse, (view.ground_max - origin) * inverse);
    let end = min(min(far.x, far.y), far.z);
    let begin = (origin.xz - view.ground_origin.xz) / view.spacing;
    let slope = direction.xz / view.spacing;
    let last = vec2<i32>(i32(view.columns) - 2, i32(view.rows) - 2);
    var square = clamp(vec2<i32>(floor(begin + slope * start)), vec2<i32>(0), last);
    var at = start;
    // No ray crosses more squares than these.
    let most = view.columns + view.rows;
    for (var step = 0u; step < most; step++) {
        let edge = vec2<f32>(square + select(vec2<i32>(0), vec2<i32>(1), slope > vec2<f32>(0.0)));
        let leaves = select((edge - begin) / slope, vec2<f32>(NEVER), abs(slope) < vec2<f32>(LEVEL));
        let is_z = leaves.y < leaves.x;
        let leave = min(leaves.x, leaves.y);
        let to = max(min(leave, end), at);
        let sum = slope.x + slope.y;
        let diagonal = (f32(square.x + square.y + 1) - begin.x - begin.y) / select(sum, LEVEL, abs(sum) < LEVEL);
        let middle = select(to, diagonal, diagonal > at && diagonal < to);
        let h0 = height_above(origin, direction, at, square, begin + slope * at);
        let h1 = height_above(origin, direction, middle, square, begin + slope * middle);
        if (h0 > 0.0) != (h1 > 0.0) {
            return at + (middle - at) * (h0 / (h0 - h1));
        }
        let h2 = height_above(origin, direction, to, square, begin + slope * to);
        if (h1 > 0.0) != (h2 > 0.0) {
            return middle + (to - middle) * (h1 / (h1 - h2));
        }
        if leave >= end {
            return NEVER;
        }
        at = to;
        let forward = select(vec2<i32>(-1), vec2<i32>(1), slope > vec2<f32>(0.0));
        square += select(vec2<i32>(forward.x, 0), vec2<i32>(0, forward.y), is_z);
        if any(square < vec2<i32>(0)) || any(square > last) {
            return NEVER;
        }
    }
    return NEVER;
}
