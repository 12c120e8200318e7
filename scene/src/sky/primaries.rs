//! From what red, green and blue of an image mean to linear sRGB.

/// Chromaticities x, y of red, green, blue and white.
pub(super) type Primaries = [[f64; 2]; 4];

/// Those of sRGB (Rec. 709): white is D65.
pub(super) const SRGB: Primaries = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];

/// Those of names, by a part of the name in lower case without blanks and the like: SMPTE ST 2065-1 (AP0), Academy
/// S-2014-004 (ACEScg, AP1), ITU-R BT.2020, SMPTE EG 432-1 (P3 under D65), Adobe RGB (1998).
const NAMED: [(&[&str], Primaries); 5] = [
    (&["ap0", "aces2065"], [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.32168, 0.33767]]),
    (&["ap1", "acescg"], [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044], [0.32168, 0.33767]]),
    (&["rec2020", "bt2020"], [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]]),
    (&["p3d65", "displayp3"], [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.3127, 0.3290]]),
    (&["adobergb"], [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06], [0.3127, 0.3290]]),
];

/// Those of a colour space's name, such as `lin_ap1_scene` or `ACEScg`; `None` where it names none of these.
pub(super) fn of_name(name: &str) -> Option<Primaries> {
    let plain: String = name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
    let is_it = |parts: &[&str]| parts.iter().any(|part| plain.contains(part));
    NAMED.iter().find(|(parts, _)| is_it(parts)).map(|(_, primaries)| *primaries)
}

/// How near chromaticities are the same: files write them with three or four digits.
const SAME: f64 = 1e-3;
/// Least determinant: red, green and blue on one line tell no colours.
const MIN_DETERMINANT: f64 = 1e-6;
/// Bradford's responses of cones to X, Y, Z, by which white stays white.
const CONES: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

type Matrix = [[f64; 3]; 3];

/// What turns colours into those of sRGB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ToSrgb(Option<Matrix>);

impl ToSrgb {
    /// Of an image that means sRGB.
    pub(super) const SAME: ToSrgb = ToSrgb(None);

    /// From these primaries, the image's white to that of sRGB; `None` where they tell no colours.
    pub(super) fn of(primaries: &Primaries) -> Option<ToSrgb> {
        let flat = |primaries: &Primaries| primaries.as_flattened().to_vec();
        let is_same = flat(primaries).iter().zip(flat(&SRGB)).all(|(a, b)| (a - b).abs() <= SAME);
        if is_same {
            return Some(ToSrgb::SAME);
        }
        let from_xyz = inverse(&xyz_of(&SRGB)?)?;
        let adapted = product(&adaptation(primaries[3])?, &xyz_of(primaries)?);
        Some(ToSrgb(Some(product(&from_xyz, &adapted))))
    }

    /// From CIE X, Y, Z.
    pub(super) fn of_xyz() -> ToSrgb {
        ToSrgb(xyz_of(&SRGB).and_then(|matrix| inverse(&matrix)))
    }

    /// The colour; one that sRGB has not loses what is negative.
    pub(super) fn apply(&self, color: [f32; 3]) -> [f32; 3] {
        let Some(matrix) = &self.0 else { return color };
        let color = color.map(f64::from);
        matrix.map(|row| (row[0] * color[0] + row[1] * color[1] + row[2] * color[2]).max(0.0) as f32)
    }
}

/// X, Y, Z of a chromaticity, Y being 1.
fn whole([x, y]: [f64; 2]) -> Option<[f64; 3]> {
    let xyz = [x / y, 1.0, (1.0 - x - y) / y];
    xyz.iter().all(|part| part.is_finite()).then_some(xyz)
}

/// From red, green and blue to X, Y, Z; white has Y 1 (SMPTE RP 177).
fn xyz_of(primaries: &Primaries) -> Option<Matrix> {
    let [red, green, blue, white] = primaries;
    let column = |[x, y]: &[f64; 2]| [*x, *y, 1.0 - x - y];
    let columns = [red, green, blue].map(column);
    let matrix: Matrix = std::array::from_fn(|row| std::array::from_fn(|k| columns[k][row]));
    let strengths = times(&inverse(&matrix)?, whole(*white)?);
    let scaled = std::array::from_fn(|row| std::array::from_fn(|k| matrix[row][k] * strengths[k]));
    strengths.iter().all(|strength| strength.is_finite()).then_some(scaled)
}

/// Turns X, Y, Z under one white into those under the white of sRGB.
fn adaptation(white: [f64; 2]) -> Option<Matrix> {
    let [from, to] = [times(&CONES, whole(white)?), times(&CONES, whole(SRGB[3])?)];
    let scaled: Matrix =
        std::array::from_fn(|row| std::array::from_fn(|k| CONES[row][k] * to[row] / from[row]));
    let found = product(&inverse(&CONES)?, &scaled);
    found.as_flattened().iter().all(|value| value.is_finite()).then_some(found)
}

fn times(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| std::array::from_fn(|k| row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k]))
}

fn inverse(m: &Matrix) -> Option<Matrix> {
    // Of the rows and columns that follow, so that the sign is right.
    let minor = |row: usize, column: usize| {
        let ([r, s], [c, d]) = ([(row + 1) % 3, (row + 2) % 3], [(column + 1) % 3, (column + 2) % 3]);
        m[r][c] * m[s][d] - m[r][d] * m[s][c]
    };
    let determinant: f64 = (0..3).map(|column| m[0][column] * minor(0, column)).sum();
    let is_fine = determinant.is_finite() && determinant.abs() > MIN_DETERMINANT;
    is_fine.then(|| std::array::from_fn(|row| std::array::from_fn(|column| minor(column, row) / determinant)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: [f32; 3], expected: [f32; 3], most: f32) {
        let is_near = (0..3).all(|band| (found[band] - expected[band]).abs() <= most);
        assert!(is_near, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn wide_primaries_become_srgb_as_published_and_white_stays_white() {
        let rec2020: Primaries = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]];
        let to = ToSrgb::of(&rec2020).expect("primaries");
        // ITU-R BT.2087, inverted.
        assert_near(to.apply([1.0, 0.5, 0.5]), [1.3302, 0.4377, 0.4909], 1e-3);
        assert_near(to.apply([1.0, 1.0, 1.0]), [1.0; 3], 1e-4);
        assert_near(to.apply([0.0, 1.0, 0.0]), [0.0, 1.1329, 0.0], 1e-3);
        // ACES AP0, whose white is near D60: by Bradford, as published for ACES2065-1 to sRGB.
        let ap0: Primaries = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.32168, 0.33767]];
        let to = ToSrgb::of(&ap0).expect("primaries");
        assert_near(to.apply([1.0; 3]), [1.0; 3], 1e-4);
        assert_near(to.apply([1.0, 0.5, 0.2]), [1.8770, 0.3906, 0.1418], 1e-3);
        let radiance: Primaries = [[0.640, 0.330], [0.290, 0.600], [0.150, 0.060], [0.333, 0.333]];
        assert_near(ToSrgb::of(&radiance).expect("primaries").apply([0.5; 3]), [0.5; 3], 1e-3);
        assert_near(ToSrgb::of_xyz().apply([0.9505, 1.0, 1.089]), [1.0; 3], 2e-3);
    }

    #[test]
    fn srgb_changes_no_bit_and_what_tells_no_colour_is_none() {
        assert_eq!(ToSrgb::of(&SRGB), Some(ToSrgb::SAME));
        assert_eq!(ToSrgb::SAME.apply([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
        let line: Primaries = [[0.3, 0.3], [0.4, 0.4], [0.2, 0.2], [0.3127, 0.3290]];
        let dark: Primaries = [SRGB[0], SRGB[1], SRGB[2], [0.3, 0.0]];
        let nan: Primaries = [[f64::NAN, 0.3], SRGB[1], SRGB[2], SRGB[3]];
        assert_eq!([line, dark, nan, [[0.0; 2]; 4]].map(|bad| ToSrgb::of(&bad)), [None; 4]);
    }
}
