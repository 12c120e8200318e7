//! What `flb --version` says. None of it but the number gets into a file.

/// All that tells one build from another, for reports of faults; `flb -V` says the first line alone.
pub(crate) const LONG: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    "\n",
    env!("FLB_BUILT_COMMIT"),
    "\nfeatures ",
    env!("FLB_BUILT_FEATURES"),
    "\ntarget ",
    env!("FLB_BUILT_TARGET"),
    "\nprofile ",
    env!("FLB_BUILT_PROFILE"),
);
