//! A species' matter as points, few and near enough together for the sites of a scene.
//!
//! A fine site is far smaller than a scene's. Sites are merged by twos until they are half of one, into a point at the
//! middle of their matter, so that what a forest of thousands costs does not depend on how finely its species were
//! baked. Where sites are larger than that, they are cut.

use flb_format::matter::TurbidMedium;

/// Optical area that one point stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grain {
    /// Metres, model space.
    pub at_m: [f64; 3],
    /// Extinction times volume, m^2: leaf, wood.
    pub area_m2: [f64; 2],
}

/// Most parts that a site is cut into along an edge.
const MAX_PARTS: u32 = 8;

/// The grains of a medium, none standing for more than `edge_m` along any axis, in a fixed order.
pub(super) fn grains(turbid: &TurbidMedium, edge_m: f64) -> Vec<Grain> {
    let n = turbid.grid.lattice as usize;
    let spacing_m = turbid.grid.spacing_m;
    let mut block = 1;
    while block < n && 2.0 * block as f64 * spacing_m <= edge_m {
        block *= 2;
    }
    if block == 1 && spacing_m > edge_m {
        return cut(turbid, edge_m);
    }
    let volume_m3 = spacing_m * spacing_m * spacing_m;
    let blocks = n / block;
    // [x, y, z] of area, leaf, wood.
    let mut sums = vec![[0.0_f64; 5]; blocks * blocks * blocks];
    for site in turbid.sites() {
        let site = site as usize;
        let at = turbid.grid.site(site);
        let middle_m = turbid.grid.middle_m(at);
        let at = at.map(|c| c as usize);
        let place = ((at[2] / block) * blocks + at[1] / block) * blocks + at[0] / block;
        let area =
            [turbid.leaf_per_m[site], turbid.wood_per_m[site]].map(|per_m| f64::from(per_m) * volume_m3);
        let both = area[0] + area[1];
        let sum = &mut sums[place];
        for axis in 0..3 {
            sum[axis] += both * middle_m[axis];
        }
        sum[3] += area[0];
        sum[4] += area[1];
    }
    let grain = |[x, y, z, leaf, wood]: [f64; 5]| {
        let both = leaf + wood;
        Grain { at_m: [x / both, y / both, z / both], area_m2: [leaf, wood] }
    };
    sums.into_iter().filter(|sum| sum[3] + sum[4] > 0.0).map(grain).collect()
}

/// Sites cut into parts of `edge_m` or less.
fn cut(turbid: &TurbidMedium, edge_m: f64) -> Vec<Grain> {
    let spacing_m = turbid.grid.spacing_m;
    let parts = (libm::ceil(spacing_m / edge_m) as u32).min(MAX_PARTS);
    let share = spacing_m * spacing_m * spacing_m / f64::from(parts * parts * parts);
    let mut grains = Vec::new();
    for site in turbid.sites() {
        let site = site as usize;
        let at = turbid.grid.site(site);
        let area_m2 =
            [turbid.leaf_per_m[site], turbid.wood_per_m[site]].map(|per_m| f64::from(per_m) * share);
        for part in 0..parts * parts * parts {
            let within = [part % parts, part / parts % parts, part / (parts * parts)];
            let along = |axis: usize| {
                let offset = (f64::from(within[axis]) + 0.5) / f64::from(parts);
                f64::from(at[axis]) + offset
            };
            let at_m = turbid.grid.model_from_lattice(std::array::from_fn(along));
            grains.push(Grain { at_m, area_m2 });
        }
    }
    grains
}
