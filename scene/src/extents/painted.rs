//! Whether colours of vertices are colours: over a texture or a base colour they are a tint, in many exports data of
//! wind, or that colour once more.

mod weights;

use std::fmt::{self, Display};

use super::Doubt;
use super::alpha::some;
use crate::mesh::Material;
use crate::rays::uv;
use crate::texture::{SrgbTable, color};
use crate::{ClassedMesh, Mesh};

/// Colours of vertices that are no tint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Painted {
    /// Nearly none of the light is left.
    Black,
    /// One of red, green and blue has nearly all.
    OneChannel,
    /// One of red, green and blue is not there.
    TwoChannels,
    /// Red, green and blue each are the strongest of many vertices.
    AllHues,
    /// Colours of the texture, or the base colour, a second time.
    Same,
    /// One of red, green and blue runs from none to all in most blades, as weights of flutter do.
    Runs,
    /// One of red, green and blue is random from blade to blade, as phases of wind are, and another runs along blades.
    Phases,
    /// One of red, green and blue, and not all, follows the height from none to all, as weights of bending do.
    Height,
}

/// Mean of the brightest channel below which colours are black.
const MAX_BLACK: f64 = 0.02;
/// Share of all light that one channel has alone.
const MIN_ALONE: f64 = 0.95;
/// Share of all light of the channel that is not there, at most.
const MAX_LACKING: f64 = 0.005;
/// How far colours are from those of the texture at most, as a share of the sum of both, where they repeat them.
const MAX_APART: f64 = 0.06;
/// Colours brighter than this in the mean tell nothing by being the same.
const MAX_SAME: f64 = 0.6;
/// Share of the vertices of which each channel is the strongest where they are of all hues: leaves that are painted,
/// from green to red in autumn, are hardly blue; of random numbers a fifth is.
const MIN_STRONGEST: f64 = 0.1;
/// Least red of red leaves: data run down to none.
const MIN_RED: f64 = 0.3;
/// Least over strongest channel, in the mean, of pale tints: of random numbers it is a third.
const MIN_PALE: f64 = 0.45;
/// How much the strongest channel is above the next one.
const STRONGER: f64 = 1.25;

impl Display for Painted {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Painted::Black => "are black",
            Painted::OneChannel => "are of one of red, green and blue alone",
            Painted::TwoChannels => "lack one of red, green and blue",
            Painted::AllHues => "are of all hues",
            Painted::Same => "are nearly those of its texture or base colour",
            Painted::Runs => "run from 0 to 1 in one of red, green and blue in most leaves",
            Painted::Phases => {
                "are random from leaf to leaf in one of red, green and blue and run along leaves in another"
            }
            Painted::Height => "follow the height in one of red, green and blue",
        })
    }
}

/// Sums over the vertices of a material.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    brightest: f64,
    /// Of red, green and blue.
    light: [f64; 3],
    /// Vertices of which each is the strongest.
    strongest: [f64; 3],
    /// Of the least of the three over the strongest.
    paleness: f64,
    /// Least of red that any vertex has.
    least_red: f64,
}

impl Sums {
    fn add(&mut self, color: [f32; 3]) {
        let color = color.map(f64::from);
        self.count += 1.0;
        let brightest = color.into_iter().fold(0.0, f64::max);
        self.brightest += brightest;
        self.paleness += color.into_iter().fold(f64::INFINITY, f64::min) / brightest.max(f64::MIN_POSITIVE);
        self.least_red = if self.count > 1.0 { self.least_red.min(color[0]) } else { color[0] };
        for channel in 0..3 {
            let others = color[(channel + 1) % 3].max(color[(channel + 2) % 3]);
            self.light[channel] += color[channel];
            self.strongest[channel] += f64::from(u8::from(color[channel] > STRONGER * others));
        }
    }

    /// `is_blend`: whether they are blends of two colours, as those of autumn are.
    fn look(&self, is_blend: bool) -> Option<Painted> {
        if self.count == 0.0 {
            return None;
        }
        if self.brightest / self.count < MAX_BLACK {
            return Some(Painted::Black);
        }
        let all: f64 = self.light.iter().sum();
        if self.light.iter().any(|light| *light > MIN_ALONE * all) {
            return (self.light[0] <= MIN_ALONE * all || self.least_red < MIN_RED)
                .then_some(Painted::OneChannel);
        }
        if self.light.iter().any(|light| *light <= MAX_LACKING * all) {
            return (!is_blend || self.light[2] > MAX_LACKING * all).then_some(Painted::TwoChannels);
        }
        if self.paleness > MIN_PALE * self.count {
            return None;
        }
        let is_often = |strongest: &f64| *strongest >= MIN_STRONGEST * self.count;
        self.strongest.iter().all(is_often).then_some(Painted::AllHues)
    }
}

/// Doubts of that kind. `triangles` are those of each material of leaf or wood.
pub(super) fn doubts(plant: &ClassedMesh, triangles: &[Vec<u32>]) -> Vec<Doubt> {
    let mesh = &plant.mesh;
    if mesh.colors.is_empty() {
        return Vec::new();
    }
    // Over white they are the colour itself.
    let has_color = |of: &Material| {
        let image = of.color_texture.and_then(|texture| mesh.images.get(texture.image as usize));
        let has_texture = image.is_some_and(|image| image.width > 1 || image.height > 1);
        has_texture || of.base_color[..3] != [1.0; 3]
    };
    let doubt = |(material, triangles): (&Material, &Vec<u32>)| {
        if triangles.is_empty() || !has_color(material) {
            return None;
        }
        let mut sums = Sums::default();
        for vertex in triangles.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]) {
            sums.add(mesh.colors[vertex as usize]);
        }
        let moments = weights::Moments::of(mesh, triangles);
        let look = sums.look(moments.is_blend()).or_else(|| repeat(mesh, material, triangles));
        let look = look.or_else(|| weights::look(mesh, triangles, &moments))?;
        Some(Doubt::VertexColors { material: material.name.clone(), look })
    };
    mesh.materials.iter().zip(triangles).filter_map(doubt).collect()
}

/// Whether colours of vertices are those of the texture there, or of the base colour.
fn repeat(mesh: &Mesh, material: &Material, triangles: &[u32]) -> Option<Painted> {
    const MIDDLE: [f32; 2] = [1.0 / 3.0; 2];
    let table = SrgbTable::new();
    let (mut apart, mut both, mut count) = (0.0, 0.0, 0.0);
    for triangle in some(triangles) {
        let own = color(material, &mesh.images, &table, uv(mesh, triangle as usize, MIDDLE)).as_dvec3();
        let of_vertices = mesh.vertex_color(triangle as usize, MIDDLE).as_dvec3();
        apart += (own - of_vertices).abs().element_sum();
        both += own.element_sum() + of_vertices.element_sum();
        count += 6.0;
    }
    (apart <= MAX_APART * both && both <= MAX_SAME * count).then_some(Painted::Same)
}
