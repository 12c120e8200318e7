//! Whether colours of vertices are colours: over a texture they are a tint, in many exports data of wind.

use std::fmt::{self, Display};

use super::Doubt;
use crate::{ClassedMesh, MaterialClass};

/// Colours of vertices that are no tint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Painted {
    /// Nearly none of the light is left.
    Black,
    /// One of red, green and blue has nearly all.
    OneChannel,
    /// Red, green and blue each are the strongest of many vertices.
    AllHues,
}

/// Mean of the brightest channel below which colours are black.
const MAX_BLACK: f64 = 0.02;
/// Share of all light that one channel has alone.
const MIN_ALONE: f64 = 0.95;
/// Share of the vertices of which each channel is the strongest where they are of all hues: leaves that are painted,
/// from green to red in autumn, are hardly blue; of random numbers a fifth is.
const MIN_STRONGEST: f64 = 0.1;
/// How much the strongest channel is above the next one.
const STRONGER: f64 = 1.25;

impl Display for Painted {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Painted::Black => "are black",
            Painted::OneChannel => "are of one of red, green and blue alone",
            Painted::AllHues => "are of all hues",
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
}

impl Sums {
    fn add(&mut self, color: [f32; 3]) {
        let color = color.map(f64::from);
        self.count += 1.0;
        self.brightest += color.into_iter().fold(0.0, f64::max);
        for channel in 0..3 {
            let others = color[(channel + 1) % 3].max(color[(channel + 2) % 3]);
            self.light[channel] += color[channel];
            self.strongest[channel] += f64::from(u8::from(color[channel] > STRONGER * others));
        }
    }

    fn look(&self) -> Option<Painted> {
        if self.count == 0.0 {
            return None;
        }
        if self.brightest / self.count < MAX_BLACK {
            return Some(Painted::Black);
        }
        let all: f64 = self.light.iter().sum();
        if self.light.iter().any(|light| *light > MIN_ALONE * all) {
            return Some(Painted::OneChannel);
        }
        let is_often = |strongest: &f64| *strongest >= MIN_STRONGEST * self.count;
        self.strongest.iter().all(is_often).then_some(Painted::AllHues)
    }
}

/// Doubts of that kind.
pub(super) fn doubts(plant: &ClassedMesh) -> Vec<Doubt> {
    let mesh = &plant.mesh;
    if mesh.colors.is_empty() {
        return Vec::new();
    }
    let has_texture = |material: usize| {
        let image = mesh.materials[material].color_texture.map(|texture| texture.image as usize);
        let image = image.and_then(|image| mesh.images.get(image));
        let is_plant = plant.classes[material] != MaterialClass::Neither;
        is_plant && image.is_some_and(|image| image.width > 1 || image.height > 1)
    };
    let textured: Vec<bool> = (0..mesh.materials.len()).map(has_texture).collect();
    let mut sums = vec![Sums::default(); mesh.materials.len()];
    for (triangle, &material) in mesh.triangles.iter().zip(&mesh.triangle_material) {
        if textured[material as usize] {
            triangle.iter().for_each(|vertex| sums[material as usize].add(mesh.colors[*vertex as usize]));
        }
    }
    let looks =
        sums.iter().zip(&mesh.materials).filter_map(|(sums, material)| Some((sums.look()?, material)));
    looks.map(|(look, material)| Doubt::VertexColors { material: material.name.clone(), look }).collect()
}
