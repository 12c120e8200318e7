//! A forest as plain lists, for renderers on other processors: hierarchies, models, instances and ground exactly as the
//! rays of this one find them, so that there is one builder of hierarchies and one meaning of a mesh.

pub mod grids;

use flb_format::Placement;
use flb_format::surface::Law;
use flb_scene::texture::SrgbTable;
use flb_scene::{MaterialClass, Mesh, alpha::Coverage, waves::WaveField};
use obvhs::bvh2::Bvh2;

use super::{Forest, Ground, model::Model};
use crate::{
    Surfaces,
    backdrop::{HORIZON, ZENITH},
    sun,
};

/// Mean colour up to which a material counts as black, so that its surface is the mean one.
pub const BLACK: f32 = flb_format::surface::BLACK;
/// Brightness of plants that hide the sky from the ground, as a share of the sky's.
pub const LEAVES_BEFORE_SKY: f32 = super::fragments::LEAVES_BEFORE_SKY;
/// Refractive index of water.
pub const REFRACTIVE_INDEX: f32 = super::water::REFRACTIVE_INDEX;
/// Share of an even sky's light on level water that comes into it.
pub const INTO_FROM_SKY: f32 = super::water::INTO_FROM_SKY;
/// Linear colours of the sky at the horizon and overhead, at full brightness.
pub const SKY: [[f32; 3]; 2] = [HORIZON.to_array(), ZENITH.to_array()];

/// Squares of slopes, in variances, beyond which there is no glint.
pub const NO_GLINT: f64 = super::water::NO_GLINT;

/// Variance of the slopes that make the sun's glint on waves.
pub fn glint_variance(field: &WaveField) -> f64 {
    super::water::glint_variance(field)
}

/// sRGB bytes to linear light, for all 256 of them.
pub fn linear_from_srgb() -> [f32; 256] {
    SrgbTable::new().0
}

/// A box of a hierarchy, and what lies in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBox {
    /// Lowest coordinates.
    pub min: [f32; 3],
    /// Highest coordinates.
    pub max: [f32; 3],
    /// Index of the first of the two boxes within it, which are neighbours; or of its items in the tree's order.
    pub first: u32,
    /// Items; 0 for a box of boxes.
    pub count: u32,
}

/// A hierarchy of boxes. The first box is around all others.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatTree {
    /// Boxes, one at least.
    pub boxes: Vec<FlatBox>,
    /// Items in the order of the boxes that hold them.
    pub order: Vec<u32>,
    /// Largest number of boxes between the first and one without boxes in it, both counted.
    pub depth: u32,
}

/// A species.
pub struct FlatModel<'f> {
    /// Mesh of the model, metres.
    pub mesh: &'f Mesh,
    /// `[material]`
    pub classes: &'f [MaterialClass],
    /// `[material]`: what alpha leaves of it.
    pub coverage: &'f [Coverage],
    /// Surfaces of the `physical` shading: where they ask for light, and `[material]` what each does with it.
    pub surfaces: Option<(Surfaces, &'f [Law])>,
    /// Lowest and highest coordinates that rays enter at.
    pub box_m: [[f64; 3]; 2],
    /// Distance from its surface at which a ray starts, metres.
    pub lift_m: f32,
    /// Hierarchy over the mesh's triangles, metres.
    pub tree: FlatTree,
}

/// Instances as rays search them.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatStand {
    /// Origin of the tree's coordinates, world, metres.
    pub center_m: [f64; 3],
    /// Lowest and highest coordinates around all, of the world.
    pub box_m: [[f64; 3]; 2],
    /// Hierarchy over the instances, metres.
    pub tree: FlatTree,
}

impl Forest<'_> {
    /// The species, as rays find their triangles.
    pub fn flat_models(&self) -> impl ExactSizeIterator<Item = FlatModel<'_>> {
        self.models.iter().map(model)
    }

    /// Waves of the forest's water.
    pub fn wave_field(&self) -> Option<&WaveField> {
        self.water.as_ref()?.field.as_ref()
    }

    /// Placements of the forest's plants.
    pub fn placements(&self) -> impl ExactSizeIterator<Item = &Placement> + '_ {
        self.instances.iter().map(|placed| &placed.placement)
    }

    /// The instances, as rays find them.
    pub fn flat_stand(&self) -> FlatStand {
        let extent = &self.tree.extent;
        FlatStand {
            center_m: self.tree.center.to_array(),
            box_m: [extent.min.to_array(), extent.max.to_array()],
            tree: tree(&self.tree.tree),
        }
    }

    /// Ground on which the plants stand.
    pub fn ground(&self) -> Option<&Ground> {
        self.soil.as_ref().map(|soil| &soil.ground)
    }

    /// Distance above the ground at which a ray starts that leaves it, metres, and, for a height field, its lowest and
    /// highest coordinates.
    pub fn ground_reach(&self) -> Option<(f64, [[f64; 3]; 2])> {
        let soil = self.soil.as_ref()?;
        Some((soil.lift_m(), [soil.extent.min.to_array(), soil.extent.max.to_array()]))
    }
}

fn model<'f>(model: &'f Model<'_>) -> FlatModel<'f> {
    let extent = &model.hull.extent;
    FlatModel {
        mesh: model.scene.mesh,
        classes: model.scene.classes,
        coverage: &model.scene.coverage,
        surfaces: model.finish.as_ref().map(|finish| (finish.surfaces, finish.laws.as_slice())),
        box_m: [extent.min.to_array(), extent.max.to_array()],
        lift_m: sun::lift(&model.scene),
        tree: tree(&model.scene.hierarchy),
    }
}

fn tree(tree: &Bvh2) -> FlatTree {
    let boxes: Vec<FlatBox> = tree
        .nodes
        .iter()
        .map(|node| FlatBox {
            min: node.aabb.min.into(),
            max: node.aabb.max.into(),
            first: node.first_index,
            count: node.prim_count,
        })
        .collect();
    let depth = depth(&boxes);
    FlatTree { boxes, order: tree.primitive_indices.clone(), depth }
}

fn depth(boxes: &[FlatBox]) -> u32 {
    let (mut deepest, mut open) = (0, vec![(0u32, 1u32)]);
    while let Some((at, depth)) = open.pop() {
        deepest = deepest.max(depth);
        let found = &boxes[at as usize];
        if found.count == 0 {
            open.extend([(found.first, depth + 1), (found.first + 1, depth + 1)]);
        }
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forest::{Search, Species};
    use crate::{Shading, tests::grown};
    use flb_fixtures::PlantKind;
    use flb_format::Placement;

    #[test]
    fn every_triangle_lies_once_in_a_box_that_holds_it_and_no_box_is_deeper_than_said() {
        let mesh = grown(PlantKind::Oak, 2_000);
        let classes = [MaterialClass::Wood, MaterialClass::Leaf];
        let species = Species { mesh: &mesh, classes: &classes, shading: Shading::Paper };
        let one = Placement { species: 0, transform: flb_format::Transform::IDENTITY };
        let forest = Forest::prepare(&[species], &[one], None, Search::default()).unwrap();
        let model = forest.flat_models().next().unwrap();
        let mut seen = vec![0; mesh.triangles.len()];
        let (mut open, mut deepest) = (vec![(0u32, 1u32)], 0);
        while let Some((at, depth)) = open.pop() {
            deepest = deepest.max(depth);
            let found = model.tree.boxes[at as usize];
            if found.count == 0 {
                open.extend([(found.first, depth + 1), (found.first + 1, depth + 1)]);
            }
            for item in found.first..found.first + found.count {
                let triangle = model.tree.order[item as usize] as usize;
                seen[triangle] += 1;
                for vertex in mesh.triangles[triangle] {
                    let point = mesh.positions[vertex as usize];
                    let is_inside =
                        (0..3).all(|axis| found.min[axis] <= point[axis] && point[axis] <= found.max[axis]);
                    assert!(is_inside, "{point:?} in {found:?}");
                }
            }
        }
        assert!(seen.iter().all(|times| *times == 1) && deepest == model.tree.depth);
        assert_eq!(forest.flat_stand().tree.order, [0]);
    }
}
