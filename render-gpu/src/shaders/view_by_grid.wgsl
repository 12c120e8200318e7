// Rays of the camera by a grid over the picture. The twin is forest/view_grid.rs of the CPU's renderer, which makes it.
//
// Its words: cells in a row; first word of the lists, from here on; [row][column] and one more: where the list of each
// cell starts; the lists: how far the nearest point of an instance's box is, and the instance, nearest first.

const VIEW_CELL: u32 = 16u;

// The nearest plant that a ray through a pixel meets, or SKY.
fn nearest_in_view(pixel: vec2<u32>, direction: vec3<f32>) -> Fragment {
    var best = Fragment(SKY, 0u, vec2<f32>(0.0), NEVER, 1.0);
    let at = pixel / VIEW_CELL;
    let lists = view.cells + words[view.cells + 1u];
    let cell = view.cells + 2u + at.y * words[view.cells] + at.x;
    let end = words[cell + 1u];
    for (var item = words[cell]; item < end; item++) {
        if bitcast<f32>(words[lists + 2u * item]) > best.distance_m {
            break;
        }
        best = nearer_of(best, words[lists + 2u * item + 1u], 0u, vec3<f32>(0.0), direction);
    }
    return best;
}
