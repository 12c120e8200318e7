//! Many plants of a few species, each with its baked light, seen by one camera: relit in no time when the sun moves.
//!
//! ```text
//! species, instances, ground -prepare-> Forest -trace(eye)-> Fragments -relight(sun, light)-> Picture
//! ```
//!
//! The papers' renderer on the CPU. A mesh is in memory once per species; a ray is taken into an instance's own frame
//! and meets the mesh there. What a camera sees does not depend on the sun, so [`Fragments`] are traced once, and
//! [`Forest::relight`] casts shadow rays and asks for light only. Where light comes from is the caller's, as for a
//! single plant: a closure, here from an instance and a point of its model. So this module knows no files.
//!
//! Instances and triangles can be found in several ways ([`Search`]): by bounding volume hierarchies, or as the papers
//! do by a uniform grid in each model, a grid over the picture for the camera's rays and one across the sun's rays for
//! shadows. All give the same fragments and shadows to the last bit; `cargo bench -p flb-render --bench forest`
//! compares them.
//!
//! Water ([`Water`]) mirrors what stands above it: a ray that comes to it is followed on, once, by the tree over all
//! instances.
//!
//! The same input gives the same bytes for any number of threads.

pub mod export;
mod eye;
pub(crate) mod fragments;
mod ground;
mod instance_tree;
mod marked;
mod model;
mod model_grid;
mod placed;
pub(crate) mod relight;
mod scenery;
pub(crate) mod squares;
mod sun_grid;
mod trace;
mod view_grid;
mod water;

use flb_format::Placement;
use flb_scene::{MaterialClass, Mesh};
use glam::{DMat3, DVec3};

pub use flb_format::eye::Eye;
pub use fragments::{Fragment, Fragments, MAX_RAYS, MAX_SKY_RAYS, View};
pub use ground::{Ground, Land};
pub use scenery::{Around, Scenery};
pub use water::Water;

pub use flb_scene::rays::TriangleHit;

use crate::scene::Scene;
use crate::shading::Units;
use crate::surfaces::Finish;
use crate::{RenderError, Shading};
use ground::GroundSurface;
use instance_tree::InstanceTree;
use model::Model;
use placed::Placed;
use water::WaterSurface;

/// A plant model, as it was baked.
pub struct Species<'a> {
    /// Mesh of the species, metres.
    pub mesh: &'a Mesh,
    /// Class of each material of the mesh.
    pub classes: &'a [MaterialClass],
    /// Shading model of the species, `paper` or `physical`: the same for all species of a scene.
    pub shading: Shading,
}

/// Search structure over the triangles of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ModelSearch {
    /// Search by a bounding volume hierarchy.
    #[default]
    Tree,
    /// Search by a uniform grid.
    Grid,
}

/// Search structure over the instances along a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstanceSearch {
    /// Search by a bounding volume hierarchy.
    Tree,
    /// Search by a grid that is flat, seen from where the rays start (the camera) or end (the sun).
    Grid,
}

/// Search structures for what a ray meets. They change no bits of a picture. The default is what `cargo bench -p
/// flb-render --bench forest` found the fastest; of the ways of shadow rays, which differ by less than their noise, the
/// one that has nothing to make anew for a sun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Search {
    /// Search in a model, for all rays.
    pub model: ModelSearch,
    /// Search of instances for rays from the camera.
    pub primary: InstanceSearch,
    /// Search of instances for rays towards the sun.
    pub shadow: InstanceSearch,
}

impl Default for Search {
    fn default() -> Search {
        Search { model: ModelSearch::Tree, primary: InstanceSearch::Grid, shadow: InstanceSearch::Tree }
    }
}

/// A scene made ready for rays.
pub struct Forest<'a> {
    models: Vec<Model<'a>>,
    instances: Vec<Placed>,
    tree: InstanceTree,
    soil: Option<GroundSurface>,
    water: Option<WaterSurface>,
    search: Search,
    /// Units that the shadings of all species have.
    units: Units,
}

/// A rotation's rows may be this far from orthonormal.
const ROTATION_TOLERANCE: f64 = 1e-6;
/// Largest magnitude of a coordinate, metres, and of a scale.
const MAX_COORDINATE: f64 = 1e9;

impl<'a> Forest<'a> {
    /// Makes a scene ready. `instances` are those of a scene file; their species are indices into `species`.
    ///
    /// # Errors
    /// [`RenderError`] for a mesh that cannot be used; surfaces out of range; species of both
    /// shadings; an instance of no species, out of range or with a rotation that is none; no instances; a ground out of
    /// range.
    pub fn prepare(
        species: &[Species<'a>],
        instances: &[Placement],
        ground: Option<Ground>,
        search: Search,
    ) -> Result<Forest<'a>, RenderError> {
        let units = Units::of(species.iter().map(|one| one.shading));
        if let Some(other) = species.iter().position(|one| one.shading.units() != species[0].shading.units())
        {
            return Err(RenderError::Shadings { species: other });
        }
        if let Some(ground) = &ground {
            ground.check()?;
        }
        let models = species
            .iter()
            .map(|one| Model::prepare(one.mesh, one.classes, &one.shading, search.model))
            .collect::<Result<Vec<_>, _>>()?;
        let placed = place(&models, instances)?;
        Ok(Forest {
            tree: InstanceTree::over(&placed),
            models,
            instances: placed,
            soil: ground.map(GroundSurface::new),
            water: None,
            search,
            units,
        })
    }

    /// The same with a ground. What was traced before is without it.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for a ground out of range.
    pub(crate) fn with_ground(self, ground: Ground) -> Result<Forest<'a>, RenderError> {
        ground.check()?;
        Ok(Forest { soil: Some(GroundSurface::new(ground)), ..self })
    }

    /// The mesh of its first species, and what that does with light, where it is known.
    pub(crate) fn first_model(&self) -> (&Scene<'a>, Option<&Finish>) {
        (&self.models[0].scene, self.models[0].finish.as_ref())
    }

    /// Adds water to the forest. What was traced before is without it.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for water out of range.
    pub fn with_water(self, water: Water) -> Result<Forest<'a>, RenderError> {
        water.check()?;
        Ok(Forest { water: Some(WaterSurface::new(water)), ..self })
    }

    /// Puts other instances in place of those that stand there. What was traced before is of the old ones.
    ///
    /// # Errors
    /// As [`Forest::prepare`] for instances; the old ones stand then.
    pub fn set_instances(&mut self, instances: &[Placement]) -> Result<(), RenderError> {
        self.instances = place(&self.models, instances)?;
        self.tree = InstanceTree::over(&self.instances);
        Ok(())
    }

    /// World from model of an instance, for a point.
    ///
    /// # Panics
    /// If there is no such instance.
    pub fn world_point_m(&self, instance: u32, point_model_m: [f32; 3]) -> [f64; 3] {
        self.instances[instance as usize].world_point(glam::Vec3::from(point_model_m).as_dvec3()).to_array()
    }

    /// Water of the forest.
    pub fn water(&self) -> Option<&Water> {
        self.water.as_ref().map(|surface| &surface.water)
    }

    /// The box around all plants: its lowest and its highest coordinates.
    pub fn bounds_m(&self) -> [[f64; 3]; 2] {
        [self.tree.extent.min.to_array(), self.tree.extent.max.to_array()]
    }
}

fn place(models: &[Model<'_>], instances: &[Placement]) -> Result<Vec<Placed>, RenderError> {
    if instances.is_empty() {
        return Err(RenderError::NoInstances);
    }
    let placed = instances.iter().enumerate().map(|(index, instance)| {
        check(index, instance, models.len())?;
        Ok(Placed::new(instance, &models[instance.species].hull))
    });
    placed.collect()
}

fn check(index: usize, instance: &Placement, species: usize) -> Result<(), RenderError> {
    let refuse = |what: String| Err(RenderError::Instance { instance: index, what });
    if instance.species >= species {
        return refuse(format!("species {} of {species}", instance.species));
    }
    if !instance.transform.position_m.iter().all(|v| v.abs() <= MAX_COORDINATE) {
        return refuse(format!(
            "stands at {:?}, expected coordinates up to 1e9 m",
            instance.transform.position_m
        ));
    }
    if !(1.0 / MAX_COORDINATE..=MAX_COORDINATE).contains(&instance.transform.scale) {
        return refuse(format!("scale {}, expected 1e-9 to 1e9", instance.transform.scale));
    }
    let rows = DMat3::from_cols_array_2d(&instance.transform.rotation);
    let off = rows.transpose() * rows - DMat3::IDENTITY;
    let is_rotation = rows.determinant() > 0.0
        && [off.x_axis, off.y_axis, off.z_axis]
            .iter()
            .all(|v| v.abs().cmple(DVec3::splat(ROTATION_TOLERANCE)).all());
    match is_rotation {
        true => Ok(()),
        false => refuse(format!(
            "rotation {:?}, expected one of unit length that mirrors nothing",
            instance.transform.rotation
        )),
    }
}

#[cfg(test)]
mod tests;
