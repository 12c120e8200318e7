//! Suns as a list of directions: a base for each, and for any other sun the blend of the triangle that it stands in.
//!
//! The directions are corners of triangles that cover the sphere exactly once (SPEC.md, M57). A sun s is `u_i s_i + u_j
//! s_j + u_k s_k` in the corners of a triangle; it stands in the one whose smallest u is largest. Divided by their sum,
//! the u are the weights. On an edge the third u is 0 from either side, so the blend is continuous.

use super::SunBlend;

/// Fewest directions: a tetrahedron's corners.
const MIN_DIRECTIONS: usize = 4;
/// Most directions: bases are numbered by a byte, and base 0 is the sky's.
const MAX_DIRECTIONS: usize = 255;
/// How far a direction's length may be from 1.
const LENGTH_TOLERANCE: f64 = 1e-6;
/// Least determinant of a triangle's corners.
const MIN_DETERMINANT: f64 = 1e-6;
/// Triangles that cover the sphere k times have solid angles of 4 pi k in sum; this is between one and two.
const MAX_SOLID_ANGLE: f64 = 6.0 * std::f64::consts::PI;

/// Directions towards suns, with their triangulation. A value of this type satisfies M57.
#[derive(Debug, Clone, PartialEq)]
pub struct SunDirections {
    directions: Vec<[f64; 3]>,
    triangles: Vec<[u8; 3]>,
}

/// Directions or triangles that break M57.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("light.suns.{field} is {found}, expected {expected}")]
pub struct SunDirectionsError {
    /// Field that breaks the rule, below `light.suns`.
    pub field: String,
    /// Value found.
    pub found: String,
    /// Value that the rule requires.
    pub expected: &'static str,
}

impl SunDirections {
    /// Checks M57. Directions are unit vectors towards the sun in model space; a triangle is three of their indices,
    /// counter-clockwise as seen from outside, the smallest first; triangles ascend.
    ///
    /// # Errors
    /// The first breach, in the rule's order.
    pub fn new(
        directions: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<SunDirections, SunDirectionsError> {
        check_directions(&directions)?;
        let triangles = indices(&triangles, directions.len())?;
        let mut solid_angle = 0.0;
        for (at, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|corner| directions[usize::from(corner)]);
            let found = determinant(corners);
            if found < MIN_DETERMINANT {
                let field = format!("triangles[{at}], its corners' determinant,");
                return fault(field, found, "at least 1e-6: counter-clockwise from outside, and no sliver");
            }
            solid_angle += solid_angle_of(corners);
        }
        check_edges(&triangles)?;
        let is_corner = |at: usize| triangles.iter().flatten().any(|corner| usize::from(*corner) == at);
        if let Some(at) = (0..directions.len()).find(|at| !is_corner(*at)) {
            return fault(format!("directions[{at}]"), "of no triangle", "a corner of some triangle");
        }
        if solid_angle >= MAX_SOLID_ANGLE {
            let field = "triangles, the sum of their solid angles,".to_owned();
            return fault(field, solid_angle, "below 6 pi, as they cover the sphere once");
        }
        Ok(SunDirections { directions, triangles })
    }

    /// Unit vectors towards the suns, model space; that of base 1 + i is number i.
    pub fn directions(&self) -> &[[f64; 3]] {
        &self.directions
    }

    /// Indices of directions, the smallest first, ascending.
    pub fn triangles(&self) -> &[[u8; 3]] {
        &self.triangles
    }

    /// The blend for a sun that stands in direction `towards_sun_model` (model space, any length).
    /// `None` if the vector is zero or not finite.
    pub fn blend(&self, towards_sun_model: [f64; 3]) -> Option<SunBlend> {
        let longest = towards_sun_model.iter().fold(0.0f64, |l, c| l.max(c.abs()));
        if longest == 0.0 || !towards_sun_model.iter().all(|c| c.is_finite()) {
            return None;
        }
        let sun = towards_sun_model.map(|c| c / longest);
        let mut best = ([0; 3], [0.0; 3], f64::NEG_INFINITY);
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| self.directions[usize::from(corner)]);
            let whole = determinant([a, b, c]);
            let shares =
                [[sun, b, c], [a, sun, c], [a, b, sun]].map(|with_sun| determinant(with_sun) / whole);
            let smallest = shares[0].min(shares[1]).min(shares[2]);
            if smallest > best.2 {
                best = (*triangle, shares, smallest);
            }
        }
        let shares = best.1.map(|share| share.max(0.0));
        let sum = shares[0] + shares[1] + shares[2];
        Some(SunBlend {
            bases: best.0.map(|corner| corner + 1),
            weights: shares.map(|share| (share / sum) as f32),
        })
    }
}

fn fault<T>(field: String, found: impl ToString, expected: &'static str) -> Result<T, SunDirectionsError> {
    Err(SunDirectionsError { field, found: found.to_string(), expected })
}

fn check_directions(directions: &[[f64; 3]]) -> Result<(), SunDirectionsError> {
    if !(MIN_DIRECTIONS..=MAX_DIRECTIONS).contains(&directions.len()) {
        return fault("directions".to_owned(), format!("{} vectors", directions.len()), "4 to 255");
    }
    for (at, direction) in directions.iter().enumerate() {
        let found = length(*direction);
        let fits = (found - 1.0).abs() <= LENGTH_TOLERANCE; // false for NaN
        if !fits {
            return fault(format!("directions[{at}], its length,"), found, "1 within 1e-6");
        }
    }
    Ok(())
}

/// The triangles in bytes: every index one of `count` directions, each triangle in its one spelling and after the one
/// before.
fn indices(triangles: &[[u32; 3]], count: usize) -> Result<Vec<[u8; 3]>, SunDirectionsError> {
    let mut all: Vec<[u8; 3]> = Vec::with_capacity(triangles.len());
    for (at, triangle) in triangles.iter().enumerate() {
        let &[a, b, c] = triangle;
        let is_known = |corner: &u32| (*corner as usize) < count;
        let fits = triangle.iter().all(is_known) && a < b && a < c && b != c;
        if !fits {
            let expected = "indices of three directions, the smallest first";
            return fault(format!("triangles[{at}]"), format!("{triangle:?}"), expected);
        }
        let triangle = triangle.map(|corner| corner as u8); // below 255
        if all.last().is_some_and(|before| *before >= triangle) {
            return fault(format!("triangles[{at}]"), format!("{triangle:?}"), "after the one before it");
        }
        all.push(triangle);
    }
    Ok(all)
}

/// Every directed edge occurs once, and so does its reverse.
fn check_edges(triangles: &[[u8; 3]]) -> Result<(), SunDirectionsError> {
    let mut edges: Vec<[u8; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
        return fault(format!("triangles, the edge {:?},", pair[0]), "of two triangles", "of one");
    }
    match edges.iter().find(|&&[a, b]| edges.binary_search(&[b, a]).is_err()) {
        Some(edge) => {
            let expected = "an edge of another triangle the other way";
            fault(format!("triangles, the edge {edge:?},"), "of one triangle alone", expected)
        }
        None => Ok(()),
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f64; 3]) -> f64 {
    libm::sqrt(dot(a, a))
}

/// a . (b x c)
fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let across = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    dot(a, across)
}

/// Van Oosterom and Strackee 1983, eq. 8; 0 to 2 pi where the determinant is positive.
fn solid_angle_of([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let lengths = [a, b, c].map(length);
    let across = lengths[0] * lengths[1] * lengths[2]
        + dot(a, b) * lengths[2]
        + dot(a, c) * lengths[1]
        + dot(b, c) * lengths[0];
    2.0 * libm::atan2(determinant([a, b, c]), across)
}

#[cfg(test)]
mod tests;
