//! Instances and the tree over them to lists, in the tree's order.

use flb_format::{Placement, Transform};
use flb_gpu::Gpu;
use flb_render::forest::Forest;
use flb_render::forest::export::grids::FlatBoxes;

use crate::ForestError;
use crate::boxes::box_words;
use crate::buffers::storage;
use crate::layout::{STACK, Words, split};

/// What stands where.
pub(crate) struct Stand {
    /// Placements of plants in the tree's order.
    pub plants: Vec<Placement>,
    /// `[place in the order]`: number in the scene.
    pub numbers: Vec<u32>,
    /// Origin of places, world, metres.
    pub center_m: [f64; 3],
    /// Box around all plants, in the world.
    pub box_m: [[f64; 3]; 2],
    /// Boxes around each plant, by their numbers, for grids.
    pub around: FlatBoxes,
    pub boxes: wgpu::Buffer,
    pub instances: wgpu::Buffer,
}

impl Stand {
    /// `depth` is that of the deepest model's tree.
    pub(crate) fn new(gpu: &Gpu, forest: &Forest<'_>, depth: u32) -> Result<Stand, ForestError> {
        let flat = forest.flat_stand();
        let deepest = u64::from(flat.tree.depth) + u64::from(depth);
        if deepest > u64::from(STACK) {
            let what = "boxes within each other, of the stand and of a model";
            return Err(ForestError::TooMany { what, found: deepest, most: STACK.into() });
        }
        let all: Vec<Placement> = forest.placements().copied().collect();
        let plants: Vec<Placement> = flat.tree.order.iter().map(|&number| all[number as usize]).collect();
        let (mut boxes, mut instances) = (Words::default(), Words::default());
        flat.tree.boxes.iter().for_each(|found| box_words(&mut boxes, found, [0, 0]));
        for (plant, &number) in plants.iter().zip(&flat.tree.order) {
            let Transform { rotation, position_m, scale } = plant.transform;
            let place: [[f32; 2]; 3] =
                std::array::from_fn(|axis| split(position_m[axis] - flat.center_m[axis]));
            for (axis, [high, _]) in place.into_iter().enumerate() {
                // A row of the rotation that takes directions of the world to the model.
                instances.rounded(rotation.map(|row| row[axis])).float(high);
            }
            let low = place.map(|[_, low]| low);
            instances.floats(low).rounded([scale]).whole(plant.species as u32).whole(number);
            instances.whole(0).whole(0);
        }
        let remedy = "with fewer instances";
        Ok(Stand {
            plants,
            center_m: flat.center_m,
            box_m: flat.box_m,
            around: forest.flat_boxes(),
            boxes: storage(gpu, "boxes of the stand", &boxes.0, remedy)?,
            instances: storage(gpu, "instances", &instances.0, remedy)?,
            numbers: flat.tree.order,
        })
    }
    /// `[number in the scene]`: place in the order.
    pub(crate) fn places(&self) -> Vec<u32> {
        let mut places = vec![0; self.numbers.len()];
        for (place, &number) in (0..).zip(&self.numbers) {
            places[number as usize] = place;
        }
        places
    }
}
