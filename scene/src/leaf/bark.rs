//! How much light bark reflects, for plants that say nothing about it.

/// Wavelength, nm, and hemispherical reflectance: the mean of three barks, Norway maple (also used there for alder, ash
/// and lime), Norway spruce and the stem of silver birch, at the centres of narrow bands.
///
/// Measured at Jarvselja, Estonia, by Kuusk and others of Tartu Observatory; from the tables of the RAMI-5 scene
/// ACT_HET15_JBS_WIN of the European Commission's Joint Research Centre (rami-benchmark.jrc.ec.europa.eu, version 2,
/// 2021). The darkest and the lightest of the three differ by a factor of two; white bark is outside this.
const BARK: [(f64, f64); 8] = [
    (443.0, 0.091),
    (490.5, 0.101),
    (560.4, 0.131),
    (665.3, 0.155),
    (681.6, 0.161),
    (709.1, 0.240),
    (754.2, 0.314),
    (865.6, 0.393),
];

/// Reflectance of bark at `nm`, linear between the measured bands; beyond them that of the nearest.
pub fn bark_reflectance(nm: f64) -> f64 {
    let after = BARK.partition_point(|&(at, _)| at <= nm);
    if after == 0 || after == BARK.len() {
        return BARK[after.min(BARK.len() - 1)].1;
    }
    let ((low, r), (high, s)) = (BARK[after - 1], BARK[after]);
    r + (s - r) * (nm - low) / (high - low)
}
