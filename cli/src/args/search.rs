//! How rays find what they meet.

use flb_render::forest::{InstanceSearch, ModelSearch, Search};

/// "model=grid,camera=tree,sun=grid", any of the three.
pub(super) fn search(text: &str) -> Result<Search, String> {
    let expected = || {
        format!(
            "found {text:?}, expected some of model, camera and sun, each =grid or =tree, such as model=grid,sun=grid"
        )
    };
    let mut search = Search::default();
    for word in text.split(',') {
        let is_grid = match word.split_once('=').map(|(_, structure)| structure) {
            Some("grid") => true,
            Some("tree") => false,
            _ => return Err(expected()),
        };
        let of_instances = if is_grid { InstanceSearch::Grid } else { InstanceSearch::Tree };
        match word.split_once('=').map(|(rays, _)| rays) {
            Some("model") => search.model = if is_grid { ModelSearch::Grid } else { ModelSearch::Tree },
            Some("camera") => search.primary = of_instances,
            Some("sun") => search.shadow = of_instances,
            _ => return Err(expected()),
        }
    }
    Ok(search)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_named_stays_as_it_is_by_default() {
        let default = Search::default();
        assert_eq!(search("model=grid"), Ok(Search { model: ModelSearch::Grid, ..default }));
        let papers =
            Search { model: ModelSearch::Grid, primary: InstanceSearch::Grid, shadow: InstanceSearch::Grid };
        assert_eq!(search("model=grid,camera=grid,sun=grid"), Ok(papers));
        for bad in ["", "grid", "model", "model=kd", "eye=grid", "model=grid,"] {
            assert!(search(bad).unwrap_err().contains("expected some of model"), "{bad}");
        }
    }
}
