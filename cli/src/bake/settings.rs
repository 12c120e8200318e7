//! From the flags of `flb bake` to its settings.

use flb_baker::bake::{BakeSettings, Wanted};
use flb_baker::plan::Plan;
use flb_farm::Recipe;

use super::model;
use crate::args::BakeArgs;
use crate::exit::{Failure, USAGE};
use crate::plan::check_known;

/// Of every species. Refuses, before a mesh is read, a plan that is not for these species, and lattices that cannot be.
pub(crate) fn settings_of(
    args: &BakeArgs,
    plan: Option<&Plan>,
    names: &[String],
) -> Result<Vec<BakeSettings>, Failure> {
    if let Some((plan, path)) = plan.zip(args.plan.as_deref()) {
        check_known(plan, names).map_err(|failure| failure.at(path))?;
    }
    names.iter().map(|name| bake_settings(args, plan, name)).collect()
}

/// What the flags ask for, the plan where they do not, and else the preset.
pub(crate) fn bake_settings(
    args: &BakeArgs,
    plan: Option<&Plan>,
    species: &str,
) -> Result<BakeSettings, Failure> {
    let planned = plan.map(|plan| plan.share(species)).transpose()?.and_then(|share| share.lattice);
    let wanted = plan.map(|plan| Wanted::by_plan(plan, species)).transpose()?;
    let recipe = model::recipe(args);
    if let (Some(planned), Some(asked)) = (planned, args.lattice) {
        let message = format!(
            "the plan bakes species {species:?} at lattice {planned}; --lattice {asked} cannot be given with it"
        );
        let failure = Failure::new(USAGE, message);
        return Err(args.plan.iter().fold(failure, |failure, path| failure.at(path)));
    }
    let recipe = Recipe { lattice: recipe.lattice.or(planned), ..recipe };
    Ok(BakeSettings { wanted: wanted.unwrap_or_default(), ..recipe.bake_settings(model::machine(args))? })
}
