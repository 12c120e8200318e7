//! Light of a scene's lattices by the papers' model.

use flb_format::matter::{BandOptics, Optics, TurbidMedium};
use flb_format::scene_light::Role;
use flb_format::{SpeciesFields, provenance};
use flb_transport::lattice::SolveSettings;
use serde_json::{Value, json};

use super::Baking;
use crate::bake::BakeError;
use crate::bake::key::{Key, hex, of_lattice};
use crate::bake::paper::{self, solver_name};
use crate::bake::store::digest;
use crate::scene_light::{Entry, coarse_medium, paper_entry};

impl Baking<'_> {
    /// The fields of a medium in a role, of which `turbid` is the extinction, with what is `said` of it in the file;
    /// and whether the store had them.
    pub(super) fn solve_lattice(
        &mut self,
        role: &Role,
        turbid: &TurbidMedium,
        optics: BandOptics,
        said: &[(&str, Value)],
    ) -> Result<(SpeciesFields, bool), BakeError> {
        let settings = SolveSettings {
            tolerance: self.settings.tolerance,
            max_sweeps: self.settings.max_passes,
            ..SolveSettings::default()
        };
        let medium = coarse_medium(turbid);
        let bands = Optics { bands: vec![optics.clone()] };
        let name = role.name();
        let work = self.work(&name);
        let key = Key::new("light")
            .with("medium", hex(digest(work.store, &medium)?))
            .with("optics", json!(bands))
            .with_all(of_lattice(&settings, None));
        let paper::Light { bases, converged, cached } =
            paper::light(&work, &medium, &bands, &settings, &key)?;
        self.converged &= converged;
        let of_solve = [
            (provenance::SOLVER.name(), json!(solver_name(settings.solver))),
            (provenance::TOLERANCE.name(), json!(settings.tolerance)),
            (provenance::MAX_SWEEPS.name(), json!(settings.max_sweeps)),
            (provenance::CONVERGED.name(), json!(converged)),
        ];
        let said = said.iter().chain(&of_solve).map(|(key, value)| ((*key).to_owned(), value.clone()));
        let Entry { meta, medium } = paper_entry(role, turbid, optics, said);
        Ok((SpeciesFields { meta, medium, turbid: None, bases }, cached))
    }
}
