//! Light of a scene's lattices by the papers' model.

use flb_format::matter::{BandOptics, TurbidMedium};
use flb_format::scene_light::Role;
use flb_format::{SpeciesFields, provenance};
use flb_transport::lattice::SolveSettings;
use serde_json::Value;

use super::Baking;
use crate::bake::BakeError;
use crate::bake::paper;
use crate::scene_light::{Entry, paper_entry};

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
        let Entry { mut meta, medium } = paper_entry(role, turbid, optics);
        let name = role.name();
        let work = self.work(&name);
        let optics = meta.optics().expect("an entry of the model paper");
        let paper::Light { bases, converged, cached } =
            paper::light(&work, &medium, optics, &settings, None)?;
        self.converged &= converged;
        meta.settings.extend(said.iter().map(|(key, value)| ((*key).to_owned(), value.clone())));
        paper::record(&mut meta, &settings, medium.grid.lattice);
        meta.record(&provenance::CONVERGED, converged);
        Ok((SpeciesFields { meta, medium, turbid: None, bases }, cached))
    }
}
