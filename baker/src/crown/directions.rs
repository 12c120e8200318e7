//! Directions over the sphere whose mean is a good mean: Lebedev's sets (Lebedev, 1976), one of each antipodal pair.

/// An axis: both directions along it, with the share of the sphere that they stand for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Unit length.
    pub along: [f64; 3],
    /// Weight; those of a set sum to 1.
    pub weight: f64,
}

/// The 13 axes of the 26 points (exact to degree 7): faces, edges and corners of a cube. Sites are measured along
/// these.
pub fn measured_axes() -> Vec<Axis> {
    let set = [([1, 0, 0], 1.0 / 21.0), ([1, 1, 0], 4.0 / 105.0), ([1, 1, 1], 9.0 / 280.0)];
    axes_of(&set)
}

/// The 25 axes of the 50 points (exact to degree 11): the 13 and 12 more. Crowns are judged along these.
pub fn judged_axes() -> Vec<Axis> {
    let set = [
        ([1, 0, 0], 4.0 / 315.0),
        ([1, 1, 0], 64.0 / 2835.0),
        ([1, 1, 1], 27.0 / 1280.0),
        ([1, 1, 3], 14641.0 / 725_760.0),
    ];
    axes_of(&set)
}

/// All axes that permutations and signs make of each (direction, weight of a point).
fn axes_of(set: &[([i32; 3], f64)]) -> Vec<Axis> {
    let mut axes = Vec::new();
    for &(pattern, weight) in set {
        let length = libm::sqrt(f64::from(pattern.iter().map(|c| c * c).sum::<i32>()));
        let mut found: Vec<[i32; 3]> = Vec::new();
        for turn in 0..3 {
            let turned: [i32; 3] = std::array::from_fn(|axis| pattern[(axis + turn) % 3]);
            for signs in 0..8 {
                let signed: [i32; 3] =
                    std::array::from_fn(
                        |axis| if signs >> axis & 1 == 1 { -turned[axis] } else { turned[axis] },
                    );
                if !found.contains(&signed) && !found.contains(&signed.map(|c| -c)) {
                    found.push(signed);
                }
            }
        }
        axes.extend(
            found.iter().map(|c| Axis { along: c.map(|c| f64::from(c) / length), weight: 2.0 * weight }),
        );
    }
    axes
}
