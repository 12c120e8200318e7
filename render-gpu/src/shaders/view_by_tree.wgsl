// Rays of the camera by the tree over all instances.

// The nearest plant that a ray through a pixel meets, or SKY.
fn nearest_in_view(pixel: vec2<u32>, direction: vec3<f32>) -> Fragment {
    return nearest(vec3<f32>(0.0), direction);
}
