//! The light of a file against paths traced on its mesh.

use flb_format::SpeciesMeta;
use flb_format::light::FieldKind;
use flb_format::mesh::{ClassError, MeshError, SourceError};
use flb_render::irradiance::PointIrradiance;
use flb_render::irradiance::irradiance;
use flb_render::{RenderError, Surfaces};
use flb_runtime::{Daylight, InstanceLight, RuntimeError, SpeciesLight};
use flb_scene::surface_points::SurfacePoint;
use flb_scene::surface_points::surface_points;
use flb_scene::{ClassedMesh, Observer, Step};
use rayon::prelude::*;

use crate::EvalError;
use crate::figures::{BakedLight, ClassJudgement, Figures, MeshJudgement, compare};

/// Returns up to `count` points of leaf and wood, even by area.
///
/// # Errors
/// [`EvalError::NoSurface`]; [`EvalError::Alpha`].
pub fn judged_points(
    classed: &ClassedMesh,
    count: u32,
    ignore_alpha: bool,
) -> Result<Vec<SurfacePoint>, EvalError> {
    let points = surface_points(classed, count, ignore_alpha)?;
    if points.is_empty() { Err(EvalError::NoSurface) } else { Ok(points) }
}

/// Returns what leaves and wood reflect and transmit in the bands of a species, if its light can be judged on a mesh.
///
/// # Errors
/// [`EvalError::NoReflectance`]; [`EvalError::TotalField`].
pub fn judged_surfaces(meta: &SpeciesMeta) -> Result<Surfaces, EvalError> {
    match meta.physical() {
        None => Err(EvalError::NoReflectance),
        Some((_, light)) if light.field == FieldKind::Total => Err(EvalError::TotalField),
        Some((surfaces, _)) => Ok(Surfaces::of(surfaces, meta)),
    }
}

/// Judge of a file: points of the mesh, suns, and the file's light under each of them.
pub struct MeshJudge<'l> {
    /// Unit vectors towards the suns, model space.
    suns: Vec<[f64; 3]>,
    points: Vec<SurfacePoint>,
    surfaces: Surfaces,
    /// Of each sun alone, and last of the sky.
    light: Vec<InstanceLight<'l>>,
}

impl<'l> MeshJudge<'l> {
    /// Prepares the light of a file under suns (unit vectors towards them, model space), those of
    /// [`suns`](flb_transport::monte_carlo::judge::suns) for example, and under the sky. `surfaces` are those of
    /// [`judged_surfaces`].
    ///
    /// # Errors
    /// [`EvalError::NoSky`]; [`EvalError::Runtime`] for a sun whose bases were left out.
    pub fn new(
        light: &'l SpeciesLight<'_>,
        surfaces: Surfaces,
        points: Vec<SurfacePoint>,
        suns: Vec<[f64; 3]>,
        observer: &dyn Observer,
    ) -> Result<MeshJudge<'l>, EvalError> {
        if !light.has_sky() {
            return Err(EvalError::NoSky);
        }
        let light = Step::Prepare.run(observer, "", |_| {
            let of_suns = suns.iter().map(|&towards_sun| Daylight { towards_sun, sun: 1.0, sky: 0.0 });
            let of_sky = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 1.0 };
            let near = light.near();
            let prepared =
                |daylight: &Daylight| Ok(light.lit_by_in_model(daylight)?.prepared_by(near.as_ref()));
            let all: Vec<Daylight> = of_suns.chain([of_sky]).collect();
            all.par_iter().map(prepared).collect::<Result<Vec<_>, RuntimeError>>()
        })?;
        Ok(MeshJudge { suns, points, surfaces, light })
    }

    /// Returns unit vectors towards the suns, model space.
    pub fn suns(&self) -> &[[f64; 3]] {
        &self.suns
    }

    /// Returns the points of the mesh.
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// Returns what leaves and wood reflect and transmit.
    pub fn surfaces(&self) -> Surfaces {
        self.surfaces
    }

    /// Writes the fluence of a source at a point of model space: of a sun by its number, or of the sky, which comes
    /// after the last.
    ///
    /// # Panics
    /// If there is no such source.
    pub fn fluence(&self, source: usize, point: [f32; 3], phi: &mut [f32; 3]) {
        self.light[source].at(point, phi);
    }

    /// Traces `samples` paths from each side of each point, and compares. `name` is told to the observer.
    ///
    /// # Errors
    /// As [`MeshTruth::trace`].
    pub fn judge(
        &self,
        classed: &ClassedMesh,
        samples: u32,
        name: &str,
        observer: &dyn Observer,
    ) -> Result<MeshJudgement, EvalError> {
        let points = self.points.clone();
        let truth = MeshTruth::trace(classed, self.surfaces, points, &self.suns, samples, name, observer)?;
        let fluence = |source: usize, point: [f32; 3], phi: &mut [f32; 3]| self.fluence(source, point, phi);
        Ok(Step::Judge.run(observer, "", |_| truth.compare(&self.surfaces, &fluence)))
    }
}

/// Irradiance traced at points of a mesh, which any number of files is compared with.
pub struct MeshTruth {
    points: Vec<SurfacePoint>,
    truth: Vec<PointIrradiance>,
}

impl MeshTruth {
    /// Traces `samples` paths from each side of each point, under each sun and the sky.
    ///
    /// # Errors
    /// [`EvalError::Render`], as [`flb_render::irradiance::irradiance`].
    pub fn trace(
        ClassedMesh { mesh, classes }: &ClassedMesh,
        surfaces: Surfaces,
        points: Vec<SurfacePoint>,
        suns: &[[f64; 3]],
        samples: u32,
        name: &str,
        observer: &dyn Observer,
    ) -> Result<MeshTruth, EvalError> {
        let truth = Step::Trace.run(observer, name, |progress| -> Result<_, RenderError> {
            irradiance((mesh, classes), surfaces, &points, suns, samples, progress)
        })?;
        Ok(MeshTruth { points, truth })
    }

    /// Returns where a renderer asks for light at each point ([`PointIrradiance::asked_at`]).
    pub fn asked(&self, solid_offset_m: Option<f32>) -> Vec<[f32; 3]> {
        let asked = |(point, truth): (&SurfacePoint, &PointIrradiance)| {
            truth.asked_at(point.position_m, solid_offset_m)
        };
        self.points.iter().zip(&self.truth).map(asked).collect()
    }

    /// Compares light with the truth: that of each sun, and of the sky after the last.
    pub fn compare(&self, surfaces: &Surfaces, light: &BakedLight<'_>) -> MeshJudgement {
        compare(&self.points, &self.truth, surfaces, light)
    }
}

/// Numbers that a judgement was made with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JudgeSettings {
    /// Suns, 1 to [`MAX_SUNS`](flb_transport::monte_carlo::judge::MAX_SUNS).
    pub suns: u32,
    /// Points of leaf and wood, at most.
    pub points: u32,
    /// Paths from each side of each point, from 2.
    pub samples: u32,
}

impl Default for JudgeSettings {
    fn default() -> JudgeSettings {
        JudgeSettings { suns: 16, points: 2000, samples: 64 }
    }
}

/// Returns what a file keeps of a judgement.
pub(crate) fn mesh_error(
    judged: &MeshJudgement,
    JudgeSettings { suns, points, samples }: JudgeSettings,
) -> MeshError {
    MeshError { suns, points, samples, leaf: class_error(&judged.leaf), wood: class_error(&judged.wood) }
}

/// Returns the ratio and the rms of a class.
pub(crate) fn class_error(class: &Option<ClassJudgement>) -> Option<ClassError> {
    let of_source = |figures: &Option<Figures>| {
        figures.as_ref().map(|figures| SourceError { ratio: figures.ratio, rms: figures.rms }.rounded())
    };
    class.as_ref().map(|class| ClassError { suns: of_source(&class.suns), sky: of_source(&class.sky) })
}
