//! Which bits a block gets: the class of `classed` that costs it least, or the width and the mask of `haar`.

use flb_format::blocks::classes::{ClassTable, DETAILS, Widths};
use flb_format::blocks::{MAX_WIDTH, TEXELS};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Widths are 0..WIDTHS bits.
pub(super) const WIDTHS: usize = MAX_WIDTH as usize + 1;
/// Classes that share a parent, on average.
const CLASSES_PER_PARENT: usize = 11;
/// Parents whose classes are tried.
const PARENTS_TRIED: usize = 4;

/// Details of a block in the order of classes: values in steps, and how much their errors count.
#[derive(Clone)]
pub(super) struct Details {
    /// `[place - 1]`
    pub value: [f32; DETAILS],
    /// `[place - 1]`
    pub weight: [f32; DETAILS],
}

/// Costs of a coefficient, by width; those behind [`WIDTHS`] are never asked for.
type Row = [f32; 16];
/// `[place - 1][width]`
pub(super) type Costs = [Row; DETAILS];

/// Nearest value that a field of `haar` can say, in half steps: even and not 0, of magnitude up to twice `half`.
#[inline(always)]
pub(super) fn nearest_kept(value: f32, half: f32) -> f32 {
    let round = (value + 0.5).floor();
    let round = if round == 0.0 { if value < 0.0 { -1.0 } else { 1.0 } } else { round };
    2.0 * round.max(-half).min(half)
}

/// Limits of the values of each width of `classed`, and where in a step they lie: down to `-limit`, in steps.
const LIMITS: (Row, Row, Row) = {
    let (mut low, mut high, mut middle) = ([0.0; 16], [0.0; 16], [0.0; 16]);
    let mut width = 1;
    while width < WIDTHS {
        let half = (1 << (width - 1)) as f32;
        (low[width], high[width], middle[width]) = (-half, half - 1.0, 0.5);
        width += 1;
    }
    (low, high, middle)
};

/// Cost of each width of each coefficient: weighted square error in steps, plus `lambda` a bit.
#[inline(always)]
pub(super) fn costs(details: &Details, lambda: f32) -> Costs {
    let (low, high, middle) = &LIMITS;
    let bits: Row = std::array::from_fn(|width| lambda * width as f32);
    let mut out = [[0.0; 16]; DETAILS];
    for (i, out) in out.iter_mut().enumerate() {
        let (value, weight) = (details.value[i], details.weight[i]);
        let down = value.floor();
        for width in 0..16 {
            let error = value - (down.max(low[width]).min(high[width]) + middle[width]);
            out[width] = weight * error * error + bits[width];
        }
    }
    out
}

/// Cost of a class.
#[inline(always)]
pub(super) fn cost(costs: &Costs, widths: &Widths) -> f32 {
    // Whole eights and a rest, so that the sums stay in registers.
    let mut sums = [0.0f32; 8];
    let (costs, last_costs) = costs.as_chunks::<8>();
    let (widths, last_widths) = widths.as_chunks::<8>();
    for (costs, widths) in costs.iter().zip(widths) {
        for i in 0..8 {
            sums[i] += costs[i][usize::from(widths[i]) % 16];
        }
    }
    for i in 0..DETAILS % 8 {
        sums[i] += last_costs[i][usize::from(last_widths[i]) % 16];
    }
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}

/// A table in two levels: parents, each the mean of alike classes, so that few classes need be tried.
pub(super) struct Chooser {
    /// `[class]`
    pub widths: Vec<Widths>,
    parents: Vec<(Widths, Vec<u16>)>,
}

impl Chooser {
    /// Over the classes of a table.
    pub(super) fn new(table: &ClassTable) -> Chooser {
        let widths = table.widths().to_vec();
        let count = widths.len().div_ceil(CLASSES_PER_PARENT);
        let mut of: Vec<usize> = (0..widths.len()).map(|i| i * count / widths.len()).collect();
        let mut parents = vec![[0u8; DETAILS]; count];
        for _ in 0..6 {
            for (p, parent) in parents.iter_mut().enumerate() {
                let members: Vec<&Widths> =
                    widths.iter().zip(&of).filter(|(_, of)| **of == p).map(|(w, _)| w).collect();
                for (i, width) in parent.iter_mut().enumerate() {
                    let sum: usize = members.iter().map(|w| usize::from(w[i])).sum();
                    *width = ((2 * sum + members.len()) / (2 * members.len().max(1))) as u8;
                }
            }
            for (of, widths) in of.iter_mut().zip(&widths) {
                let distance = |p: &Widths| -> u32 {
                    p.iter().zip(widths).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum()
                };
                *of = (0..count).min_by_key(|p| distance(&parents[*p])).expect("a parent");
            }
        }
        let members = |p: usize| (0..widths.len() as u16).filter(|i| of[usize::from(*i)] == p).collect();
        let parents = parents.into_iter().enumerate().map(|(p, widths)| (widths, members(p))).collect();
        Chooser { widths, parents }
    }

    /// The cheapest class of those tried; of equally cheap ones the first.
    #[inline(always)]
    pub(super) fn choose(&self, costs: &Costs) -> u16 {
        // The nearest parents that have classes, nearest first.
        let mut near = [(f32::INFINITY, 0usize); PARENTS_TRIED];
        for (p, (widths, classes)) in self.parents.iter().enumerate() {
            let cost = cost(costs, widths);
            if cost < near[PARENTS_TRIED - 1].0 && !classes.is_empty() {
                let mut at = PARENTS_TRIED - 1;
                while at > 0 && cost < near[at - 1].0 {
                    near[at] = near[at - 1];
                    at -= 1;
                }
                near[at] = (cost, p);
            }
        }
        let mut best = (f32::INFINITY, u16::MAX);
        for (_, p) in near.iter().filter(|(cost, _)| cost.is_finite()) {
            for &class in &self.parents[*p].1 {
                let cost = cost(costs, &self.widths[usize::from(class)]);
                if cost < best.0 || cost == best.0 && class < best.1 {
                    best = (cost, class);
                }
            }
        }
        best.1
    }
}

/// The width of `haar` and, by place, whether each coefficient is kept: those that are worth their bits and their bit
/// of the mask. A width of 0 keeps none.
#[inline(always)]
pub(super) fn choose_mask(details: &Details, lambda: f32) -> (u8, u64) {
    let mut best = (f32::INFINITY, 0u8, 0u64);
    for width in 0..=MAX_WIDTH {
        // The mask itself costs as much whatever it keeps.
        let (mut total, mut mask) = (if width > 0 { 64.0 * lambda } else { 0.0 }, 0u64);
        for i in 0..DETAILS {
            let (value, weight) = (details.value[i], details.weight[i]);
            let dropped = weight * value * value;
            let kept = if width > 0 {
                let error = value - 0.5 * nearest_kept(value, (1 << (width - 1)) as f32);
                weight * error * error + lambda * f32::from(width)
            } else {
                f32::INFINITY
            };
            if kept < dropped {
                mask |= 2 << i;
            }
            total += kept.min(dropped);
        }
        if total < best.0 {
            best = (total, if mask == 0 { 0 } else { width }, mask);
        }
    }
    (best.1, best.2)
}

/// Lloyd's iteration from a table: blocks to their cheapest class, then every class to the widths that are cheapest for
/// its blocks. The last classes are wide enough for blocks that no sample was like.
pub(super) fn train(samples: &[Details], start: &ClassTable, lambda: f32, rounds: usize) -> ClassTable {
    if samples.is_empty() {
        return start.clone();
    }
    let costed = if rounds > 0 { samples } else { &[] };
    let all: Vec<Costs> =
        costed.par_iter().map(|details| Arch::new().dispatch(AllCosts { details, lambda })).collect();
    // The last classes, the widest, make room for those that are wide enough for any block.
    let safe = if start.widths().len() >= 64 { 4 } else { 1 }.min(start.widths().len());
    let mut widths = start.widths()[..start.widths().len() - safe].to_vec();
    let count = widths.len();
    for _ in 0..if count > 0 { rounds } else { 0 } {
        let chosen: Vec<(f32, usize)> =
            all.par_iter().map(|costs| Arch::new().dispatch(Cheapest { costs, widths: &widths })).collect();
        let mut dearest: Vec<usize> = (0..chosen.len()).collect();
        dearest.sort_by(|a, b| chosen[*b].0.total_cmp(&chosen[*a].0).then(a.cmp(b)));
        let mut members = vec![Vec::new(); count];
        chosen.iter().enumerate().for_each(|(sample, (_, class))| members[*class].push(sample));
        // A class without blocks takes the shape of one of the dearest.
        for (k, members) in members.iter_mut().enumerate().filter(|(_, m)| m.is_empty()) {
            members.push(dearest[4 * k % dearest.len()]);
        }
        widths = members.par_iter().map(|members| best_widths(&all, members)).collect();
    }
    widths.extend(safety(samples).into_iter().take(safe));
    ClassTable::new(widths)
}

struct AllCosts<'a> {
    details: &'a Details,
    lambda: f32,
}

impl NullaryFnOnce for AllCosts<'_> {
    type Output = Costs;

    #[inline(always)]
    fn call(self) -> Costs {
        costs(self.details, self.lambda)
    }
}

/// Cost and number of the cheapest class, of equally cheap ones the first.
struct Cheapest<'a> {
    costs: &'a Costs,
    widths: &'a [Widths],
}

impl NullaryFnOnce for Cheapest<'_> {
    type Output = (f32, usize);

    #[inline(always)]
    fn call(self) -> (f32, usize) {
        let mut best = (f32::INFINITY, 0);
        for (k, widths) in self.widths.iter().enumerate() {
            let cost = cost(self.costs, widths);
            if cost < best.0 {
                best = (cost, k);
            }
        }
        best
    }
}

fn best_widths(all: &[Costs], members: &[usize]) -> Widths {
    let mut sums = [[0.0f32; 16]; DETAILS];
    for costs in members.iter().map(|m| &all[*m]) {
        for (sums, costs) in sums.iter_mut().zip(costs) {
            sums.iter_mut().zip(costs).for_each(|(s, c)| *s += c);
        }
    }
    sums.map(|sums| (0..WIDTHS).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).expect("a width") as u8)
}

/// Widths that 97 %, 99 %, 99.9 % and all of the samples need, the last with three bits to spare: the step that is
/// found may be finer than that of the samples.
fn safety(samples: &[Details]) -> Vec<Widths> {
    let mut classes = vec![[0u8; DETAILS]; 4];
    for i in 0..DETAILS {
        let mut needed: Vec<u8> = samples
            .iter()
            .map(|s| {
                let whole = libm::fabsf(s.value[i]) as u32; // below 2^(width - 1)
                (33 - whole.leading_zeros()).clamp(1, u32::from(MAX_WIDTH)) as u8
            })
            .collect();
        needed.sort_unstable();
        let at = |permille: usize| needed[(needed.len() - 1) * permille / 1000];
        for (class, permille) in classes.iter_mut().zip([1000, 999, 990, 970]) {
            class[i] = (at(permille) + 3 * u8::from(permille == 1000)).min(MAX_WIDTH);
        }
    }
    classes
}

/// Widths of coefficients by index, from those by place.
#[inline(always)]
pub(super) fn by_index(widths: &Widths, order: &[u8; TEXELS]) -> [u8; TEXELS] {
    let mut out = [0; TEXELS];
    (0..DETAILS).for_each(|i| out[usize::from(order[i + 1])] = widths[i]);
    out
}
