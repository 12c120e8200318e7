//! How far the light of a coded file is off on the mesh: the truth is traced once, and every file is asked as a
//! renderer asks it.

use flb_format::SpeciesMeta;
use flb_format::light::FieldKind;
use flb_format::mesh::ClassError;
use flb_runtime::{Daylight, InstanceLight, SpeciesLight};
use flb_scene::surface_points::SurfacePoint;
use flb_scene::{ClassedMesh, Observer};
use serde::Serialize;

use crate::EvalError;
use crate::figures::{ClassJudgement, MeshJudgement};
use crate::mesh::{MeshTruth, class_error, judged_surfaces};

/// Paths from each side of a point.
const SAMPLES: u32 = 32;

/// Paths on the mesh, or why there are none.
pub(super) struct OnMesh {
    points: Vec<SurfacePoint>,
    traced: Result<MeshTruth, String>,
}

/// Error of a file's light on the mesh, the suns' own beams left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshRow {
    /// Rms over leaves and wood by their area, suns and sky alike: of what falls on them, in % of its mean in truth.
    pub rms_percent: f64,
    /// The mean that is furthest off, of leaves or wood under suns or sky, in % of its truth; above 0 where it is too
    /// bright.
    pub bias_percent: f64,
    /// Name of that mean: "leaves under the sky" for example.
    pub furthest: String,
    /// Error on leaves.
    pub leaf: Option<ClassError>,
    /// Error on wood.
    pub wood: Option<ClassError>,
}

impl OnMesh {
    /// Traces paths at points, with the surfaces that a bake of the plant says; none for light that is not red, green
    /// and blue.
    pub(super) fn trace(
        classed: &ClassedMesh,
        points: &[SurfacePoint],
        meta: &SpeciesMeta,
        suns: &[[f64; 3]],
        observer: &dyn Observer,
    ) -> Result<OnMesh, EvalError> {
        let in_order = meta.band_count() == 3 && meta.color_bands() == Some([0, 1, 2]);
        let found = || meta.bands().collect::<Vec<_>>().join(", ");
        // Of fewer bands there are no surfaces in red, green and blue.
        let shown = match in_order {
            true => judged_surfaces(meta).map_err(|error| error.to_string()),
            false => Err(format!("found the bands {}, expected R, G and B in this order", found())),
        };
        let traced = match shown {
            Err(message) => Err(message),
            Ok(surfaces) => {
                let points = points.to_vec();
                Ok(MeshTruth::trace(classed, surfaces, points, suns, SAMPLES, &meta.name, observer)?)
            }
        };
        Ok(OnMesh { points: points.to_vec(), traced })
    }

    /// Where a renderer asks a file for the light at each point.
    pub(super) fn asked(&self, meta: &SpeciesMeta) -> Vec<[f32; 3]> {
        let offset_m = meta.solid_offset_m().map(|offset_m| offset_m as f32);
        match &self.traced {
            Ok(traced) => traced.asked(offset_m),
            Err(_) => self.points.iter().map(|point| point.position_m).collect(),
        }
    }

    /// The error of a file whose light under the suns is given; or why there is none.
    pub(super) fn error(
        &self,
        meta: &SpeciesMeta,
        species: &SpeciesLight<'_>,
        of_suns: &[InstanceLight<'_>],
    ) -> Result<Result<MeshRow, String>, EvalError> {
        let traced = match (&self.traced, meta.physical()) {
            (Err(reason), _) => return Ok(Err(reason.clone())),
            (_, None) => return Ok(Err("the light of the model paper is no irradiance".to_owned())),
            (_, Some((_, light))) if light.field == FieldKind::Total => {
                return Ok(Err("its fields hold the sun's beam, which is left out on the mesh".to_owned()));
            }
            (Ok(traced), Some(_)) => traced,
        };
        let night = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 1.0 };
        let sky = species.lit_by_in_model(&night)?;
        let light = |source: usize, point: [f32; 3], phi: &mut [f32; 3]| {
            of_suns.get(source).unwrap_or(&sky).at(point, phi);
        };
        let judged = traced.compare(&judged_surfaces(meta)?, &light);
        Ok(MeshRow::of(&judged).ok_or_else(|| "no light falls on the mesh in truth".to_owned()))
    }
}

impl MeshRow {
    /// The mean that is furthest off, in words.
    pub fn furthest_mean(&self) -> String {
        format!("{:+.1} ({})", self.bias_percent, self.furthest)
    }

    /// The error of light that was judged; `None` where no light falls on the mesh in truth.
    pub fn of(judged: &MeshJudgement) -> Option<MeshRow> {
        let classes = [("leaves", &judged.leaf), ("wood", &judged.wood)];
        let (mut squares, mut area, mut furthest) = (0.0, 0.0, None::<(f64, String)>);
        let mean = |bands: [f64; 3]| bands.iter().sum::<f64>() / 3.0;
        for (name, judgement) in classes.iter().filter_map(|(name, of)| Some((name, of.as_ref()?))) {
            let ClassJudgement { suns, sky, .. } = judgement;
            // As many as points of the class.
            let count = sky.as_ref().map_or(0.0, |sky| sky.count as f64);
            let sources = [("suns", suns), ("the sky", sky)];
            let sources: Vec<_> =
                sources.iter().filter_map(|(name, of)| Some((name, of.as_ref()?))).collect();
            for (source, figures) in &sources {
                let rms = mean(figures.rms);
                squares += count * rms * rms / sources.len() as f64;
                let bias = mean(figures.ratio) - 1.0;
                if furthest.as_ref().is_none_or(|(most, _)| bias.abs() > most.abs()) {
                    furthest = Some((bias, format!("{name} under {source}")));
                }
            }
            area += count;
        }
        let (bias, furthest) = furthest.filter(|_| area > 0.0)?;
        Some(MeshRow {
            rms_percent: 100.0 * libm::sqrt(squares / area),
            bias_percent: 100.0 * bias,
            furthest,
            leaf: class_error(&judged.leaf),
            wood: class_error(&judged.wood),
        })
    }
}
