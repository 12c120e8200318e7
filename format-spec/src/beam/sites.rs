//! The non-empty sites of a lattice, in the orders in which rays cross them.

use crate::Grid;

/// The non-empty sites of a lattice, for rays to find.
pub struct Sites {
    /// First and last coordinate of non-empty sites, per axis; first above last if there are none.
    bounds: [[usize; 2]; 3],
    /// The sites by layer along each axis.
    layers: [Layers; 3],
}

/// Non-empty sites by layer along an axis, then by row: the coordinate of the other axis of the larger stride.
#[derive(Default)]
pub(super) struct Layers {
    /// Coordinate of each row, and its first member.
    rows: Vec<(u32, u32)>,
    /// First row of each layer, and the number of all.
    first: Vec<usize>,
    /// Coordinate along the last axis, and place in the list of sites; by row, ascending.
    members: Vec<(u32, u32)>,
}

impl Layers {
    /// `sites` ascend; `axes` are that of the layers, of the rows, of the members.
    fn new(grid: &Grid, sites: &[u32], axes: [usize; 3]) -> Layers {
        let lattice = grid.lattice as usize;
        let coordinates = |&site: &u32| axes.map(|axis| grid.site(site as usize)[axis]);
        let mut ends = vec![0usize; lattice + 1];
        sites.iter().for_each(|site| ends[coordinates(site)[0] as usize + 1] += 1);
        for layer in 0..lattice {
            ends[layer + 1] += ends[layer];
        }
        // Stable: within a layer sites stay in their order, which is that of rows and members.
        let mut members = vec![(0, 0); sites.len()];
        let mut outer = vec![0; sites.len()];
        let mut next = ends.clone();
        for (place, site) in (0u32..).zip(sites) {
            let [layer, row, inner] = coordinates(site);
            let at = next[layer as usize];
            next[layer as usize] += 1;
            (members[at], outer[at]) = ((inner, place), row);
        }
        let (mut rows, mut first) = (Vec::new(), Vec::with_capacity(lattice + 1));
        for layer in 0..lattice {
            first.push(rows.len());
            for at in ends[layer]..ends[layer + 1] {
                if at == ends[layer] || outer[at] != outer[at - 1] {
                    rows.push((outer[at], at as u32));
                }
            }
        }
        first.push(rows.len());
        Layers { rows, first, members }
    }

    /// Returns the numbers of the rows of a layer, ascending.
    pub(super) fn rows_of(&self, layer: usize) -> std::ops::Range<usize> {
        self.first[layer]..self.first[layer + 1]
    }

    /// Returns the coordinate of a row, and its members: coordinate and place.
    pub(super) fn row(&self, row: usize) -> (usize, &[(u32, u32)]) {
        let (outer, from) = self.rows[row];
        let to = self.rows.get(row + 1).map_or(self.members.len(), |(_, next)| *next as usize);
        (outer as usize, &self.members[from as usize..to])
    }
}

impl Sites {
    /// Builds the index of the non-empty sites from their ascending indices.
    pub fn new(grid: &Grid, sites: &[u32]) -> Sites {
        let bounds = match grid.box_around(sites) {
            None => [[grid.lattice as usize, 0]; 3],
            Some([low, end]) => std::array::from_fn(|axis| [low[axis] as usize, end[axis] as usize - 1]),
        };
        let layers = [[0, 2, 1], [1, 2, 0], [2, 1, 0]].map(|axes| Layers::new(grid, sites, axes));
        Sites { bounds, layers }
    }

    /// Returns the first and last coordinate of non-empty sites, per axis; first above last if there are none.
    pub(super) fn bounds(&self) -> &[[usize; 2]; 3] {
        &self.bounds
    }

    /// Returns the sites by layer along an axis.
    pub(super) fn by_layer(&self, axis: usize) -> &Layers {
        &self.layers[axis]
    }
}
