//! Room for volumes: which suns of which species have one within a budget.

/// A species that is seen, or was lately.
#[derive(Debug, Clone)]
pub(super) struct Wish {
    /// Bytes of a volume, as far as is known.
    pub bytes: u64,
    /// Volumes that plants ask for, or that are there if those are more, for each of the [`strides`].
    pub volumes: Vec<u32>,
    /// How large it is in the picture; 0 where it is not seen any more.
    pub pixels: f32,
    /// True of a species that has a volume.
    pub has_some: bool,
}

/// Factor on what is there over what would have to be made.
const HELD: f32 = 1.5;

/// Every how-manieth yaw and row has a volume, so that all fit; `None` where not even one of each does. While light is
/// faded there are two of each.
pub(super) fn stride(wishes: &[Wish], yaws: u32, max_bytes: u64) -> Option<u32> {
    let fits = |number: usize| wishes.iter().map(|wish| bytes(wish, number)).sum::<u64>() <= max_bytes;
    strides(yaws).enumerate().find(|(number, _)| fits(*number)).map(|(_, stride)| stride)
}

/// Every how-manieth row and yaw may have a volume: 1, 2, 4 ... and last the number of yaws.
pub(super) fn strides(yaws: u32) -> impl Iterator<Item = u32> {
    let strides = std::iter::successors(Some(1), move |stride| (*stride < yaws).then_some(stride * 2));
    strides.map(move |stride: u32| stride.min(yaws))
}

/// Which species have one volume each where not all do: those that are seen most. One that has a volume keeps it until
/// another is seen half as much again.
pub(super) fn chosen(wishes: &[Wish], max_bytes: u64) -> Vec<bool> {
    let worth = |wish: &Wish| wish.pixels * if wish.has_some { HELD } else { 1.0 };
    let mut order: Vec<usize> = (0..wishes.len()).collect();
    order.sort_by(|a, b| worth(&wishes[*b]).total_cmp(&worth(&wishes[*a])));
    let (mut found, mut left) = (vec![false; wishes.len()], max_bytes);
    for number in order {
        if let Some(rest) = left.checked_sub(bytes(&wishes[number], wishes[number].volumes.len() - 1)) {
            (found[number], left) = (true, rest);
        }
    }
    found
}

fn bytes(wish: &Wish, number: usize) -> u64 {
    2 * wish.bytes * u64::from(wish.volumes[number])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_yaws_have_volumes_before_species_go_without() {
        let wish = |bytes, pixels| Wish { bytes, volumes: vec![16, 8, 4, 2, 1], pixels, has_some: false };
        let two = [wish(1000, 5.0), wish(3000, 9.0)];
        let of = |max_bytes| stride(&two, 16, max_bytes);
        assert_eq!([128_000, 127_999, 16_000, 8_000].map(of), [1, 2, 8, 16].map(Some));
        assert_eq!(of(7_999), None);
        assert_eq!(chosen(&two, 7_999), [false, true]);
        assert_eq!(chosen(&two, 2_500), [true, false]);
        assert_eq!(chosen(&two, 0), [false; 2]);
        // Of few tilted plants a wider grid may ask for more.
        let few = Wish { volumes: vec![4, 6, 3, 2, 1], ..wish(1000, 1.0) };
        let of = |max_bytes| stride(std::slice::from_ref(&few), 16, max_bytes);
        assert_eq!([8_000, 7_999, 5_999].map(of), [1, 4, 8].map(Some));
        let one = |yaws| Wish {
            volumes: strides(yaws).map(|stride| u32::div_ceil(yaws, stride)).collect(),
            ..wish(1000, 5.0)
        };
        assert_eq!(strides(3).collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(
            (stride(&[], 16, 0), stride(&[one(1)], 1, 2_000), stride(&[one(3)], 3, 2_000)),
            (Some(1), Some(1), Some(3))
        );
        // What is there stays until another is seen much more.
        let held = |pixels| [Wish { has_some: true, ..wish(1000, 5.0) }, wish(1000, pixels)];
        assert_eq!(chosen(&held(7.0), 2_000), [true, false]);
        assert_eq!(chosen(&held(8.0), 2_000), [false, true]);
    }
}
