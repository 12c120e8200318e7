//! Memory for what a file holds: where the system does not give it, that is an error, and no end of the process.
//!
//! A file of a few kilobytes can hold gigabytes, soundly: zeros compress well. What a caller is ready to spend is its
//! own question; here only the allocation is tried.

use crate::error::{FormatError, Place};

/// A list of `count` times the same value.
///
/// # Errors
/// [`FormatError::Memory`].
pub fn filled<T: Clone>(
    place: Place,
    what: &'static str,
    value: T,
    count: usize,
) -> Result<Vec<T>, FormatError> {
    let mut list = empty(place, what, count)?;
    list.resize(count, value);
    Ok(list)
}

/// A list with room for `count` values.
///
/// # Errors
/// [`FormatError::Memory`].
pub fn empty<T>(place: Place, what: &'static str, count: usize) -> Result<Vec<T>, FormatError> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|_| FormatError::Memory {
        place,
        what,
        bytes: (count as u64).saturating_mul(size_of::<T>() as u64),
    })?;
    Ok(list)
}

/// Checks that there is room for so many bytes that are taken piece by piece: they are taken at once, and given back.
///
/// # Errors
/// [`FormatError::Memory`].
pub fn ask(place: Place, what: &'static str, bytes: u64) -> Result<(), FormatError> {
    let there = usize::try_from(bytes).unwrap_or(usize::MAX);
    empty::<u8>(place, what, there).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorClass;

    #[test]
    fn memory_that_is_not_there_is_a_limit_and_names_place_list_and_bytes() {
        let place = Place::file(7);
        let error = filled(place, "a field", 0u32, usize::MAX / 8).expect_err("half of all addresses");
        let bytes = (usize::MAX / 8) * 4;
        assert_eq!((error.code(), error.class(), error.place()), (6007, ErrorClass::Limit, Some(place)));
        assert_eq!(
            error.to_string(),
            format!(
                "FLB-6007 file at byte 7: {bytes} bytes of memory needed for a field, which the system does not give"
            )
        );
        assert!(ask(place, "a field", u64::MAX).is_err() && ask(place, "a field", 1).is_ok());
        assert_eq!(filled(place, "a field", 1u8, 2).expect("two bytes"), [1, 1]);
    }
}
