//! A species made ready for rays: its mesh, what it stays within, and the structure that its triangles are found by.

use flb_scene::{MaterialClass, Mesh};
use glam::Vec3;

use super::{
    ModelSearch,
    model_grid::ModelGrid,
    placed::{Extent, Hull},
};
use crate::{
    RenderError, Shading, Surfaces,
    scene::{Hit, Ray, Scene, TriangleHit},
    sun::lift,
    surfaces::Finish,
};

pub(crate) struct Model<'a> {
    pub hull: Hull,
    /// Laws of the surfaces, where these are known.
    pub finish: Option<Finish>,
    pub scene: Scene<'a>,
    /// In place of the scene's tree.
    grid: Option<ModelGrid>,
}

impl<'a> Model<'a> {
    pub(super) fn prepare(
        mesh: &'a Mesh,
        classes: &'a [MaterialClass],
        shading: &Shading,
        search: ModelSearch,
    ) -> Result<Model<'a>, RenderError> {
        let scene = Scene::prepare(mesh, classes)?;
        let finish = |surfaces: &Surfaces| {
            surfaces.check()?;
            Ok::<_, RenderError>(Finish::of(&scene, *surfaces))
        };
        let finish = shading.surfaces().map(finish).transpose()?;
        // Rays start at the box, so no triangle may lie in its faces.
        let extent = Extent { min: scene.min.as_dvec3(), max: scene.max.as_dvec3() };
        let extent = extent.padded(f64::from(lift(&scene)));
        let center = extent.center();
        let radius = scene.vertices().map(|vertex| {
            let offset = vertex.as_dvec3() - center;
            offset.x * offset.x + offset.z * offset.z
        });
        let radius = radius.fold(0.0, f64::max).sqrt() + f64::from(lift(&scene));
        let grid = (search == ModelSearch::Grid).then(|| ModelGrid::over(&scene));
        Ok(Model { hull: Hull { extent, radius }, finish, scene, grid })
    }

    /// The nearest present triangle up to the distance `far`.
    pub(super) fn find(&self, ray: Ray, far: f32) -> Option<TriangleHit> {
        match &self.grid {
            None => self.scene.find(ray, far, None),
            Some(grid) => grid.find(&self.scene, ray, far, None),
        }
    }

    /// Whether anything stands in the way other than triangle `except`.
    pub(super) fn is_blocked(&self, ray: Ray, except: Option<u32>) -> bool {
        match &self.grid {
            None => self.scene.is_blocked(ray, except),
            Some(grid) => grid.is_blocked(&self.scene, ray, except),
        }
    }

    /// What a ray that goes in a direction of the model's frame sees of a triangle.
    pub(super) fn surface(&self, looking: Vec3, found: &TriangleHit) -> Hit {
        self.scene.surface(looking, found)
    }

    /// Where a ray starts that leaves a surface on one side.
    pub(super) fn off(&self, point: Vec3, side: Vec3) -> Vec3 {
        point + side * lift(&self.scene)
    }
}
