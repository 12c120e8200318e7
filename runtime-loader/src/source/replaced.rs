//! A file that was replaced while it was read: how that is told from other failures, and the second try.
//!
//! What was read of the old file is of no use with the new one, so a single read cannot be repeated: the whole
//! operation starts again, from its opening. That is its caller's to do, by [`retry_replaced`].

use std::error::Error;
use std::io;

/// Number of times that an operation is tried, in all.
pub const ATTEMPTS: u32 = 3;

/// The file behind a URL is not the one that was opened.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("replaced while it was read: found {found}, expected {expected}")]
pub struct Replaced {
    /// Version of the file that the server states now.
    pub found: String,
    /// Version that the server stated when the file was opened.
    pub expected: String,
}

/// Whether an error comes from a file that was [`Replaced`], at whatever depth.
pub fn is_replaced(error: &(dyn Error + 'static)) -> bool {
    let mut next = Some(error);
    while let Some(error) = next {
        if error.is::<Replaced>() {
            return true;
        }
        // An `io::Error` passes over the error in it when asked for its source.
        let inner = error.downcast_ref::<io::Error>().and_then(io::Error::get_ref);
        next = match inner {
            Some(inner) => Some(inner),
            None => error.source(),
        };
    }
    false
}

/// Runs an operation that opens and reads files, and runs it again while it fails because one was replaced,
/// [`ATTEMPTS`] times in all. `again` is told of each failure that is followed by another try.
///
/// # Errors
/// The last failure of `operation`.
pub fn retry_replaced<T, E>(
    mut operation: impl FnMut() -> Result<T, E>,
    was_replaced: impl Fn(&E) -> bool,
    again: impl Fn(&E),
) -> Result<T, E> {
    for _ in 1..ATTEMPTS {
        match operation() {
            Err(error) if was_replaced(&error) => again(&error),
            outcome => return outcome,
        }
    }
    operation()
}

#[cfg(test)]
mod tests {
    use flb_format::FormatError;
    use flb_format::error::Place;

    use super::*;
    use crate::RuntimeError;

    fn replaced() -> io::Error {
        io::Error::other(Replaced { found: "1 byte".to_owned(), expected: "2 bytes".to_owned() })
    }

    #[test]
    fn a_replaced_file_is_found_at_any_depth_and_nothing_else_is() {
        let at = |source| FormatError::Read { place: Place::file(0), bytes: 1, source };
        let wrap = |source| RuntimeError::Format { path: "x.flb".into(), source: Box::new(source) };
        assert!(
            is_replaced(&replaced()) && is_replaced(&at(replaced())) && is_replaced(&wrap(at(replaced())))
        );
        let other = || io::Error::other("the disk is on fire");
        assert!(!is_replaced(&other()) && !is_replaced(&wrap(at(other()))));
    }

    #[test]
    fn an_operation_is_tried_again_only_while_its_file_is_replaced() {
        for (failures, expected) in [(0, Ok(1)), (1, Ok(2)), (2, Ok(3)), (3, Err(3)), (9, Err(3))] {
            let mut runs = 0;
            let outcome = retry_replaced(
                || {
                    runs += 1;
                    if runs > failures { Ok(runs) } else { Err(replaced()) }
                },
                |error| is_replaced(error),
                |_| (),
            );
            assert_eq!(outcome.map_err(|_| runs), expected, "{failures} failures");
        }
        let mut runs = 0;
        let outcome: Result<(), _> = retry_replaced(
            || {
                runs += 1;
                Err(io::Error::from(io::ErrorKind::NotFound))
            },
            |error| is_replaced(error),
            |_| panic!("no other try"),
        );
        assert!(outcome.is_err() && runs == 1);
    }
}
