//! Sizes as people read them.

/// Returns a number of bytes with a decimal unit: 12.3 MB is 12.3 x 10^6 bytes.
///
/// ```
/// assert_eq!(flb_format::size_text::bytes(12_345_678), "12.3 MB");
/// assert_eq!(flb_format::size_text::bytes(1000), "1.0 kB");
/// assert_eq!(flb_format::size_text::bytes(999), "999 B");
/// ```
pub fn bytes(count: u64) -> String {
    let units = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    match units.iter().find(|(size, _)| count as f64 >= *size) {
        Some((size, unit)) => format!("{:.1} {unit}", count as f64 / size),
        None => format!("{count} B"),
    }
}
