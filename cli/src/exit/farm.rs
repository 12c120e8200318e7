//! Exit codes of libraries of species.

use flb_farm::{FarmError, RecipeError};

use super::{Failure, INPUT_OUTPUT, INTERNAL, INTERRUPTED, LIMIT, USAGE, VERDICT};

/// Settings as flags: `--suns`, `--model physical`.
impl From<RecipeError> for Failure {
    fn from(error: RecipeError) -> Failure {
        let flag = |key: &str, value: Option<&str>| {
            let flag = format!("--{}", key.replace('_', "-"));
            value.map_or(flag.clone(), |value| format!("{flag} {value}"))
        };
        Failure::new(USAGE, error.spelled(flag))
    }
}

impl From<FarmError> for Failure {
    fn from(error: FarmError) -> Failure {
        match error {
            FarmError::Import(error) => error.into(),
            FarmError::Stage(error) => error.into(),
            FarmError::Bake { mesh, source } => Failure::from(*source).at(&mesh),
            FarmError::Pack(error) => error.into(),
            FarmError::Runtime(error) => error.into(),
            FarmError::File(error) => error.into(),
            FarmError::Changed { .. } => Failure::new(INPUT_OUTPUT, error),
            FarmError::TaskPlan { .. } | FarmError::Older { .. } => Failure::new(VERDICT, error),
            FarmError::Engine { .. } | FarmError::Bucket { .. } => Failure::new(INPUT_OUTPUT, error),
            FarmError::Unsound { .. } => Failure::new(INTERNAL, error),
            FarmError::Library { .. } => Failure::new(VERDICT, error),
            FarmError::Room(_) | FarmError::Threads(_) => Failure::new(LIMIT, error),
            FarmError::Stopped => Failure::new(INTERRUPTED, error),
            error => Failure::new(USAGE, error),
        }
    }
}
