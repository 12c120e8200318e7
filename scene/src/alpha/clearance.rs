//! How far each group of texels is from the nearest one with a present texel: one look-up then shows that a whole
//! square of texels is absent.

/// Per group (`[gy][gx]`), the distance to the nearest group that is not empty, in groups, the larger of that along
/// x and that along y; 0 for one that is not empty, at most 255. `across[axis]`: the last group borders on the
/// first one (a repeated image). A mirrored or clamped image shows nothing beyond its borders that is not as near
/// inside it.
pub(super) fn of_groups(
    groups: [usize; 2],
    across: [bool; 2],
    empty: impl Fn(usize, usize) -> bool,
) -> Vec<u8> {
    let [width, height] = groups;
    let mut clearance: Vec<u8> =
        (0..width * height).map(|at| if empty(at % width, at / width) { u8::MAX } else { 0 }).collect();
    // Distances spread from neighbour to neighbour, forwards and backwards, until nothing gets nearer: where every
    // group is at most 1 further than each of its neighbours, none is taken for further than it is.
    loop {
        let mut changed = false;
        for backwards in [false, true] {
            for y in 0..height {
                let y = if backwards { height - 1 - y } else { y };
                changed |= spread_along(&mut clearance, width, y, across[0], backwards);
                let next = if backwards { y.checked_sub(1) } else { (y + 1 < height).then_some(y + 1) };
                let around = if backwards { height - 1 } else { 0 };
                if let Some(next) = next.or(across[1].then_some(around)) {
                    changed |= spread_to(&mut clearance, width, y, next, across[0]);
                }
            }
        }
        if !changed {
            return clearance;
        }
    }
}

/// Spreads distances along row `y`.
fn spread_along(clearance: &mut [u8], width: usize, y: usize, across: bool, backwards: bool) -> bool {
    let row = &mut clearance[y * width..][..width];
    let mut before = match (across, backwards) {
        (false, _) => u8::MAX,
        (true, false) => row[width - 1],
        (true, true) => row[0],
    };
    let mut changed = false;
    for x in 0..width {
        let place = &mut row[if backwards { width - 1 - x } else { x }];
        let near = before.saturating_add(1);
        changed |= near < *place;
        *place = near.min(*place);
        before = *place;
    }
    changed
}

/// Spreads distances from row `y` to row `next`, straight and diagonally.
fn spread_to(clearance: &mut [u8], width: usize, y: usize, next: usize, across: bool) -> bool {
    if y == next {
        return false;
    }
    let mut changed = false;
    for x in 0..width {
        let left = if x > 0 {
            x - 1
        } else if across {
            width - 1
        } else {
            x
        };
        let right = if x + 1 < width {
            x + 1
        } else if across {
            0
        } else {
            x
        };
        let nearest = [left, x, right].map(|x| clearance[y * width + x]).into_iter().min().expect("three");
        let place = &mut clearance[next * width + x];
        let near = nearest.saturating_add(1);
        changed |= near < *place;
        *place = near.min(*place);
    }
    changed
}
