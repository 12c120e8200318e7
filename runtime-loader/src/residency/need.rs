//! What a frame shows of each species: from instances, camera and sun to how much a base, and its detail, counts.
//!
//! A base's error is seen on every pixel that its plants cover, times the square of the weight that the sun gives it
//! there. Weights depend on the sun in the instance's own frame, and there are more instances than directions that
//! differ, so pixels are first gathered by direction, in cells of an octahedral map (Cigolle et al. 2014, "A Survey of
//! Efficient Representations for Independent Unit Vectors"), and each cell is then turned into weights by a table that
//! is made once.

use std::sync::Arc;

use flb_format::beam::means;
use flb_format::light::SunBasis;
use flb_format::sun::harmonics;
use flb_format::{Container, Placement};

use super::Units;
use crate::Daylight;
use crate::view::{Camera, Frustum, Instance, WaterPlane, dot, unit};

/// Cells along an edge of the map of directions: about 6 degrees each.
const EDGE: usize = 32;
const CELLS: usize = EDGE * EDGE;
/// What a weight counts in the cells beside its own, so that a base is there before the sun needs it, and none is
/// missed between the directions that were tried.
const BESIDE: f32 = 0.05;
/// A weight of less than a hundredth is not missed.
const MIN_SQUARE: f32 = 1e-4;
/// Pixels of a block's edge from which its detail counts in full.
const FULL_DETAIL_PX: f32 = 2.0;
/// And below which none of it is seen.
const MIN_DETAIL_PX: f32 = 0.25;
/// Most plants of a species of which it is looked up which pages are seen.
const MAX_WINDOWS: usize = 8;

/// Pixels and weights of what a frame shows, by species.
#[derive(Debug, Clone, Default)]
pub struct Need {
    /// Need of each species, `[species]`.
    pub species: Vec<SpeciesNeed>,
}

impl Need {
    /// Species of which something is seen, with their numbers.
    pub fn seen(&self) -> impl Iterator<Item = (usize, &SpeciesNeed)> {
        self.species.iter().enumerate().filter(|(_, seen)| seen.pixels > 0.0)
    }

    /// Adds the need of the same plants and camera under a further sun: squares of weights add up.
    ///
    /// # Panics
    /// If it is of other species.
    pub fn add(&mut self, other: &Need) {
        assert_eq!(self.species.len(), other.species.len(), "needs of the same species");
        for (sum, more) in self.species.iter_mut().zip(&other.species) {
            sum.bases.iter_mut().zip(&more.bases).for_each(|(sum, more)| *sum += more);
            sum.detail.iter_mut().zip(&more.detail).for_each(|(sum, more)| *sum += more);
            sum.is_now.iter_mut().zip(&more.is_now).for_each(|(now, more)| *now |= more);
        }
    }
}

/// Pixels and weights of what a frame shows of a species.
#[derive(Debug, Clone, Default)]
pub struct SpeciesNeed {
    /// Pixels that its plants cover, each at most the whole picture, and as much again in water; 0 if none is seen.
    pub pixels: f32,
    /// `[base]`: pixels times weight squared.
    pub bases: Vec<f32>,
    /// `[base]`: whether the sun or the sky gives it weight now; others are of use soon.
    pub is_now: Vec<bool>,
    /// `[base]`: the same of pixels on which detail is seen.
    pub detail: Vec<f32>,
    /// Frustums of the few plants on which detail is seen, directly and in water, each in the frame of the model;
    /// `None` if they are many.
    pub windows: Option<Vec<Frustum>>,
}

/// Plants, with what a frame asks of each.
#[derive(Debug, Clone)]
pub struct Placed {
    instances: Vec<Instance>,
    /// `[instance]`: centre and radius of a sphere around it, world.
    spheres: Vec<[f32; 4]>,
}

impl Placed {
    /// Finds the spheres. Species are numbers in the container.
    ///
    /// # Panics
    /// If a plant is of a species that the container does not have.
    pub fn new(container: &Container, plants: impl IntoIterator<Item = Placement>) -> Placed {
        let balls: Vec<_> = container.species().iter().map(|species| ball(&species.meta.bounds_m)).collect();
        let instances: Vec<Instance> = plants.into_iter().map(|plant| Instance::of(&plant)).collect();
        let sphere = |instance: &Instance| sphere(instance, balls[instance.species as usize]);
        Placed { spheres: instances.iter().map(sphere).collect(), instances }
    }

    /// Number of plants.
    pub fn len(&self) -> usize {
        self.instances.len()
    }

    /// Whether there are no plants.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty()
    }

    /// Memory that a plant takes.
    pub const PLANT_BYTES: usize = size_of::<Instance>() + size_of::<[f32; 4]>();

    /// Adds a plant behind the others.
    ///
    /// # Panics
    /// As [`Placed::new`].
    pub fn push(&mut self, container: &Container, plant: &Placement) {
        let instance = Instance::of(plant);
        let ball = ball(&container.species()[plant.species].meta.bounds_m);
        self.spheres.push(sphere(&instance, ball));
        self.instances.push(instance);
    }

    /// Takes a plant away; the last one takes its place.
    ///
    /// # Panics
    /// If there is no such plant.
    pub fn swap_remove(&mut self, index: usize) {
        self.instances.swap_remove(index);
        self.spheres.swap_remove(index);
    }

    /// Moves a plant.
    ///
    /// # Panics
    /// As [`Placed::new`], and if there is no such plant.
    pub fn set(&mut self, container: &Container, index: usize, plant: &Placement) {
        let instance = Instance::of(plant);
        let ball = ball(&container.species()[plant.species].meta.bounds_m);
        self.spheres[index] = sphere(&instance, ball);
        self.instances[index] = instance;
    }
}

/// A ball of a model in the world: centre and radius.
fn sphere(instance: &Instance, (center, radius): ([f32; 3], f32)) -> [f32; 4] {
    let [x, y, z] = instance.world_from_model(center);
    [x, y, z, radius * instance.scale]
}

fn ball(bounds: &flb_format::meta::Bounds) -> ([f32; 3], f32) {
    let center = std::array::from_fn(|i| ((bounds.min[i] + bounds.max[i]) / 2.0) as f32);
    let half: [f32; 3] = std::array::from_fn(|i| ((bounds.max[i] - bounds.min[i]) / 2.0) as f32);
    (center, libm::sqrtf(dot(half, half)))
}

/// Finds what frames show; holds the tables and the memory of its work.
#[derive(Debug)]
pub struct NeedFinder {
    species: Vec<Finder>,
}

#[derive(Debug)]
struct Finder {
    table: Arc<Table>,
    /// `[base]`: item.
    items: Vec<u8>,
    block_m: f32,
    /// `[cell]`: pixels, and pixels on which detail is seen.
    cells: Vec<[f32; 2]>,
    /// Cells that are not 0.
    used: Vec<u16>,
    pixels: f32,
    windows: Option<Vec<Frustum>>,
}

/// Squares of weights by direction.
#[derive(Debug)]
struct Table {
    suns: SunBasis,
    items: usize,
    /// `[cell][item]`; of the sky 0, since it depends on no direction.
    squares: Vec<f32>,
    /// `[cell][item]`: whether the weight is the cell's own, not of a cell beside it.
    is_own: Vec<bool>,
}

impl NeedFinder {
    /// Makes the tables.
    pub fn new(container: &Container, units: &Units) -> NeedFinder {
        let mut tables: Vec<Arc<Table>> = Vec::new();
        let mut species = Vec::with_capacity(units.species());
        for (index, entry) in container.species().iter().enumerate() {
            let suns = entry.meta.model.suns();
            let table = match tables.iter().find(|table| table.suns == *suns) {
                Some(table) => Arc::clone(table),
                None => {
                    tables.push(Arc::new(Table::new(suns.clone())));
                    Arc::clone(&tables[tables.len() - 1])
                }
            };
            species.push(Finder {
                table,
                items: units.bases(index).iter().map(|base| base.item).collect(),
                block_m: (entry.meta.grid.spacing_m * flb_format::blocks::EDGE as f64) as f32,
                cells: vec![[0.0; 2]; CELLS],
                used: Vec::new(),
                pixels: 0.0,
                windows: None,
            });
        }
        NeedFinder { species }
    }

    /// Finds the need of a frame. A sun without a direction shines on nothing.
    pub fn find(&mut self, placed: &Placed, camera: &Camera, light: &Daylight) -> Need {
        self.find_in(placed, &[camera.frustum()], light)
    }

    /// Finds the need of a frame of a scene with water: what it mirrors may be seen as well.
    pub fn find_over_water(
        &mut self,
        placed: &Placed,
        camera: &Camera,
        water: Option<WaterPlane>,
        light: &Daylight,
    ) -> Need {
        match water.and_then(|water| camera.frustum_in_water(water)) {
            Some(in_water) => self.find_in(placed, &[camera.frustum(), in_water], light),
            None => self.find(placed, camera, light),
        }
    }

    fn find_in(&mut self, placed: &Placed, views: &[Frustum], light: &Daylight) -> Need {
        let most_windows = MAX_WINDOWS * views.len();
        let sun = unit(light.towards_sun.map(|c| c as f32));
        let shines = light.sun > 0.0 && sun.iter().all(|c| c.is_finite());
        for finder in &mut self.species {
            finder.begin();
        }
        for frustum in views {
            for (instance, &[x, y, z, radius]) in placed.instances.iter().zip(&placed.spheres) {
                if frustum.sees_sphere([x, y, z], radius) {
                    let finder = &mut self.species[instance.species as usize];
                    let away = [0, 1, 2].map(|i| [x, y, z][i] - frustum.position_m[i]);
                    if finder.see(instance, sun, libm::sqrtf(dot(away, away)), radius, frustum) {
                        finder.look(instance, frustum, most_windows);
                    }
                }
            }
        }
        let sun = if shines { light.sun } else { 0.0 };
        Need { species: self.species.iter_mut().map(|finder| finder.finish(sun, light.sky)).collect() }
    }
}

impl Finder {
    fn begin(&mut self) {
        for cell in self.used.drain(..) {
            self.cells[usize::from(cell)] = [0.0; 2];
        }
        self.pixels = 0.0;
        self.windows = Some(Vec::new());
    }

    /// Counts a plant, and tells whether its detail is seen.
    #[inline]
    fn see(
        &mut self,
        instance: &Instance,
        sun: [f32; 3],
        distance_m: f32,
        radius_m: f32,
        frustum: &Frustum,
    ) -> bool {
        // From within its sphere a plant fills the picture.
        let nearest = (distance_m - radius_m).max(0.0);
        let across = radius_m * frustum.focal_px / distance_m.max(1e-6);
        let pixels = if nearest > 0.0 {
            (std::f32::consts::PI * across * across).min(frustum.picture_px)
        } else {
            frustum.picture_px
        };
        let block_px = self.block_m * instance.scale * frustum.focal_px / nearest.max(1e-6);
        let seen = if block_px < MIN_DETAIL_PX { 0.0 } else { (block_px / FULL_DETAIL_PX).min(1.0) };
        let cell = cell(instance.model_from_world_direction(sun));
        let place = &mut self.cells[cell];
        if place[0] == 0.0 {
            self.used.push(cell as u16);
        }
        place[0] += pixels;
        place[1] += pixels * seen * seen;
        self.pixels += pixels;
        seen > 0.0
    }

    /// Notes through which window a plant is seen.
    fn look(&mut self, instance: &Instance, frustum: &Frustum, most: usize) {
        match &mut self.windows {
            Some(windows) if windows.len() < most => windows.push(frustum.in_model(instance)),
            windows => *windows = None,
        }
    }

    fn finish(&mut self, sun: f32, sky: f32) -> SpeciesNeed {
        let items = self.table.items;
        let mut sums = vec![[0.0f32; 2]; items];
        let mut is_now = vec![false; items];
        let mut all = [0.0; 2];
        for cell in self.used.iter().map(|cell| usize::from(*cell)) {
            let pixels = self.cells[cell];
            let squares = &self.table.squares[cell * items..][..items];
            for (sum, square) in sums.iter_mut().zip(squares) {
                sum[0] += pixels[0] * square;
                sum[1] += pixels[1] * square;
            }
            let is_own = &self.table.is_own[cell * items..][..items];
            is_now.iter_mut().zip(is_own).for_each(|(now, own)| *now |= own);
            all = [all[0] + pixels[0], all[1] + pixels[1]];
        }
        let of = |which: usize| {
            let value = |item: &u8| match item {
                0 => sky * sky * all[which],
                item => sun * sun * sums[usize::from(*item)][which],
            };
            self.items.iter().map(value).collect()
        };
        let is_now = |item: &u8| match item {
            0 => sky > 0.0 && self.pixels > 0.0,
            item => sun > 0.0 && is_now[usize::from(*item)],
        };
        SpeciesNeed {
            pixels: self.pixels,
            bases: of(0),
            is_now: self.items.iter().map(is_now).collect(),
            detail: of(1),
            windows: self.windows.take(),
        }
    }
}

impl Table {
    fn new(suns: SunBasis) -> Table {
        let items = usize::from(suns.items());
        // At the corners of cells, and in their middles.
        let corners = directions(EDGE + 1, 0.0).map(|d| squares(&suns, d, items)).collect::<Vec<_>>();
        let middles = directions(EDGE, 0.5).map(|d| squares(&suns, d, items)).collect::<Vec<_>>();
        let mut own = vec![0.0f32; CELLS * items];
        for (cell, own) in own.chunks_exact_mut(items).enumerate() {
            let (x, y) = (cell % EDGE, cell / EDGE);
            let corner = |dx: usize, dy: usize| &corners[(y + dy) * (EDGE + 1) + x + dx];
            for at in [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1), &middles[cell]] {
                own.iter_mut().zip(at).for_each(|(own, square)| *own = own.max(*square));
            }
        }
        let mut all = own.clone();
        for cell in 0..CELLS {
            for beside in neighbours(cell) {
                for item in 0..items {
                    let shadow = BESIDE * own[beside * items + item];
                    all[cell * items + item] = all[cell * items + item].max(shadow);
                }
            }
        }
        let is_own = own.iter().map(|square| *square > MIN_SQUARE).collect();
        Table { suns, items, squares: all, is_own }
    }
}

/// `[item]` squares of what a direction gives each, the sky left out.
fn squares(suns: &SunBasis, towards_sun: [f32; 3], items: usize) -> Vec<f32> {
    let direction = towards_sun.map(f64::from);
    let mut squares = vec![0.0; items];
    match suns {
        SunBasis::Harmonics { degree, single, .. } => {
            let count = harmonics::count(*degree);
            let y = harmonics::evaluate(direction);
            squares[1..].iter_mut().zip(&y[..count]).for_each(|(square, y)| *square = (y * y) as f32);
            // Means of the near beam are from 0 to 1; a quarter is the square of the middle.
            squares[1 + count..][..means(*single)].fill(0.25);
        }
        _ => {
            let blend = suns.blend(direction).expect("a unit vector has a blend");
            for (base, weight) in blend.bases.into_iter().zip(blend.weights) {
                squares[usize::from(base)] += weight * weight;
            }
        }
    }
    squares
}

/// The cell of a unit vector.
#[inline]
fn cell([x, y, z]: [f32; 3]) -> usize {
    let size = x.abs() + y.abs() + z.abs();
    let (mut u, mut v) = (x / size, z / size);
    if y < 0.0 {
        (u, v) = ((1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v));
    }
    // A NaN is cell 0.
    let along = |c: f32| (((c + 1.0) * (EDGE as f32 / 2.0)) as usize).min(EDGE - 1);
    along(v) * EDGE + along(u)
}

#[inline]
fn sign(c: f32) -> f32 {
    if c < 0.0 { -1.0 } else { 1.0 }
}

/// Unit vectors on a grid of the map, row by row.
fn directions(edge: usize, shift: f32) -> impl Iterator<Item = [f32; 3]> {
    (0..edge * edge).map(move |i| {
        let along = |c: usize| (c as f32 + shift) / EDGE as f32 * 2.0 - 1.0;
        let (u, v) = (along(i % edge), along(i / edge));
        let y = 1.0 - u.abs() - v.abs();
        let [x, z] = if y >= 0.0 { [u, v] } else { [(1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v)] };
        unit([x, y, z])
    })
}

/// Cells beside a cell; across the map's edge those that the edge is folded to.
fn neighbours(cell: usize) -> Vec<usize> {
    let n = EDGE as isize;
    let (x, y) = ((cell % EDGE) as isize, (cell / EDGE) as isize);
    let mut found = Vec::with_capacity(8);
    for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
        let (mut x, mut y) = (x + dx, y + dy);
        if x < 0 || x >= n {
            (x, y) = (x.clamp(0, n - 1), n - 1 - y);
        }
        if y < 0 || y >= n {
            (x, y) = (n - 1 - x, y.clamp(0, n - 1));
        }
        found.push((y.clamp(0, n - 1) * n + x.clamp(0, n - 1)) as usize);
    }
    found
}

/// `[item]` of the cell that a direction falls into, for tests.
#[cfg(test)]
pub(super) fn squares_by_cell(suns: &SunBasis) -> impl Fn([f32; 3]) -> Vec<f32> + use<> {
    let table = Table::new(suns.clone());
    move |direction| table.squares[cell(direction) * table.items..][..table.items].to_vec()
}
