//! Many rotations by few of them: those that stand for the others.

/// World from model, rows.
type Rotation = [[f64; 3]; 3];

/// For each rotation the place of the one that stands for it: itself, if there are at most `most`; else the nearest by angle of so many, each of
/// which was chosen because it lay farthest from those before it (Gonzalez 1985, "Clustering to minimize the maximum intercluster distance": the
/// farthest of the others lies at most twice as far off as it would have to).
pub fn leaders(rotations: &[Rotation], most: usize) -> Vec<usize> {
    if rotations.len() <= most {
        return (0..rotations.len()).collect();
    }
    let mut leaders = vec![0; rotations.len()];
    let mut likeness: Vec<f64> = rotations.iter().map(|one| likeness_of(&rotations[0], one)).collect();
    for _ in 1..most {
        let (farthest, least) =
            (0..).zip(&likeness).fold((0, f64::INFINITY), |(at, least), (i, likeness)| {
                if *likeness < least { (i, *likeness) } else { (at, least) }
            });
        if least >= likeness_of(&rotations[farthest], &rotations[farthest]) {
            break;
        }
        for (i, one) in rotations.iter().enumerate() {
            let found = likeness_of(&rotations[farthest], one);
            if found > likeness[i] {
                (likeness[i], leaders[i]) = (found, farthest);
            }
        }
    }
    leaders
}

/// 1 + 2 cos of the angle from one to the other.
fn likeness_of(one: &Rotation, other: &Rotation) -> f64 {
    one.iter().flatten().zip(other.iter().flatten()).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::noise;

    /// Turned by anything about the vertical, then tilted by up to 15 degrees.
    fn tilted(seed: u32) -> Rotation {
        let yaw = f64::from(noise(seed, 1)) * std::f64::consts::TAU;
        let [a, b] = [2, 3].map(|axis| (f64::from(noise(seed, axis)) - 0.5) * 0.37);
        let ((s, c), (sa, ca), (sb, cb)) = (libm::sincos(yaw), libm::sincos(a), libm::sincos(b));
        let times = |p: Rotation, q: Rotation| -> Rotation {
            std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| p[i][k] * q[k][j]).sum()))
        };
        let about_x = [[1.0, 0.0, 0.0], [0.0, ca, -sa], [0.0, sa, ca]];
        let about_z = [[cb, -sb, 0.0], [sb, cb, 0.0], [0.0, 0.0, 1.0]];
        times(times(about_x, about_z), [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    }

    #[test]
    fn few_stand_for_themselves_and_of_many_each_has_the_nearest() {
        let rotations: Vec<Rotation> = (0..2000).map(tilted).collect();
        assert_eq!(leaders(&rotations[..40], 40), (0..40).collect::<Vec<_>>());
        let found = leaders(&rotations, 256);
        let mut used = found.clone();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), 256);
        for (i, leader) in found.iter().enumerate() {
            assert_eq!(found[*leader], *leader, "a leader stands for itself");
            let best = used.iter().map(|one| likeness_of(&rotations[*one], &rotations[i]));
            let best = best.fold(f64::NEG_INFINITY, f64::max);
            let mine = likeness_of(&rotations[*leader], &rotations[i]);
            assert!(mine >= best, "{i}: {mine} {best}");
            let angle = libm::acos((0.5 * (mine - 1.0)).clamp(-1.0, 1.0)).to_degrees();
            assert!(angle < 12.0, "{i}: {angle} degrees");
        }
    }

    #[test]
    fn rotations_that_are_alike_need_one() {
        let rotations: Vec<Rotation> = (0..1000).map(|i| tilted(i % 3)).collect();
        let mut used = leaders(&rotations, 256);
        assert_eq!(used[..6], [0, 1, 2, 0, 1, 2]);
        used.sort_unstable();
        used.dedup();
        assert_eq!(used, [0, 1, 2]);
    }
}
