// Instances along any ray by a bounding volume hierarchy. The twin is forest/instance_tree.rs of the CPU's renderer.

// The nearest plant along a ray, or SKY.
fn nearest(origin: vec3<f32>, direction: vec3<f32>) -> Fragment {
    var best = Fragment(SKY, 0u, vec2<f32>(0.0), NEVER, 1.0);
    let inverse = inverse_of(direction);
    let from_middle = origin + view.eye_high + view.eye_low;
    let start = enter(Box(view.stand_min, 0u, view.stand_max, 0u), from_middle, inverse, NEVER);
    if start == NEVER {
        return best;
    }
    let begin = from_middle + direction * start;
    var top = 0u;
    var at = 0u;
    loop {
        let here = stand[at];
        let first = here.first;
        let count = here.count;
        let far = select((best.distance_m - start) * (1.0 + 1e-6), NEVER, best.distance_m == NEVER);
        if count > 0u {
            for (var place = first; place < first + count; place++) {
                best = nearer_of(best, place, top, origin, direction);
            }
        } else {
            let left = enter(stand[first], begin, inverse, far);
            let right = enter(stand[first + 1u], begin, inverse, far);
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
        if top == 0u {
            break;
        }
        top--;
        at = stack[top];
    }
    return best;
}

// Whether a plant but one stands in the way of a ray.
fn is_hidden(origin: vec3<f32>, direction: vec3<f32>, except: u32) -> bool {
    let inverse = inverse_of(direction);
    let from_middle = origin + view.eye_high + view.eye_low;
    let start = enter(Box(view.stand_min, 0u, view.stand_max, 0u), from_middle, inverse, NEVER);
    if start == NEVER {
        return false;
    }
    let begin = from_middle + direction * start;
    var top = 0u;
    var at = 0u;
    loop {
        let here = stand[at];
        let first = here.first;
        let count = here.count;
        if count > 0u {
            for (var place = first; place < first + count; place++) {
                if place != except && is_in_the_way(place, top, origin, direction) {
                    return true;
                }
            }
        } else {
            let left = enter(stand[first], begin, inverse, NEVER);
            let right = enter(stand[first + 1u], begin, inverse, NEVER);
            if min(left, right) < NEVER {
                if max(left, right) < NEVER {
                    stack[top] = first + 1u;
                    top++;
                }
                at = select(first, first + 1u, left == NEVER);
                continue;
            }
        }
        if top == 0u {
            break;
        }
        top--;
        at = stack[top];
    }
    return false;
}
