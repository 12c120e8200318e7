//! The 18 lattice directions, rest, their weights and their order, which is part of the format.
//!
//! Source: Steele 2009, section 2.2 (D3Q19, projected from 24 points in 4D); order fixed by the
//! project's lighting model, section 1. `DIRECTIONS[m]` is the direction in which the light TRAVELS.

/// Number of moving directions; index 0 of the tables is rest.
pub const MOVING: usize = 18;

/// `c_m` in lattice steps, `[m][x, y, z]`. 0 rest, 1..=6 axial, 7..=18 diagonal.
pub const DIRECTIONS: [[i32; 3]; 19] = [
    [0, 0, 0],
    [1, 0, 0],
    [-1, 0, 0],
    [0, 1, 0],
    [0, -1, 0],
    [0, 0, 1],
    [0, 0, -1],
    [1, 1, 0],
    [-1, -1, 0],
    [1, -1, 0],
    [-1, 1, 0],
    [1, 0, 1],
    [-1, 0, -1],
    [1, 0, -1],
    [-1, 0, 1],
    [0, 1, 1],
    [0, -1, -1],
    [0, 1, -1],
    [0, -1, 1],
];

/// `w_m`: 1/12 axial, 1/24 diagonal, 0 for rest. They sum to 1.
pub const WEIGHTS: [f64; 19] = {
    let mut weights = [1.0 / 24.0; 19];
    weights[0] = 0.0;
    let mut m = 1;
    while m <= 6 {
        weights[m] = 1.0 / 12.0;
        m += 1;
    }
    weights
};

/// The index of the direction opposite to `m`; rest is its own opposite.
pub const fn opposite(m: usize) -> usize {
    match m {
        0 => 0,
        m if m % 2 == 1 => m + 1,
        m => m - 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposites_are_neighbours_and_weights_sum_to_one() {
        for (m, c) in DIRECTIONS.iter().enumerate() {
            let o = opposite(m);
            assert_eq!(opposite(o), m);
            assert_eq!(*c, DIRECTIONS[o].map(|component| -component));
        }
        let sum: f64 = WEIGHTS.iter().sum();
        assert!((sum - 1.0).abs() < 1e-15, "weights sum to {sum}");
    }

    #[test]
    fn every_direction_is_unique_and_has_length_one_or_sqrt_two() {
        for (m, a) in DIRECTIONS.iter().enumerate() {
            let squared: i32 = a.iter().map(|c| c * c).sum();
            assert_eq!(
                squared,
                if m == 0 {
                    0
                } else if m <= 6 {
                    1
                } else {
                    2
                }
            );
            assert_eq!(DIRECTIONS.iter().filter(|b| *b == a).count(), 1);
        }
    }
}
