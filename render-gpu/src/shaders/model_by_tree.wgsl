// Triangles of a model by a bounding volume hierarchy.

// The nearest present triangle up to a distance. The stack is free from `bottom` on.
fn find_in_model(root: u32, bottom: u32, origin: vec3<f32>, direction: vec3<f32>, far: f32) -> Found {
    let inverse = inverse_of(direction);
    var best = Found(far, NONE, vec2<f32>(0.0));
    var top = bottom;
    var at = root;
    loop {
        let here = boxes[at];
        let first = here.first;
        let count = here.count;
        if count > 0u {
            for (var place = first; place < first + count; place++) {
                best = nearer_triangle(best, place, origin, direction);
            }
        } else {
            let left = enter(boxes[first], origin, inverse, best.distance);
            let right = enter(boxes[first + 1u], origin, inverse, best.distance);
            let nearer = first + select(0u, 1u, right < left);
            if min(left, right) < NEVER {
                if max(left, right) < NEVER {
                    stack[top] = first + first + 1u - nearer;
                    top++;
                }
                at = nearer;
                continue;
            }
        }
        if top == bottom {
            break;
        }
        top--;
        at = stack[top];
    }
    return best;
}

// Whether anything present of a model but one triangle stands in the way.
fn is_blocked_in_model(root: u32, bottom: u32, origin: vec3<f32>, direction: vec3<f32>, except: u32) -> bool {
    let inverse = inverse_of(direction);
    var top = bottom;
    var at = root;
    loop {
        let here = boxes[at];
        let first = here.first;
        let count = here.count;
        if count > 0u {
            for (var place = first; place < first + count; place++) {
                if place != except && meet(place, origin, direction).distance < NEVER {
                    return true;
                }
            }
        } else {
            let left = enter(boxes[first], origin, inverse, NEVER);
            let right = enter(boxes[first + 1u], origin, inverse, NEVER);
            if min(left, right) < NEVER {
                if max(left, right) < NEVER {
                    stack[top] = first + 1u;
                    top++;
                }
                at = select(first, first + 1u, left == NEVER);
                continue;
            }
        }
        if top == bottom {
            break;
        }
        top--;
        at = stack[top];
    }
    return false;
}
