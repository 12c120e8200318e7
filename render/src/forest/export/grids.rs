//! The papers' grids as plain lists, beside the hierarchies: of triangles in each model, of instances over a picture,
//! and across the sun's rays.

use glam::DVec3;

use crate::RenderError;
use crate::forest::{Forest, View, eye, model_grid, placed::Extent, sun_grid, view_grid};

/// Pixels along the edge of a cell of a [`FlatViewGrid`].
pub const VIEW_CELL_PX: u32 = view_grid::CELL_PX;
/// A triangle is listed in cells of a [`FlatGrid`] that it misses by this share of a cell.
pub const MODEL_PAD: f32 = model_grid::PAD;

/// A uniform grid over a model's box.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatGrid {
    /// Lowest coordinates of the grid, metres.
    pub min: [f32; 3],
    /// Cells per metre along each axis.
    pub per_m: [f32; 3],
    /// Cells along each axis.
    pub count: [u32; 3],
    /// `[z][y][x]` and one more: where the list of each cell starts.
    pub starts: Vec<u32>,
    /// Triangles, by their place in the order of the model's tree.
    pub lists: Vec<u32>,
}

/// Instances that each cell of a picture may see.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatViewGrid {
    /// Cells in a row.
    pub columns: u32,
    /// `[row][column]` and one more: where the list of each cell starts.
    pub starts: Vec<u32>,
    /// Distance from the eye to the box in metres, and the instance; nearest first in each cell.
    pub lists: Vec<(f64, u32)>,
}

/// Instances that rays towards a sun may meet, by where these pass a plane across them.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatSunGrid {
    /// Unit vectors across the rays.
    pub across: [[f64; 3]; 2],
    /// Along both, where the first cell begins, in metres.
    pub low: [f64; 2],
    /// Cells per metre.
    pub per_m: f64,
    /// Cells along both.
    pub count: [u32; 2],
    /// `[row][column]` and one more: where the list of each cell starts.
    pub starts: Vec<u32>,
    /// Distance towards the sun that a box reaches, and its instance; farthest first in each cell.
    pub lists: Vec<(f64, u32)>,
}

/// The boxes of all instances, by their numbers.
pub struct FlatBoxes(Vec<Extent>);

impl Forest<'_> {
    /// A grid for each species, whatever this forest finds its triangles by.
    pub fn flat_grids(&self) -> impl ExactSizeIterator<Item = FlatGrid> + '_ {
        self.models.iter().map(|model| {
            let grid = model_grid::ModelGrid::over(&model.scene);
            FlatGrid {
                min: grid.min.to_array(),
                per_m: grid.per_m.to_array(),
                count: grid.count.to_array(),
                starts: grid.starts,
                lists: grid.lists,
            }
        })
    }

    /// Boxes of the instances, of which grids are made.
    pub fn flat_boxes(&self) -> FlatBoxes {
        FlatBoxes(self.instances.iter().map(|placed| placed.extent).collect())
    }
}

impl FlatBoxes {
    /// Makes the grid of a picture.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for an eye that sees nothing.
    pub fn view_grid(&self, view: &View) -> Result<FlatViewGrid, RenderError> {
        let size = [view.width, view.height];
        let lens = eye::lens(&view.eye, size)?;
        let grid = view_grid::ViewGrid::new(self.0.iter().copied(), &lens, size);
        Ok(FlatViewGrid { columns: grid.columns, starts: grid.starts, lists: grid.lists })
    }

    /// Makes the grid of a sun that stands in a direction (unit); boxes are listed in cells that they miss by `pad` of
    /// a cell, from 0 on.
    pub fn sun_grid(&self, towards_sun: [f64; 3], pad: f64) -> FlatSunGrid {
        let grid = sun_grid::SunGrid::new(self.0.iter().copied(), DVec3::from(towards_sun), pad);
        FlatSunGrid {
            across: grid.across.map(|axis| axis.to_array()),
            low: grid.low,
            per_m: grid.per_m,
            count: grid.count,
            starts: grid.starts,
            lists: grid.lists,
        }
    }
}
