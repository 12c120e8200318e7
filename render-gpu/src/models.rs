//! Species to the lists that rays walk: boxes, triangles in the order of their boxes, vertices.

use flb_render::forest::export::FlatModel;
use flb_render::forest::export::grids::FlatGrid;
use flb_scene::alpha::Coverage;
use flb_scene::mesh::sides::Side;

use crate::ForestError;
use crate::boxes::box_words;
use crate::grids::grid_words;
use crate::layout::{MAX_MODELS, TRIANGLE_BACK, TRIANGLE_CUT, TRIANGLE_FRONT, Words};
use crate::materials::Lookups;

/// All species.
pub(crate) struct Models {
    /// `Model`s.
    pub models: Words,
    /// `Box`es of all trees.
    pub boxes: Words,
    /// `Triangle`s in the order of their trees.
    pub triangles: Words,
    /// `Vertex`es.
    pub vertices: Words,
    pub lookups: Lookups,
    /// `[species]`: first triangle.
    pub first_triangle: Vec<u32>,
    /// `[place in the order]`: its number in the mesh.
    pub numbers: Vec<u32>,
    /// Depth of the deepest tree; 0 where all have grids.
    pub depth: u32,
}

impl Models {
    pub(crate) fn new() -> Models {
        Models {
            models: Words::default(),
            boxes: Words::default(),
            triangles: Words::default(),
            vertices: Words::default(),
            lookups: Lookups::new(),
            first_triangle: Vec::new(),
            numbers: Vec::new(),
            depth: 0,
        }
    }

    /// Adds a model whose triangles are found by its tree, or by a grid.
    pub(crate) fn add(&mut self, model: &FlatModel<'_>, grid: Option<&FlatGrid>) -> Result<(), ForestError> {
        let species = self.first_triangle.len() + 1;
        if species > MAX_MODELS {
            let (found, most) = (species as u64, MAX_MODELS as u64);
            return Err(ForestError::TooMany { what: "species", found, most });
        }
        let first_box = (self.boxes.0.len() / 8) as u32;
        let first_triangle = self.numbers.len() as u32;
        let first_vertex = (self.vertices.0.len() / 8) as u32;
        let first_material = self.lookups.add(model, first_vertex)?;
        let [low, high] = model.box_m;
        let root = match grid {
            None => {
                let in_tree = [first_box, first_triangle];
                model.tree.boxes.iter().for_each(|found| box_words(&mut self.boxes, found, in_tree));
                self.depth = self.depth.max(model.tree.depth);
                first_box
            }
            Some(grid) => grid_words(&mut self.lookups.words, grid, first_triangle),
        };
        self.models.rounded(low).whole(root).rounded(high).float(model.lift_m);
        let mesh = model.mesh;
        for &number in &model.tree.order {
            let material = mesh.triangle_material[number as usize];
            let is_cut = model.coverage[material as usize] != Coverage::Full;
            let corners = mesh.triangles[number as usize].map(|vertex| vertex + first_vertex);
            corners.into_iter().for_each(|vertex| {
                self.triangles.whole(vertex);
            });
            let cut = if is_cut { TRIANGLE_CUT } else { 0 };
            let side = match mesh.sheets.side(number as usize) {
                Side::Both => 0,
                Side::Front => TRIANGLE_FRONT,
                Side::Back => TRIANGLE_BACK,
            };
            self.triangles.whole(number).whole((first_material + material) | cut | side);
        }
        for (vertex, point) in mesh.positions.iter().enumerate() {
            let [u, v] = mesh.uvs.get(vertex).copied().unwrap_or([0.0; 2]);
            let normal = mesh.normals.get(vertex).copied().unwrap_or([0.0; 3]);
            self.vertices.floats(*point).float(u).floats(normal).float(v);
        }
        self.numbers.extend(&model.tree.order);
        self.first_triangle.push(first_triangle);
        Ok(())
    }

    /// The models, as many as the uniform holds.
    pub(crate) fn model_words(&self) -> Vec<u32> {
        let mut words = self.models.0.clone();
        words.resize(MAX_MODELS * 8, 0);
        words
    }
}
