//! Light of a species against paths traced on its mesh: what `flb judge` and `flb bake --judge` share.

use flb_format::{ClassError, MeshError, SourceError};
use flb_render::irradiance::PointIrradiance;
use flb_render::judge::{BakedLight, ClassJudgement, Figures, MeshJudgement, judge};
use flb_render::{RenderError, Surfaces, irradiance};
use flb_runtime::{Daylight, InstanceLight, SpeciesLight};
use flb_scene::{ClassedMesh, SurfacePoint, surface_points};
use flb_transport::monte_carlo::judge::suns;
use rayon::prelude::*;

use crate::exit::{Failure, USAGE, VERDICT};
use crate::stages::Stages;

/// Points, suns and the light of a file under each of them.
pub(crate) struct Judging<'l> {
    /// Towards the suns, model space.
    pub suns: Vec<[f64; 3]>,
    pub points: Vec<SurfacePoint>,
    surfaces: Surfaces,
    /// Of each sun alone, and last of the sky.
    light: Vec<InstanceLight<'l>>,
}

/// Points of leaves and wood, even by area.
pub(crate) fn points(
    classed: &ClassedMesh,
    count: u32,
    ignore_alpha: bool,
) -> Result<Vec<SurfacePoint>, Failure> {
    let points = surface_points(classed, count, ignore_alpha).map_err(RenderError::from)?;
    if points.is_empty() {
        let message = "found no point of leaf or wood to judge light at, expected some surface";
        return Err(Failure::new(VERDICT, message));
    }
    Ok(points)
}

impl<'l> Judging<'l> {
    /// Prepares the near beams of `count` suns.
    pub(crate) fn new(
        light: &'l SpeciesLight<'_>,
        surfaces: Surfaces,
        points: Vec<SurfacePoint>,
        count: u32,
        stages: &Stages,
    ) -> Result<Judging<'l>, Failure> {
        if !light.has_sky() {
            let message = "found no light of the sky (base 0 was left out), flb judge expects it";
            return Err(Failure::new(USAGE, message));
        }
        let suns = suns(count as usize);
        let light = stages.run("prepare", "", |_| {
            let of_suns = suns.iter().map(|&towards_sun| Daylight { towards_sun, sun: 1.0, sky: 0.0 });
            let of_sky = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 1.0 };
            let near = light.near();
            let prepared =
                |daylight: &Daylight| Ok(light.lit_by_in_model(daylight)?.prepared_by(near.as_ref()));
            let all: Vec<Daylight> = of_suns.chain([of_sky]).collect();
            all.par_iter().map(prepared).collect::<Result<Vec<_>, Failure>>()
        })?;
        Ok(Judging { suns, points, surfaces, light })
    }

    /// The fluence of a source at a point of model space.
    pub(crate) fn fluence(&self, source: usize, point: [f32; 3], phi: &mut [f32; 3]) {
        self.light[source].at(point, phi);
    }

    /// Traces the truth and compares.
    pub(crate) fn judge(
        &self,
        classed: &ClassedMesh,
        samples: u32,
        (name, stages): (&str, &Stages),
    ) -> Result<MeshJudgement, Failure> {
        let points = self.points.clone();
        let traced = Traced::new(classed, self.surfaces, points, &self.suns, samples, (name, stages))?;
        let fluence = |source: usize, point: [f32; 3], phi: &mut [f32; 3]| self.fluence(source, point, phi);
        stages.run("judge", "", |_| Ok(traced.compare(&self.surfaces, &fluence)))
    }
}

/// The truth at points of a mesh, for any number of files.
pub(crate) struct Traced {
    points: Vec<SurfacePoint>,
    truth: Vec<PointIrradiance>,
}

impl Traced {
    /// Follows paths under each sun and the sky.
    pub(crate) fn new(
        classed: &ClassedMesh,
        surfaces: Surfaces,
        points: Vec<SurfacePoint>,
        suns: &[[f64; 3]],
        samples: u32,
        (name, stages): (&str, &Stages),
    ) -> Result<Traced, Failure> {
        let ClassedMesh { mesh, classes } = classed;
        let truth = stages.run("trace", name, |progress| {
            irradiance((mesh, classes), surfaces, &points, suns, samples, progress)
        })?;
        Ok(Traced { points, truth })
    }

    /// Where a renderer asks for light at each point ([`PointIrradiance::asked_at`]).
    pub(crate) fn asked(&self, solid_offset_m: Option<f32>) -> Vec<[f32; 3]> {
        let asked = |(point, truth): (&SurfacePoint, &PointIrradiance)| {
            truth.asked_at(point.position_m, solid_offset_m)
        };
        self.points.iter().zip(&self.truth).map(asked).collect()
    }

    /// How far light is off: that of each sun, and of the sky after the last.
    pub(crate) fn compare(&self, surfaces: &Surfaces, light: &BakedLight<'_>) -> MeshJudgement {
        judge(&self.points, &self.truth, surfaces, light)
    }
}

/// What a file keeps of it.
pub(crate) fn kept(judged: &MeshJudgement, [suns, points, samples]: [u32; 3]) -> MeshError {
    MeshError { suns, points, samples, leaf: of_class(&judged.leaf), wood: of_class(&judged.wood) }
}

/// The ratio and the rms of a class.
pub(crate) fn of_class(class: &Option<ClassJudgement>) -> Option<ClassError> {
    let of_source = |figures: &Option<Figures>| {
        figures.as_ref().map(|figures| SourceError { ratio: figures.ratio, rms: figures.rms }.rounded())
    };
    class.as_ref().map(|class| ClassError { suns: of_source(&class.suns), sky: of_source(&class.sky) })
}
