//! The sun and the even sky that light a frame.

/// The sun and the sky that light a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    /// Towards the sun, in the frame of the world; any length but 0. At night (`sun` is 0) it does not count.
    pub towards_sun: [f64; 3],
    /// Irradiance of the sun on a plane that faces it: 1 is that for which the light was stored.
    pub sun: f32,
    /// Light of an even sky, from 0: of the model `physical` its fluence, in units in which a sun of irradiance 1 has
    /// fluence 1; of `paper` a factor on base 0, whose value is 18 outside the plant.
    pub sky: f32,
}
