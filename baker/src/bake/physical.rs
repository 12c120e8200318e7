//! A bake with the `physical` model: crown, discrete ordinates, and Monte Carlo to judge the fields by.

use flb_format::bases::BaseSet;
use flb_format::light::{FieldKind, Light, LightError, SunBasis};
use flb_format::material_surface::{self, MATERIALS};
use flb_format::matter::{LeafAngles, Surfaces};
use flb_format::model::Model;
use flb_format::{Medium, SpeciesFields, provenance};
use flb_scene::extents::walls;
use flb_scene::rays::RayMeshError;
use flb_scene::{ClassedMesh, Step};
use flb_transport::ordinates::{OrdinatesSettings, Surroundings};
use flb_transport::turbid::{BandScatter, scatter};

use super::job::{Start, check_storable, hold_medium};
use super::judge::judge;
use super::key::{Key, hex, of_crown};
use super::light::{self, LightSource};
use super::observer::Event;
use super::received::{on_matter, received_by};
use super::settings::unsolved_light;
use super::store::{self, Store, digest, fits};
use super::{BakeError, BakeSettings, Baked, Cloud, PhysicalSettings, Work};
use crate::crown::{Crown, CrownSettings, Recollision, measure_crown};
use crate::mean_light::set_means;
use crate::mixture::{self, MixedBand, mix};
use crate::solids::Solids;

/// From a plant to its fields.
pub(super) fn bake(
    start: Start,
    settings: &BakeSettings,
    physical: &PhysicalSettings,
    work: &Work,
) -> Result<Baked, BakeError> {
    let Start { plant, voxels, shape } = start;
    let all = &plant.surfaces;
    let names: Vec<&str> = all.bands.iter().map(|band| band.name.as_str()).collect();
    let bands = names.len();
    let (kept, left_out) = settings.wanted.choose(&names, work.species)?;
    let surfaces = Surfaces { bands: kept.iter().map(|&band| all.bands[band].clone()).collect() };
    let walls = walls(&plant.classed);
    let bases = bases_of(work, &physical.suns.basis(walls), settings.wanted.bases);
    let solve = physical.solve(settings.lattice, walls, bases);
    // Before the long work: there may be none.
    let gpu = light::gpu_of(&solve)?;
    let light = unsolved_light(&solve).of_leaves(&LeafAngles::spherical());
    let model = Model::Physical { surfaces: surfaces.clone(), light };
    let mut meta = super::job::describe(&plant, &voxels, model);
    if gpu.is_some() {
        meta.record(&provenance::SOLVER, light::solver_name(&solve).to_owned());
    }
    meta.record(&provenance::TOLERANCE, solve.tolerance);
    meta.record(&provenance::MAX_SWEEPS, solve.max_passes);
    meta.record(&provenance::PARTS, solve.parts);
    let own = plant.classed.mesh.materials.iter().map(|material| material.surface.as_ref());
    let own: Vec<_> = own.map(|surface| Some(surface?.of_bands(&kept))).collect();
    meta.settings.extend(material_surface::setting(&own).map(|value| (MATERIALS.to_owned(), value)));
    meta.leave_out(solve.bases.missing(), &left_out, &settings.wanted.reason);
    check_storable(&meta)?;
    let classed = &plant.classed;
    let medium = hold_medium(work, classed, &voxels, &shape)?;
    meta.grid = medium.grid;

    let crown_settings = CrownSettings { ignore_alpha: voxels.ignore_alpha, angles: physical.leaf_angles };
    let crown = crown(work, classed, &medium, &crown_settings, &shape)?;
    let scatter: Vec<BandScatter> = surfaces.bands.iter().map(scatter).collect();
    let recollision = Recollision::of(&crown.turbid, crown.factor, &medium);
    let mixed =
        mix(&plant, &kept, &crown.turbid, &scatter, voxels.ignore_alpha).map_err(RayMeshError::from)?;
    let (albedos, transmitted) = match &mixed {
        None => (recollision.albedos(&scatter), None),
        Some(bands) => {
            let transmitted: Vec<_> = bands.iter().map(|band| band.transmitted.clone()).collect();
            (recollision.albedos(bands), Some(transmitted))
        }
    };
    let surroundings =
        Surroundings { albedos: Some(&albedos), transmitted: transmitted.as_deref(), ..Surroundings::NONE };
    let digest = digest_of_all(work.store, &crown, &medium, mixed.as_deref())?;
    let source = LightSource { turbid: &crown.turbid, digest, surroundings: Some(surroundings) };
    let (mut solution, _) = light::solve(work, &source, &scatter, &solve)?;
    let monte_carlo =
        judge(work, physical.monte_carlo_suns, &crown.turbid, (&scatter, &albedos), &solution, &solve)?;
    let cloud =
        physical.keep_cloud.then(|| Cloud { fields: solution.fields.clone(), albedos: albedos.clone() });
    // Fields that hold the beam stay what they are, the light of a site: no surface is lit by the mean of a beam.
    if solve.field == FieldKind::Scattered {
        let received = match &mixed {
            None => received_by(&recollision, &scatter, &solution.total),
            Some(bands) => received_by(&recollision, bands, &solution.total),
        };
        on_matter(&mut solution.fields, &crown, &received, &solution.total.open_sky, &solve.suns);
        let solids = Solids {
            classed,
            ignore_alpha: voxels.ignore_alpha,
            turbid: &crown.turbid,
            medium: &medium,
            received: &received,
            total: &solution.total,
            suns: &solve.suns,
            seen_sky: &crown.seen_sky,
            walls,
        };
        work.run(Step::Solids, |progress| Ok(solids.light(&mut solution.fields, progress)?))?;
    }
    let weighed = |site: u32| (site, f64::from(crown.turbid.extinction(site as usize)));
    let matter: Vec<_> = crown.turbid.sites().into_iter().map(weighed).collect();
    set_means(&mut meta, &solution.fields, &solve.suns, &matter, &solution.total.near);
    let error = LightError { monte_carlo, ..light::error_of(&solution) };
    let converged = light::converged(&solution);
    let light = Light { error, ..unsolved_light(&solve) }.of_leaves(&crown.turbid.angles);
    meta.model = Model::Physical { surfaces, light };
    meta.record(&provenance::CROWN_FACTOR, crown.factor);
    meta.record(&provenance::CROWN_GAP, crown.gap);
    meta.record(&provenance::CONVERGED, converged);
    let whole = OrdinatesSettings { bases: BaseSet::ALL, ..solve.clone() };
    let solves = [solve.solves() * kept.len() as u32, whole.solves() * bands as u32];
    let fields = SpeciesFields { meta, medium, turbid: Some(crown.turbid), bases: solution.fields };
    Ok(Baked { fields, converged, bands, solves, cloud })
}

/// The bases to solve, of those that are wanted. Tells where none can be left out.
fn bases_of(work: &Work, suns: &SunBasis, wanted: BaseSet) -> BaseSet {
    if *suns == SunBasis::Lattice18 || wanted == BaseSet::ALL {
        return wanted;
    }
    let (species, left_out) = (work.species.to_owned(), wanted.missing());
    work.hear(Event::NeedsAll { species, suns: suns.clone(), left_out });
    BaseSet::ALL
}

/// Of all that light in the medium depends on, besides bands and settings.
fn digest_of_all(
    store: &dyn Store,
    crown: &Crown,
    medium: &Medium,
    mixed: Option<&[MixedBand]>,
) -> Result<[u8; 32], BakeError> {
    let mut both = blake3::Hasher::new();
    both.update(&digest(store, crown)?).update(&digest(store, medium)?);
    mixed.iter().for_each(|bands| _ = both.update(&mixture::digest(bands)));
    Ok(both.finalize().into())
}

/// The extinction, measured or taken from the store.
fn crown(
    work: &Work,
    classed: &ClassedMesh,
    medium: &Medium,
    settings: &CrownSettings,
    shape: &Key,
) -> Result<Crown, BakeError> {
    let key = Key::new("crown")
        .with("medium", hex(digest(work.store, medium)?))
        .with_all(shape.parts().iter().cloned())
        .with_all(of_crown(settings));
    work.run(Step::Crown, |progress| {
        let make = || Ok(measure_crown(&classed.mesh, &classed.classes, medium, settings, progress)?);
        let check = |crown: &Crown| {
            fits("grid", &crown.turbid.grid, &medium.grid)?;
            fits("sites with sides", &crown.seen_sky.sides.len(), &crown.turbid.sites().len())
        };
        store::reuse_or_make(work, Step::Crown, &key, check, make)
    })
}
