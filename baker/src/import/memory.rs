//! Room for lists whose length a file says: where the system has no room, that is an error, and no end of the process.

use super::error::ImportError;

/// Room for `more` values, and none beyond.
///
/// # Errors
/// [`ImportError::Memory`].
pub fn reserve<T>(file: &str, what: &str, list: &mut Vec<T>, more: usize) -> Result<(), ImportError> {
    list.try_reserve_exact(more).map_err(|_| ImportError::Memory {
        file: file.to_owned(),
        what: what.to_owned(),
        bytes: (more as u64).saturating_mul(size_of::<T>() as u64),
    })
}

/// A list of `count` times the same.
///
/// # Errors
/// [`ImportError::Memory`].
pub fn filled<T: Clone>(file: &str, what: &str, value: T, count: usize) -> Result<Vec<T>, ImportError> {
    let mut list = Vec::new();
    reserve(file, what, &mut list, count)?;
    list.resize(count, value);
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::Fault;

    #[test]
    fn memory_that_is_not_there_is_a_limit_and_names_file_list_and_bytes() {
        let error = filled("a.toml", "instances", 0u64, usize::MAX / 16).expect_err("half of all addresses");
        assert_eq!(error.fault(), Fault::Limit);
        let bytes = (usize::MAX / 16) * 8;
        assert_eq!(
            error.to_string(),
            format!("a.toml: instances: {bytes} bytes of memory needed, which the system does not give")
        );
        assert_eq!(filled("a.toml", "instances", 7u8, 3).expect("three bytes"), [7; 3]);
    }
}
