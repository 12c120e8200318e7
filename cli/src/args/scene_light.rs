//! Flags of the light that plants of a scene take from each other.

use std::path::PathBuf;

use clap::Args;
use flb_format::scene_light::SceneFactor;

#[derive(Args)]
pub(crate) struct SceneLightArgs {
    /// What the plants of a scene do to each other's light, of `flb bake-scene` [default: the scene's `light`, else
    /// they do nothing]
    #[arg(long, value_name = "SCENE.flb")]
    pub scene_light: Option<PathBuf>,
    /// What the scene's light is compared with, to say what neighbours do to a plant's; `empty` gives the papers'
    /// factor [default: alone]
    #[arg(long, value_enum)]
    pub scene_factor: Option<SceneFactor>,
}

impl SceneLightArgs {
    /// The first flag that is given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        match (&self.scene_light, self.scene_factor) {
            (Some(_), _) => Some("--scene-light"),
            (None, Some(_)) => Some("--scene-factor"),
            (None, None) => None,
        }
    }
}
