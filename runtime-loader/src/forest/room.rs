//! Room for volumes: which suns of which species have one within a budget.

use super::suns::Extent;

/// A species that is seen, or was lately.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wish {
    /// Bytes of a volume, as far as is known.
    pub bytes: u64,
    /// Suns that plants ask for, and those that have a volume.
    pub extent: Extent,
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
    let fits = |stride: u32| wishes.iter().map(|wish| bytes(wish, yaws, stride)).sum::<u64>() <= max_bytes;
    let strides = std::iter::successors(Some(1), |stride| (*stride < yaws).then_some(stride * 2));
    strides.map(|stride| stride.min(yaws)).find(|stride| fits(*stride))
}

/// Which species have one volume each where not all do: those that are seen most. One that has a volume keeps it until
/// another is seen half as much again.
pub(super) fn chosen(wishes: &[Wish], yaws: u32, max_bytes: u64) -> Vec<bool> {
    let worth = |wish: &Wish| wish.pixels * if wish.has_some { HELD } else { 1.0 };
    let mut order: Vec<usize> = (0..wishes.len()).collect();
    order.sort_by(|a, b| worth(&wishes[*b]).total_cmp(&worth(&wishes[*a])));
    let (mut found, mut left) = (vec![false; wishes.len()], max_bytes);
    for number in order {
        if let Some(rest) = left.checked_sub(bytes(&wishes[number], yaws, yaws)) {
            (found[number], left) = (true, rest);
        }
    }
    found
}

fn bytes(wish: &Wish, yaws: u32, stride: u32) -> u64 {
    let Extent { cells, above, below } = wish.extent;
    let rows = if stride < yaws { 1 + above.div_ceil(stride) + below.div_ceil(stride) } else { 1 };
    // Of a wider grid a cell asks for those around it.
    let cells = if stride == 1 { cells } else { cells.saturating_mul(4) };
    2 * wish.bytes * u64::from(cells.min(rows * yaws.div_ceil(stride)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_yaws_have_volumes_before_species_go_without() {
        let extent = Extent { cells: 16, above: 0, below: 0 };
        let wish = |bytes, pixels| Wish { bytes, extent, pixels, has_some: false };
        let two = [wish(1000, 5.0), wish(3000, 9.0)];
        let of = |max_bytes| stride(&two, 16, max_bytes);
        assert_eq!([128_000, 127_999, 16_000, 8_000].map(of), [1, 2, 8, 16].map(Some));
        assert_eq!(of(7_999), None);
        assert_eq!(chosen(&two, 16, 7_999), [false, true]);
        assert_eq!(chosen(&two, 16, 2_500), [true, false]);
        assert_eq!(chosen(&two, 16, 0), [false; 2]);
        // Suns that no plant has take no room.
        let few = Extent { cells: 2, ..extent };
        assert_eq!(stride(&[Wish { extent: few, ..wish(1000, 1.0) }], 16, 4_000), Some(1));
        // Of tilted plants: three rows of all yaws, of every second one, and one volume.
        let tilted = Extent { cells: 48, above: 1, below: 1 };
        let of = |max_bytes| stride(&[Wish { extent: tilted, ..wish(1000, 1.0) }], 16, max_bytes);
        assert_eq!([96_000, 95_999, 48_000, 24_000, 2_000].map(of), [1, 2, 2, 4, 16].map(Some));
        assert_eq!(
            (stride(&[], 16, 0), stride(&two[..1], 1, 2_000), stride(&two[..1], 3, 2_000)),
            (Some(1), Some(1), Some(3))
        );
        // What is there stays until another is seen much more.
        let held = |pixels| [Wish { has_some: true, ..wish(1000, 5.0) }, wish(1000, pixels)];
        assert_eq!(chosen(&held(7.0), 16, 2_000), [true, false]);
        assert_eq!(chosen(&held(8.0), 16, 2_000), [false, true]);
    }
}
