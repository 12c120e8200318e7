//! What blocks that overlap by a texel would take: each sample then lies in one block, and a texel of two blocks has
//! two values.
//!
//! No codec of ours has such blocks near geometry. Here they lie side by side in a field of twice the edge, so that the
//! coder of `classed` and its samples serve as they are: block `b` of an axis holds the texels `3 b` to `3 b + 3`.

use flb_format::{Field, Grid};

use crate::plant::Plant;

const EDGE: usize = 4;
const STRIDE: usize = EDGE - 1;

/// The fields with their blocks side by side.
pub(crate) fn plant(plant: &Plant) -> Plant {
    let (n, wide) = (plant.lattice as usize, 2 * plant.lattice as usize);
    let blocks = (n - 1).div_ceil(STRIDE);
    // Texel of the field that a texel of the wide one repeats; none beyond the last block.
    let texel = |t: usize| (t < EDGE * blocks).then(|| (t / EDGE * STRIDE + t % EDGE).min(n - 1));
    let from = |i: usize| -> Option<usize> {
        let [x, y, z] = [texel(i % wide)?, texel(i / wide % wide)?, texel(i / wide / wide)?];
        Some((z * n + y) * n + x)
    };
    let source: Vec<Option<usize>> = (0..wide * wide * wide).map(from).collect();
    let fields = plant.bases().iter().map(|(base, field)| {
        let mut out = Field::zeros(wide as u32, field.bands);
        for (band, out) in out.values_mut().chunks_exact_mut(source.len()).enumerate() {
            let values = field.band(band as u32);
            out.iter_mut().zip(&source).for_each(|(out, from)| *out = from.map_or(0.0, |from| values[from]));
        }
        (*base, out)
    });
    let mut wider = plant.fields.clone();
    wider.bases = fields.collect();
    wider.meta.grid = Grid { lattice: wide as u32, ..plant.fields.meta.grid };
    let non_empty = source.iter().map(|from| from.is_some_and(|from| plant.non_empty[from])).collect();
    Plant { lattice: wide as u32, non_empty, fields: wider }
}

/// Where a point of the field lies in the wide one.
pub(crate) fn place(lattice: u32, point: [f64; 3]) -> [f64; 3] {
    point.map(|x| {
        let texel = (x - 0.5).clamp(0.0, f64::from(lattice - 1));
        let cell = (texel as usize).min(lattice as usize - 2);
        (cell / STRIDE * EDGE + cell % STRIDE) as f64 + (texel - cell as f64) + 0.5
    })
}
