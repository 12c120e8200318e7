//! Sums over parts that threads may share: in halves, and halves of those. The order of additions is the same for any
//! number of threads.

use std::ops::AddAssign;

/// Times that the axes of a march are halved, so that more threads than groups of suns find work.
pub(super) const HALVINGS: u32 = 2;

/// Makes each part of `items` by `of`, and adds the second half to the first.
pub(super) fn by_halves<I: Sync, T: Send>(
    items: &[I],
    halvings: u32,
    of: &(impl Fn(&[I]) -> T + Sync),
    add: &(impl Fn(&mut T, T) + Sync),
) -> T {
    if halvings == 0 || items.len() < 2 {
        return of(items);
    }
    let (here, there) = items.split_at(items.len() / 2);
    let half = |items| by_halves(items, halvings - 1, of, add);
    let (mut sum, other) = rayon::join(|| half(here), || half(there));
    add(&mut sum, other);
    sum
}

/// Adds each value of another list to the one at its place.
pub(super) fn add_each<T: Copy + AddAssign>(sums: &mut [T], others: &[T]) {
    sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += *other);
}
