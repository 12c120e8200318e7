//! Which bits a block gets: the class of `classed` that costs it least, or the width and the mask of `haar`.

use flb_format::blocks::classes::{ClassTable, DETAILS, Widths};
use flb_format::blocks::{MAX_WIDTH, TEXELS};
use rayon::prelude::*;

/// Widths are 0..WIDTHS bits.
pub const WIDTHS: usize = MAX_WIDTH as usize + 1;
/// Classes that share a parent, on average.
const CLASSES_PER_PARENT: usize = 11;
/// Parents whose classes are tried.
const PARENTS_TRIED: usize = 4;

/// Details of a block in the order of classes: values in steps, and how much their errors count.
#[derive(Clone)]
pub struct Details {
    /// `[place - 1]`
    pub value: [f32; DETAILS],
    /// `[place - 1]`
    pub weight: [f32; DETAILS],
}

/// `[place - 1][width]`
pub type Costs = [[f32; WIDTHS]; DETAILS];

/// Nearest value that a field of `classed` can say, in half steps: odd, of magnitude below 2^width; 0 for no bits.
#[inline]
pub fn nearest(value: f32, width: u8) -> i32 {
    if width == 0 {
        return 0;
    }
    let limit = 1i32 << (width - 1);
    // Floor as a cast of a shifted positive value: the same on every machine, and fast.
    let down = ((value.clamp(-1e4, 1e4) + 16384.0) as i32) - 16384;
    2 * down.clamp(-limit, limit - 1) + 1
}

/// The same of `haar`: even and not 0, of magnitude up to 2^width.
#[inline]
pub fn nearest_kept(value: f32, width: u8) -> i32 {
    let limit = 1i32 << (width - 1);
    let round = ((value.clamp(-1e4, 1e4) + 16384.5) as i32) - 16384;
    let round = if round == 0 { if value < 0.0 { -1 } else { 1 } } else { round };
    2 * round.clamp(-limit, limit)
}

/// Cost of each width of each coefficient: weighted square error in steps, plus `lambda` a bit.
pub fn costs(details: &Details, lambda: f32) -> Costs {
    let mut out = [[0.0; WIDTHS]; DETAILS];
    for (i, out) in out.iter_mut().enumerate() {
        for (width, out) in out.iter_mut().enumerate() {
            let error = details.value[i] - 0.5 * nearest(details.value[i], width as u8) as f32;
            *out = details.weight[i] * error * error + lambda * width as f32;
        }
    }
    out
}

/// Cost of a class.
#[inline]
pub fn cost(costs: &Costs, widths: &Widths) -> f32 {
    let mut sums = [0.0f32; 4];
    for i in 0..DETAILS {
        sums[i % 4] += costs[i][usize::from(widths[i]) % WIDTHS];
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// A table in two levels: parents, each the mean of alike classes, so that few classes need be tried.
pub struct Chooser {
    /// `[class]`
    pub widths: Vec<Widths>,
    parents: Vec<(Widths, Vec<u16>)>,
}

impl Chooser {
    /// Over the classes of a table.
    pub fn new(table: &ClassTable) -> Chooser {
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
    pub fn choose(&self, costs: &Costs) -> u16 {
        let mut near: Vec<(f32, usize)> =
            self.parents.iter().enumerate().map(|(p, (widths, _))| (cost(costs, widths), p)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best = (f32::INFINITY, u16::MAX);
        let mut parents = near.iter();
        let mut tried = 0;
        // Rounding may leave a parent without classes, so count those that had some.
        while let Some((_, p)) = parents.next().filter(|_| tried < PARENTS_TRIED) {
            for &class in &self.parents[*p].1 {
                let cost = cost(costs, &self.widths[usize::from(class)]);
                if cost < best.0 || cost == best.0 && class < best.1 {
                    best = (cost, class);
                }
            }
            tried += usize::from(!self.parents[*p].1.is_empty());
        }
        best.1
    }
}

/// The width of `haar` and, by place, whether each coefficient is kept: those that are worth their bits and their bit of the
/// mask. A width of 0 keeps none.
pub fn choose_mask(details: &Details, lambda: f32) -> (u8, u64) {
    let mut best = (f32::INFINITY, 0u8, 0u64);
    for width in 0..=MAX_WIDTH {
        // The mask itself costs as much whatever it keeps.
        let (mut total, mut mask) = (if width > 0 { 64.0 * lambda } else { 0.0 }, 0u64);
        for i in 0..DETAILS {
            let (value, weight) = (details.value[i], details.weight[i]);
            let dropped = weight * value * value;
            let kept = if width > 0 {
                let error = value - 0.5 * nearest_kept(value, width) as f32;
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

/// Lloyd's iteration from a table: blocks to their cheapest class, then every class to the widths that are cheapest for its
/// blocks. The last classes are wide enough for blocks that no sample was like.
pub fn train(samples: &[Details], start: &ClassTable, lambda: f32, rounds: usize) -> ClassTable {
    if samples.is_empty() {
        return start.clone();
    }
    let costed = if rounds > 0 { samples } else { &[] };
    let all: Vec<Costs> = costed.par_iter().map(|s| costs(s, lambda)).collect();
    // The last classes, the widest, make room for those that are wide enough for any block.
    let safe = if start.widths().len() >= 64 { 4 } else { 1 }.min(start.widths().len());
    let mut widths = start.widths()[..start.widths().len() - safe].to_vec();
    let count = widths.len();
    for _ in 0..if count > 0 { rounds } else { 0 } {
        let chosen: Vec<(f32, usize)> = all
            .par_iter()
            .map(|costs| {
                let all = widths.iter().enumerate().map(|(k, w)| (cost(costs, w), k));
                all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).expect("a class")
            })
            .collect();
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

fn best_widths(all: &[Costs], members: &[usize]) -> Widths {
    let mut sums = [[0.0f32; WIDTHS]; DETAILS];
    for costs in members.iter().map(|m| &all[*m]) {
        for (sums, costs) in sums.iter_mut().zip(costs) {
            sums.iter_mut().zip(costs).for_each(|(s, c)| *s += c);
        }
    }
    sums.map(|sums| (0..WIDTHS).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).expect("a width") as u8)
}

/// Widths that 97 %, 99 %, 99.9 % and all of the samples need, the last with a bit to spare.
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
            class[i] = (at(permille) + u8::from(permille == 1000)).min(MAX_WIDTH);
        }
    }
    classes
}

/// Widths of coefficients by index, from those by place.
pub fn by_index(widths: &Widths, order: &[u8; TEXELS]) -> [u8; TEXELS] {
    let mut out = [0; TEXELS];
    (0..DETAILS).for_each(|i| out[usize::from(order[i + 1])] = widths[i]);
    out
}
