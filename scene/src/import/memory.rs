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

/// Checks that there is room for so many bytes that others take, piece by piece: they are taken at once, and given
/// back.
///
/// # Errors
/// [`ImportError::Memory`].
pub fn ask(file: &str, what: &str, bytes: u64) -> Result<(), ImportError> {
    reserve::<u8>(file, what, &mut Vec::new(), usize::try_from(bytes).unwrap_or(usize::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::Fault;

    #[test]
    fn memory_that_is_not_there_is_a_limit_and_names_file_list_and_bytes() {
        let mut list: Vec<u64> = Vec::new();
        let error =
            reserve("a.toml", "instances", &mut list, usize::MAX / 16).expect_err("half of all addresses");
        assert_eq!(error.fault(), Fault::Limit);
        let bytes = (usize::MAX / 16) * 8;
        assert_eq!(
            error.to_string(),
            format!("a.toml: instances: {bytes} bytes of memory needed, which the system does not give")
        );
        assert!(ask("a.toml", "instances", u64::MAX).is_err() && ask("a.toml", "instances", 1).is_ok());
        reserve("a.toml", "instances", &mut list, 3).expect("24 bytes");
        assert!(list.capacity() >= 3);
    }
}
