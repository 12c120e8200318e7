//! What is sampled: a species of a library, or a crown from a formula, and points at its surfaces.

use flb_format::blocks::CodedBase;
use flb_format::matter::Class;
use flb_format::meta::Bounds;
use flb_format::{Field, Grid, Medium};
use flb_runtime::Library;
use flb_testkit::crown;

/// Terms of a blend: three directions and the sky.
pub(crate) const BASES: usize = 4;
/// Points, in squares of 8 by 8 neighbours where they are coherent.
pub(crate) const POINTS: usize = 1 << 18;
/// Pixels along an edge.
const PIXELS: usize = 512;

pub(crate) struct Plant {
    pub name: String,
    pub grid: Grid,
    pub bases: Vec<CodedBase>,
    /// The others of the species.
    pub rest: Vec<(u8, CodedBase)>,
    non_empty: Vec<bool>,
}

impl Plant {
    /// The first [`BASES`] bases of the first species of a file.
    pub(crate) fn read(path: &str) -> Plant {
        Plant::of(&Library::open(path).unwrap_or_else(|error| panic!("{error}")), path)
    }

    /// A crown of 64 sites made by a formula: shells with gaps, light that falls off towards the middle.
    pub(crate) fn made() -> Plant {
        let grid = Grid { lattice: 64, origin_m: [-2.0, 0.0, -2.0], spacing_m: 1.0 / 16.0 };
        let mut medium = Medium::empty(grid);
        let mut bases: Vec<(u8, Field)> = (0..BASES as u8).map(|base| (base, Field::zeros(64, 3))).collect();
        for site in 0..grid.sites() {
            let at = grid.site(site).map(|c| f64::from(c) - 31.5);
            let r = at.iter().map(|c| c * c).sum::<f64>().sqrt();
            let bumps = libm::sin(0.9 * at[0]) * libm::sin(0.7 * at[1]) * libm::sin(0.8 * at[2]);
            if r < 28.0 && bumps > 0.25 {
                (medium.density[site], medium.class[site]) = (0.5, Class::Leaf);
            }
            for (base, field) in &mut bases {
                let towards = at[usize::from(*base) % 3] * if *base == 3 { -1.0 } else { 1.0 };
                let light = libm::exp(-0.04 * (28.0 - towards).max(0.0)) * (1.0 + 0.2 * bumps);
                for b in 0..3 {
                    field.values_mut()[b * grid.sites() + site] = (light * (1.0 - 0.2 * b as f64)) as f32;
                }
            }
        }
        let bounds_m = Bounds { min: [-2.0, 0.0, -2.0], max: [2.0, 4.0, 2.0] };
        let bytes = crown::bytes(bounds_m, medium, bases);
        let library = Library::from_source("crown", Box::new(bytes)).expect("it was written");
        Plant::of(&library, "a crown by formula")
    }

    fn of(library: &Library, name: &str) -> Plant {
        let (container, source) = (library.container(), library.source());
        let species = &container.species()[0];
        let shared = container.read_shared(source, 0).unwrap_or_else(|error| panic!("{name}: {error}"));
        let read = |base| container.read_coded_base(source, 0, base, &shared).expect("a sound file");
        let mut all = species.bases.iter().map(|entry| (entry.base, read(entry.base)));
        let bases: Vec<CodedBase> = all.by_ref().take(BASES).map(|(_, base)| base).collect();
        assert_eq!(bases.len(), BASES, "{name}: a species of {BASES} bases");
        let rest = all.collect();
        let medium = container.read_medium(source, 0).expect("a sound file");
        let non_empty = medium.class.iter().map(|class| *class != Class::Empty).collect();
        Plant { name: name.to_owned(), grid: species.meta.grid, bases, rest, non_empty }
    }

    fn model(&self, lattice: [f64; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| (self.grid.origin_m[axis] + lattice[axis] * self.grid.spacing_m) as f32)
    }

    /// First matter behind each pixel of a picture along z; where there is none, the pixel before. Pixels of a square
    /// follow one another in Morton order, so that a GPU's lanes are as near one another as those of a rasteriser.
    pub(crate) fn sweep(&self) -> Vec<[f32; 3]> {
        let n = self.grid.lattice as usize;
        let mut points = Vec::with_capacity(POINTS);
        let mut last = self.model([f64::from(self.grid.lattice) / 2.0; 3]);
        for i in 0..POINTS {
            let (square, pixel) = (i / 64, i % 64);
            let across = PIXELS / 8;
            let digit = |bit: usize| (0..3).map(|d| (pixel >> (2 * d + bit) & 1) << d).sum::<usize>();
            let [u, v] = [8 * (square % across) + digit(0), 8 * (square / across) + digit(1)];
            let [x, y] = [u, v].map(|c| (c as f64 + 0.5) / PIXELS as f64 * n as f64);
            let column = y as usize * n + x as usize;
            if let Some(z) = (0..n).find(|z| self.non_empty[z * n * n + column]) {
                last = self.model([x, y, z as f64 + 0.5]);
            }
            points.push(last);
        }
        points
    }

    /// Anywhere in non-empty sites.
    pub(crate) fn scattered(&self) -> Vec<[f32; 3]> {
        let sites: Vec<usize> = (0..self.non_empty.len()).filter(|site| self.non_empty[*site]).collect();
        let mut state = 1_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        (0..POINTS)
            .map(|_| {
                let site = sites[(unit() * sites.len() as f64) as usize];
                self.model(self.grid.site(site).map(|c| f64::from(c) + unit()))
            })
            .collect()
    }
}

/// `[z][y][x][channel]` of a base of three bands.
pub(crate) fn interleaved(base: &CodedBase, channels: usize) -> Vec<f32> {
    let field = base.field();
    let sites = (field.lattice as usize).pow(3);
    let mut texels = vec![0.0; channels * sites];
    for band in 0..field.bands {
        for (site, value) in field.band(band).iter().enumerate() {
            texels[channels * site + band as usize] = *value;
        }
    }
    texels
}
