//! One choice: baked as `flb bake` bakes it, coded in every way asked for, and measured.

use flb_baker::bake::{BakeObserver, Baked, NoStore, bake};
use flb_format::SpeciesFields;
use flb_packer::{encode_species, write_library_to};
use flb_runtime::Library;
use flb_scene::surface_points::SurfacePoint;
use flb_scene::{Plant, Step};
use flb_transport::turbid::scatter;

use super::choice::{Choice, FINEST_STORE, Solve, Store, finest_of_paper};
use super::heap::Heap;
use super::meter::{Cost, Meter};
use super::on_mesh::OnMesh;
use super::row::Row;
use super::sample::{self, Finest, Prepared, Sampled};
use super::settings::TradeSettings;
use super::truth::Truth;
use crate::EvalError;

/// What every measurement needs.
pub(super) struct Bench<'a> {
    pub settings: &'a TradeSettings,
    pub heap: &'a dyn Heap,
    pub observer: &'a dyn BakeObserver,
    pub points: &'a [SurfacePoint],
    pub suns: &'a [[f64; 3]],
}

/// What all measurements share, from the first on.
#[derive(Default)]
pub(super) struct OfAll {
    pub finest: Option<Finest>,
    /// Of the papers' model.
    finest_of_paper: Option<Finest>,
    on_mesh: Option<OnMesh>,
}

/// What the measurements of one lattice share.
#[derive(Default)]
pub(super) struct OfLattice {
    prepared: Prepared,
    truth: Option<Result<Truth, String>>,
}

impl OfLattice {
    /// Photons of every sun, band and seed; or why none were traced.
    pub(super) fn photons(&self) -> Result<u64, String> {
        match &self.truth {
            Some(Ok(truth)) => Ok(truth.photons),
            Some(Err(reason)) => Err(reason.clone()),
            None => Err(NO_MEDIUM.to_owned()),
        }
    }
}

const NO_MEDIUM: &str =
    "no solve of the physical model was tried at this lattice, so there is no medium to trace in";

impl Bench<'_> {
    /// Bakes and measures the rows of a choice, with the plant that `plants` gives. The first call makes what all
    /// share.
    pub(super) fn measure<E: From<EvalError>>(
        &self,
        choice: &Choice,
        plants: &dyn Fn() -> Result<Plant, E>,
        of_lattice: &mut OfLattice,
        of_all: &mut OfAll,
    ) -> Result<Vec<(Store, Row)>, E> {
        let held = self.heap.used_bytes();
        let meter = Meter::new(self.observer, self.heap);
        let plant = Step::Import.run(&meter, "", |_| plants())?;
        let mut baked = self.bake(choice, plant, &meter)?;
        let cost = meter.cost(held);
        let own = self.heap.used_bytes().saturating_sub(held);
        self.trace(&baked, of_lattice)?;
        let OfAll { finest, finest_of_paper, on_mesh } = of_all;
        if on_mesh.is_none() {
            let (classed, meta) = (plants()?.classed, &baked.fields.meta);
            *on_mesh = Some(OnMesh::trace(&classed, self.points, meta, self.suns, self.observer)?);
        }
        let on_mesh = on_mesh.as_ref().expect("it was just traced");
        let truth = of_lattice.truth.as_ref();
        let error = truth.and_then(|truth| truth.as_ref().ok()).map(|truth| {
            let cloud = baked.cloud.as_mut().map(|cloud| &mut cloud.fields);
            let solved = cloud.unwrap_or(&mut baked.fields.bases);
            truth.error(&choice.solve.transport, solved)
        });
        drop(baked.cloud.take());
        let missing = match (truth, &error) {
            (None, _) => Some(NO_MEDIUM.to_owned()),
            (Some(Err(reason)), _) => Some(reason.clone()),
            (_, Some(None)) => Some("the plant scatters no light in the medium of this lattice".to_owned()),
            _ => None,
        };

        let bands = baked.fields.meta.band_count();
        let names: Vec<String> =
            (0..bands).map(|band| baked.fields.meta.model.band(band).to_owned()).collect();
        let converged = baked.converged;
        let mut fields = Some(baked.fields);
        // The fields' last code is made without loss: it is the largest, and nothing is kept beside it.
        let mut stores = choice.stores.clone();
        stores.sort_by_key(|store| *store == FINEST_STORE);
        let mut rows = Vec::new();
        for (at, store) in stores.iter().enumerate() {
            let coded =
                Coded::new(&mut fields, store, at + 1 == stores.len(), own, (self, on_mesh), of_lattice)?;
            let cost = cost.and(&coded.cost);
            if finest.is_none() && *store == FINEST_STORE {
                let beam = sample::beam(&coded.library, self.suns, on_mesh, &mut of_lattice.prepared)?;
                *finest = Some(Finest { scattered: coded.sampled.light.clone(), beam, bands });
            }
            if finest_of_paper.is_none() && (choice.solve, *store) == (self.finest_of_paper(), FINEST_STORE) {
                let beam = vec![0.0; coded.sampled.light.len() / bands];
                *finest_of_paper = Some(Finest { scattered: coded.sampled.light.clone(), beam, bands });
            }
            let (mesh, mesh_missing) = match coded.sampled.on_mesh {
                Ok(found) => (Some(found), None),
                Err(reason) => (None, Some(reason)),
            };
            let row = Row {
                mesh,
                mesh_missing,
                seconds: cost.seconds,
                peak_bytes: cost.peak_bytes,
                bytes: coded.bytes,
                fields: coded.fields,
                converged,
                monte_carlo: error.flatten(),
                monte_carlo_missing: missing.clone(),
                ..Row::new(&choice.solve, store)
            };
            rows.push((*store, row, coded.sampled.light));
        }
        let own = finest_of_paper.as_ref().filter(|_| choice.solve.transport.has_finest_of_its_own());
        let finest = finest.as_ref().expect("the first choice is the finest, and is coded without loss");
        Ok(rows
            .into_iter()
            .map(|(store, row, light)| {
                let distance = finest.distance(&light, choice.solve.holds_beam());
                let worst = (0..bands).fold(0, |worst, band| {
                    if distance.bands[band] > distance.bands[worst] { band } else { worst }
                });
                let row = Row {
                    finest_percent: distance.percent,
                    paper_percent: own.map(|own| own.distance(&light, false).percent),
                    worst_band: names[worst].clone(),
                    worst_band_percent: distance.bands[worst],
                    ..row
                };
                (store, row)
            })
            .collect())
    }

    fn finest_of_paper(&self) -> Solve {
        finest_of_paper(self.settings.lattices.iter().copied().max().unwrap_or_default())
    }

    fn bake(&self, choice: &Choice, plant: Plant, meter: &Meter) -> Result<Baked, EvalError> {
        let mut settings = choice.solve.settings(self.settings.voxels, self.settings.ignore_alpha);
        settings.model.keep_cloud();
        Ok(bake(plant, &settings, &NoStore, meter)?)
    }

    /// Traces the truth of a lattice in the medium of its first physical solve.
    fn trace(&self, baked: &Baked, of_lattice: &mut OfLattice) -> Result<(), EvalError> {
        let Baked { fields, cloud, .. } = baked;
        let (Some((surfaces, _)), Some(turbid), Some(cloud), None) =
            (fields.meta.physical(), &fields.turbid, cloud, &of_lattice.truth)
        else {
            return Ok(());
        };
        let bands: Vec<_> = surfaces.bands.iter().map(scatter).collect();
        let truth = Step::MonteCarlo.run(self.observer, &fields.meta.name, |progress| {
            Truth::trace(turbid, &bands, &cloud.albedos, self.suns, progress)
        })?;
        of_lattice.truth = Some(truth);
        Ok(())
    }
}

/// Fields in one of their codes.
struct Coded {
    cost: Cost,
    bytes: u64,
    fields: usize,
    library: Library,
    sampled: Sampled,
}

impl Coded {
    /// Encodes as a bake does, writes to memory, and samples what was written. `last` drops the fields as soon as they
    /// are coded. A bake alone would hold `own` bytes before it encodes.
    fn new(
        fields: &mut Option<SpeciesFields>,
        store: &Store,
        last: bool,
        own: u64,
        (bench, on_mesh): (&Bench, &OnMesh),
        of_lattice: &mut OfLattice,
    ) -> Result<Coded, EvalError> {
        let held = bench.heap.used_bytes().saturating_sub(own);
        let settings = store.settings();
        let meter = Meter::new(bench.observer, bench.heap);
        let source = fields.as_ref().expect("only the last code drops the fields");
        let name = source.meta.name.clone();
        let species =
            Step::Encode.run(&meter, &name, |progress| encode_species(source, &settings, progress))?;
        if last {
            *fields = None;
        }
        let bytes =
            Step::Write.run(&meter, &name, |_| write_library_to(&mut std::io::sink(), &[&species]))?;
        let cost = meter.cost(held);
        let mut file = Vec::with_capacity(bytes as usize);
        write_library_to(&mut file, &[&species])?;
        drop(species);
        let library = Library::from_source(format!("the file of {name} in memory"), Box::new(file))?;
        let fields = library.container().species()[0].bases.len();
        let sampled = sample::light(&library, bench.suns, on_mesh, &mut of_lattice.prepared)?;
        Ok(Coded { cost, bytes, fields, library, sampled })
    }
}
