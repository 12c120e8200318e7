//! How long to wait before a request is sent again, if at all.
//!
//! An answer that says "not now" is believed: the request is sent again until the time for it is over, after waits that
//! double, and never before the server's Retry-After. Failures without such an answer are tried again a few times only,
//! because a wrong address fails for ever.

use std::hash::{BuildHasher, RandomState};
use std::time::Duration;

use http::StatusCode;
use object_store::client::HttpErrorKind;

use super::answer::Refused;

/// The first wait, and the longest but for what a server asks for.
const WAITS: [Duration; 2] = [Duration::from_millis(200), Duration::from_secs(10)];

/// Of one range.
#[derive(Debug)]
pub(super) struct Patience {
    /// For all tries together.
    limit: Duration,
    /// That are left for failures without an answer that says "not now".
    retries: usize,
    /// Tries that have failed.
    tries: u32,
}

/// Why there is no other try.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Enough {
    /// Another one would fail the same way, or enough have.
    Failed,
    /// The time is over.
    Time { tries: u32 },
    /// The server asks to wait for longer than is left.
    Wait { asked: Duration },
}

impl Patience {
    pub(super) fn new(limit: Duration, retries: usize) -> Patience {
        Patience { limit, retries, tries: 0 }
    }

    /// How long to wait after a failure, `elapsed` after the first try began.
    pub(super) fn wait(&mut self, refused: &Refused, elapsed: Duration) -> Result<Duration, Enough> {
        self.wait_by(refused, elapsed, jitter())
    }

    /// By a jitter of 0 to 1, which spreads the requests of many clients that failed at once.
    fn wait_by(&mut self, refused: &Refused, elapsed: Duration, jitter: f64) -> Result<Duration, Enough> {
        let asked = match refused {
            Refused::Status { found, wait } if is_busy(*found) => wait.unwrap_or_default(),
            refused if may_pass(refused) && self.retries > 0 => {
                self.retries -= 1;
                Duration::ZERO
            }
            _ => return Err(Enough::Failed),
        };
        let left = self.limit.saturating_sub(elapsed);
        if asked >= left && !asked.is_zero() {
            return Err(Enough::Wait { asked });
        }
        let [first, longest] = WAITS;
        let doubled = first.saturating_mul(1 << self.tries.min(16)).min(longest);
        self.tries += 1;
        let wait = doubled.mul_f64(0.5 + jitter / 2.0).max(asked);
        if wait >= left {
            return Err(Enough::Time { tries: self.tries });
        }
        Ok(wait)
    }
}

/// Answers that ask for another try later.
fn is_busy(status: StatusCode) -> bool {
    matches!(status.as_u16(), 408 | 429 | 502 | 503 | 504)
}

/// Whether another try may end otherwise.
fn may_pass(refused: &Refused) -> bool {
    match refused {
        Refused::Status { found, .. } => found.is_server_error(),
        Refused::NoAnswer(error) => !matches!(error.kind(), HttpErrorKind::Unknown | HttpErrorKind::Decode),
        _ => false,
    }
}

/// From 0 to 1, at random.
fn jitter() -> f64 {
    RandomState::new().hash_one(0) as f64 / u64::MAX as f64
}

#[cfg(test)]
mod tests {
    use object_store::client::HttpError;

    use super::*;

    const MINUTE: Duration = Duration::from_secs(60);

    fn status(status: u16, wait: Option<u64>) -> Refused {
        let found = StatusCode::from_u16(status).expect("a status");
        Refused::Status { found, wait: wait.map(Duration::from_secs) }
    }

    fn no_answer(kind: HttpErrorKind) -> Refused {
        Refused::NoAnswer(HttpError::new(kind, std::io::Error::other("the cable")))
    }

    /// Tries until there is no other, and the seconds they take.
    fn tries(refused: &Refused, jitter: f64) -> (u32, f64) {
        let mut patience = Patience::new(MINUTE, 4);
        let (mut elapsed, mut tries) = (Duration::ZERO, 1);
        while let Ok(wait) = patience.wait_by(refused, elapsed, jitter) {
            (elapsed, tries) = (elapsed + wait, tries + 1);
        }
        (tries, elapsed.as_secs_f64())
    }

    #[test]
    fn a_busy_server_is_asked_until_the_time_is_over() {
        for code in [408, 429, 502, 503, 504] {
            for jitter in [0.0, 0.5, 1.0] {
                let (tries, seconds) = tries(&status(code, None), jitter);
                assert!(
                    (10..20).contains(&tries) && (45.0..60.0).contains(&seconds),
                    "{code}: {tries}, {seconds}"
                );
            }
        }
    }

    #[test]
    fn other_failures_are_tried_again_a_few_times_and_final_ones_never() {
        for again in [status(500, None), no_answer(HttpErrorKind::Connect), no_answer(HttpErrorKind::Timeout)]
        {
            let (tries, seconds) = tries(&again, 1.0);
            assert!(tries == 5 && seconds < 4.0, "{again}: {tries}, {seconds}");
        }
        for last in [
            status(200, None),
            status(403, Some(1)),
            status(404, None),
            status(416, None),
            no_answer(HttpErrorKind::Unknown),
            Refused::Redirect(String::new()),
            Refused::ContentRange(String::new()),
        ] {
            assert_eq!(
                Patience::new(MINUTE, 4).wait_by(&last, Duration::ZERO, 1.0),
                Err(Enough::Failed),
                "{last}"
            );
        }
    }

    #[test]
    fn what_a_server_asks_for_is_the_least_wait_and_too_much_is_refused_at_once() {
        let mut patience = Patience::new(MINUTE, 0);
        let second = Duration::from_secs(1);
        assert_eq!(patience.wait_by(&status(503, Some(7)), second, 0.0), Ok(7 * second));
        assert!(patience.wait_by(&status(503, Some(0)), second, 0.0).expect("a wait") >= WAITS[0] / 2);
        for asked in [59, 60, 3600, u64::MAX] {
            let asked = Duration::from_secs(asked);
            let refused = Refused::Status { found: StatusCode::TOO_MANY_REQUESTS, wait: Some(asked) };
            assert_eq!(patience.wait_by(&refused, second, 0.0), Err(Enough::Wait { asked }));
        }
    }

    #[test]
    fn a_limit_of_nothing_ends_at_once() {
        for limit in [Duration::ZERO, Duration::from_millis(1)] {
            let enough = Patience::new(limit, 9).wait_by(&status(503, None), limit, 0.0);
            assert_eq!(enough, Err(Enough::Time { tries: 1 }));
        }
    }
}
