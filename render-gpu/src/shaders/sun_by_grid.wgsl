// Shadow rays by a grid across them. The twin is forest/sun_grid.rs of the CPU's renderer, which makes it.
//
// Its words: two unit vectors across the rays; where the first cell begins along both, counted from the middle of the
// stand; cells a metre; cells along both; first word of the lists, from here on; [row][column] and one more: where the
// list of each cell starts; the lists: how far towards the sun an instance's box reaches, and the instance, farthest
// first.

// Before where lists start.
const SUN_HEAD: u32 = 12u;
// Boxes are listed in cells that they miss by this share of one.
const SUN_PAD: f32 = 0.01;

// Whether a plant but one stands between a point and the sun.
fn is_hidden_from_sun(origin: vec3<f32>, except: u32) -> bool {
    let head = daylight.cells;
    let from_middle = origin + view.eye_high + view.eye_low;
    let across = vec2<f32>(dot(from_middle, sun_axis(head)), dot(from_middle, sun_axis(head + 3u)));
    let low = bitcast<vec2<f32>>(vec2<u32>(words[head + 6u], words[head + 7u]));
    let at = (across - low) * bitcast<f32>(words[head + 8u]);
    let count = vec2<u32>(words[head + 9u], words[head + 10u]);
    if any(at < vec2<f32>(-SUN_PAD)) || any(at > vec2<f32>(count) + vec2<f32>(SUN_PAD)) {
        return false;
    }
    let square = min(vec2<u32>(max(at, vec2<f32>(0.0))), count - vec2<u32>(1u));
    let cell = head + SUN_HEAD + square.y * count.x + square.x;
    let lists = head + words[head + 11u];
    let here = dot(from_middle, daylight.towards_sun);
    let end = words[cell + 1u];
    for (var item = words[cell]; item < end; item++) {
        if bitcast<f32>(words[lists + 2u * item]) < here {
            return false;
        }
        let place = words[lists + 2u * item + 1u];
        if place != except && is_in_the_way(place, 0u, origin, daylight.towards_sun) {
            return true;
        }
    }
    return false;
}

fn sun_axis(first: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3<u32>(words[first], words[first + 1u], words[first + 2u]));
}
