//! Room for volumes: which yaws of which species have one within a budget.

/// A species that is seen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wish {
    /// Bytes of a volume, as far as is known.
    pub bytes: u64,
    /// Yaws that plants ask for.
    pub yaws: u32,
    /// How large it is in the picture.
    pub pixels: f32,
}

/// Every how-manieth yaw of the species has a volume; `None` where a species has none. While light is faded there are
/// two of each.
pub(super) fn strides(wishes: &[Wish], yaws: u32, max_bytes: u64) -> Vec<Option<u32>> {
    let bytes = |wish: &Wish, stride: u32| 2 * wish.bytes * u64::from(wish.yaws.min(yaws.div_ceil(stride)));
    let mut stride = 1;
    while stride < yaws {
        if wishes.iter().map(|wish| bytes(wish, stride)).sum::<u64>() <= max_bytes {
            return vec![Some(stride); wishes.len()];
        }
        stride *= 2;
    }
    // One volume each, and of those that are seen most.
    let mut order: Vec<usize> = (0..wishes.len()).collect();
    order.sort_by(|a, b| wishes[*b].pixels.total_cmp(&wishes[*a].pixels));
    let (mut found, mut left) = (vec![None; wishes.len()], max_bytes);
    for number in order {
        if let Some(rest) = left.checked_sub(bytes(&wishes[number], yaws)) {
            (found[number], left) = (Some(yaws), rest);
        }
    }
    found
}

/// The yaw with a volume that is nearest to one.
pub(super) fn kept(yaw: u32, yaws: u32, stride: u32) -> u32 {
    let kept = (yaw + stride / 2) / stride * stride;
    if kept < yaws { kept } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_yaws_have_volumes_before_species_go_without() {
        let wish = |bytes, pixels| Wish { bytes, yaws: 16, pixels };
        let two = [wish(1000, 5.0), wish(3000, 9.0)];
        assert_eq!(strides(&two, 16, 128_000), [Some(1); 2]);
        assert_eq!(strides(&two, 16, 127_999), [Some(2); 2]);
        assert_eq!(strides(&two, 16, 16_000), [Some(8); 2]);
        assert_eq!(strides(&two, 16, 8_000), [Some(16); 2]);
        assert_eq!(strides(&two, 16, 7_999), [None, Some(16)]);
        assert_eq!(strides(&two, 16, 2_500), [Some(16), None]);
        assert_eq!(strides(&two, 16, 0), [None; 2]);
        // Yaws that no plant has take no room.
        assert_eq!(strides(&[Wish { yaws: 2, ..wish(1000, 1.0) }], 16, 4_000), [Some(1)]);
        assert_eq!(strides(&[], 16, 0), []);
    }

    #[test]
    fn a_yaw_has_the_nearest_volume_that_is_kept() {
        let all =
            |yaws: u32, stride: u32| (0..yaws).map(move |yaw| kept(yaw, yaws, stride)).collect::<Vec<_>>();
        assert_eq!(all(4, 1), [0, 1, 2, 3]);
        assert_eq!(all(8, 4), [0, 0, 4, 4, 4, 4, 0, 0]);
        assert_eq!(all(6, 4), [0, 0, 4, 4, 4, 4]);
        assert_eq!(all(3, 3), [0, 0, 0]);
    }
}
