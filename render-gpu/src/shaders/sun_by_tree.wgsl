// Shadow rays by the tree over all instances.

// Whether a plant but one stands between a point and the sun.
fn is_hidden_from_sun(origin: vec3<f32>, except: u32) -> bool {
    return is_hidden(origin, daylight.towards_sun, except);
}
