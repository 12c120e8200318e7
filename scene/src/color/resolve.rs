//! From a plant's mesh, its measured surfaces and what is said of its colours to the surface of each material.

use std::sync::LazyLock;

use flb_format::colors::color_bands;
use flb_format::material_surface::{MaterialSurface, Texel};
use flb_format::matter::{BandSurfaces, LeafSurface, Surfaces, WoodSurface};
use flb_format::surface::Law;
use glam::DVec3;

use super::evidence::Evidence;
use super::points::on_surface;
use super::rules::{ColorRules, ColorSource};
use crate::alpha::Coverage;
use crate::classify::words::is_flower;
use crate::import::{told_of_material, told_of_part};
use crate::leaf::{Bands, LeafModel};
use crate::mesh::{Image, Material};
use crate::{MaterialClass, Mesh};

/// Reflectance of common bark in R, G and B.
static BARK: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let bands = LeafModel::default().surfaces(&Bands::Rgb).bands;
    bands.iter().map(|band| band.wood.reflectance).collect()
});
/// What differs by less from common bark is that.
const AS_BARK: f64 = 0.02;

/// Means over the points of a mesh that are no further than this from the measured shares are these.
const SAMPLING: f64 = 0.005;

/// The bands whose reflectance a texture tells, in its order; the first three where none are colours.
const BY_PLACE: [usize; 3] = [0, 1, 2];

/// Mean reflectance and transmittance in a band.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeanShares {
    /// Reflectance.
    pub reflectance: f64,
    /// Transmittance.
    pub transmittance: f64,
}

/// A material's colour, and what was made of it.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialColor {
    /// Mean linear colour over the mesh, R, G, B; `None` where the material has no surface or no colour.
    pub texture: Option<[f64; 3]>,
    /// Measured reflectance of R, G and B, or of the first three bands at most where these are no colours.
    pub measured: Vec<f64>,
    /// Meaning of the material's texels.
    pub texel: Texel,
    /// Rule that decided, in words.
    pub rule: String,
    /// Leaf, else wood.
    pub is_leaf: bool,
    /// Whether the bake decided by evidence against the measured colour: worth a word.
    pub is_surprise: bool,
    /// Reason why a request was not followed.
    pub warning: Option<String>,
    /// Sentence on a diffuse transmission that the file states for a leaf whose texels are a tint.
    pub note: Option<String>,
    /// Area that alpha leaves, square metres.
    pub area_m2: f64,
    /// Share of it on which reflectance and transmittance are scaled down to 1 together.
    pub clamped: f64,
    /// Mean shares over the material's area, as pictures show it, `[band]`.
    pub shown: Vec<MeanShares>,
}

/// Colours of a plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Colors {
    /// Colour of each material; `None` for what is neither leaf nor wood.
    pub materials: Vec<Option<MaterialColor>>,
    /// Surface of each material; `None` for a tint of `mean`.
    pub surfaces: Vec<Option<MaterialSurface>>,
    /// Mean surfaces of all leaf and of all wood, by area: exactly the measured ones where nothing but tints of them is
    /// shown.
    pub mean: Surfaces,
}

/// Decides what the texels of every material mean, and takes the means of what is shown.
pub fn resolve(mesh: &Mesh, classes: &[MaterialClass], measured: &Surfaces, rules: &ColorRules) -> Colors {
    // What alpha cannot cut is refused when it is cut into voxels; until then it has no colour.
    let coverage: Vec<Coverage> = (0..mesh.materials.len())
        .map(|material| Coverage::of(mesh, material).unwrap_or(Coverage::Nothing))
        .collect();
    let mut found = vec![Found::default(); mesh.materials.len()];
    on_surface(mesh, &coverage, |material, color, share| found[material].add(color.as_dvec3(), share));
    found.iter_mut().for_each(Found::end);
    found.iter_mut().zip(are_flowers(mesh)).for_each(|(found, is_flower)| found.is_flower = is_flower);
    let colors = color_bands(measured.bands.iter().map(|band| band.name.as_str()));
    let places = colors.unwrap_or(BY_PLACE);

    let decide = |((material, &class), found): ((&Material, &MaterialClass), &Found)| {
        (class != MaterialClass::Neither).then(|| {
            let surfaces = rules.set(&material.name).map_or(measured, |set| &set.surfaces);
            Decision::of(material, &mesh.images, class, found, surfaces, colors, rules)
        })
    };
    let decisions: Vec<Option<Decision>> =
        mesh.materials.iter().zip(classes).zip(&found).map(decide).collect();
    let shown = show(mesh, &coverage, &found, &decisions, colors);
    let materials: Vec<Option<MaterialColor>> = decisions
        .iter()
        .zip(shown)
        .zip(found.iter().zip(classes))
        .map(|((decision, (clamped, shown)), (found, &class))| {
            let Decision { texture, measured, texel, rule, is_surprise, warning, note, .. } =
                decision.clone()?;
            let of_place = |place: usize| measured.get(place).map(|shares| shares.reflectance);
            let measured = places.into_iter().filter_map(of_place).collect();
            let area_m2 = found.area_m2;
            Some(MaterialColor {
                texture,
                measured,
                texel,
                rule,
                is_leaf: class == MaterialClass::Leaf,
                is_surprise,
                warning,
                note,
                area_m2,
                clamped,
                shown,
            })
        })
        .collect();
    let mean = mean_of(measured, classes, &materials);
    let surface = |(decision, &class): (Option<Decision>, &MaterialClass)| {
        let surface = decision?.surface;
        let is_tint_of_mean = surface.texel == Texel::Tint
            && shares_of(&mean, class).eq(surface
                .reflectance
                .iter()
                .zip(&surface.transmittance)
                .map(|(&reflectance, &transmittance)| MeanShares { reflectance, transmittance }));
        (!is_tint_of_mean).then_some(surface)
    };
    let surfaces = decisions.into_iter().zip(classes).map(surface).collect();
    Colors { materials, surfaces, mean }
}

/// Sums over a material's surface, then means.
#[derive(Debug, Clone, Default)]
struct Found {
    color: DVec3,
    area_m2: f64,
    /// Whether a name tells that it is a flower.
    is_flower: bool,
}

impl Found {
    fn add(&mut self, color: DVec3, share: f64) {
        self.color += color * share;
        self.area_m2 += share;
    }

    fn end(&mut self) {
        if self.area_m2 > 0.0 {
            self.color /= self.area_m2;
        }
    }
}

/// Which materials are flowers: by their names, else by those of all parts that use them, not of nodes above: a plant
/// may be called a flower.
fn are_flowers(mesh: &Mesh) -> Vec<bool> {
    let mut by_parts = vec![None; mesh.materials.len()];
    for part in &mesh.parts {
        let is_flower = told_of_part(part)
            .is_some_and(|(_, name)| is_flower(name) && part.own_names().iter().any(|own| own == name));
        for used in &part.uses {
            let slot = &mut by_parts[used.material as usize];
            *slot = Some(slot.unwrap_or(true) && is_flower);
        }
    }
    let of = |(material, by_parts): (&Material, Option<bool>)| match told_of_material(&mesh.images, material)
    {
        Some(_) => is_flower(&material.name),
        None => by_parts == Some(true),
    };
    mesh.materials.iter().zip(by_parts).map(of).collect()
}

/// What was decided of a material.
#[derive(Debug, Clone)]
struct Decision {
    texture: Option<[f64; 3]>,
    /// `[band]`
    measured: Vec<MeanShares>,
    texel: Texel,
    rule: String,
    is_surprise: bool,
    warning: Option<String>,
    note: Option<String>,
    surface: MaterialSurface,
}

impl Decision {
    fn of(
        material: &Material,
        images: &[Image],
        class: MaterialClass,
        found: &Found,
        surfaces: &Surfaces,
        colors: Option<[usize; 3]>,
        rules: &ColorRules,
    ) -> Decision {
        let is_leaf = class == MaterialClass::Leaf;
        let measured: Vec<MeanShares> = shares_of(surfaces, class).collect();
        let (has_colors, places) = (colors.is_some(), colors.unwrap_or(BY_PLACE));
        let reflected = |color: usize| measured.get(places[color]).map_or(0.0, |shares| shares.reflectance);
        let is_white = material.base_color[..3] == [1.0; 3] && found.color == DVec3::ONE;
        // Who measured these petals knows better.
        let is_flower = is_leaf && found.is_flower && rules.set(&material.name).is_none();
        let is_colored = material.color_texture.is_some() || !is_white || is_flower;
        let image = material.color_texture.and_then(|texture| images.get(texture.image as usize));
        let has_picture = image.is_some_and(|image| image.width > 1 || image.height > 1);
        let texture = (is_colored && found.area_m2 > 0.0).then_some(found.color);
        let asked = rules.source(&material.name, is_leaf);
        let is_measured_asked = matches!(asked, Some((ColorSource::Measured, _)));
        let mut warning = None;
        let (texel, rule, is_surprise) = match (asked, texture) {
            (Some((ColorSource::Measured, origin)), _) => (Texel::Tint, origin, false),
            (Some((ColorSource::Texture, origin)), Some(_)) if has_colors => (Texel::Albedo, origin, false),
            (Some((ColorSource::Texture, origin)), _) => {
                let found = match has_colors {
                    true if found.area_m2 > 0.0 => "found neither a texture nor a base colour".to_owned(),
                    true => "found no surface that alpha leaves".to_owned(),
                    false => {
                        let names = surfaces.bands.iter().map(|band| band.name.as_str());
                        format!("found the bands {}", names.collect::<Vec<_>>().join(", "))
                    }
                };
                let expected = if has_colors { "a colour to take" } else { "R, G and B among them" };
                warning = Some(format!("{origin}: {found}, expected {expected}; taking the measured colour"));
                (Texel::Tint, "no colour of its own".to_owned(), false)
            }
            (None, None) => (Texel::Tint, "no colour of its own".to_owned(), false),
            (None, Some(_)) if !has_colors => (Texel::Tint, "its bands are no colours".to_owned(), false),
            (None, Some(mean)) => {
                let judge = if is_leaf { Evidence::of } else { Evidence::of_wood };
                match judge(mean, DVec3::new(reflected(0), reflected(1), reflected(2))) {
                    Evidence::White if is_flower => {
                        (Texel::Albedo, "its colour is white, and its name a flower's".to_owned(), true)
                    }
                    Evidence::White => {
                        if has_picture {
                            warning = Some("its texture is white; taking the measured colour".to_owned());
                        }
                        (Texel::Tint, "its colour is white".to_owned(), false)
                    }
                    Evidence::Black => {
                        warning = Some("its colour is black; taking the measured one".to_owned());
                        (Texel::Tint, "its colour is black".to_owned(), false)
                    }
                    Evidence::Near(apart) => {
                        (Texel::Tint, format!("near the measured colour, {apart:.2} apart"), false)
                    }
                    Evidence::Far(difference) => {
                        // A user who states what leaves or wood reflect may not know that the mesh has the last word.
                        // Surfaces of leaves come with some of wood, which state nothing where they are common bark's.
                        let is_bark = (0..3).all(|band| (reflected(band) - BARK[band]).abs() < AS_BARK);
                        if (is_leaf || !is_bark) && rules.has_surface(&material.name) {
                            let key = if is_leaf { "leaf_colour" } else { "wood_colour" };
                            warning = Some(format!(
                                "{} states another colour than the mesh has, and the mesh's is taken; {key} = \
                                 \"measured\" takes the one that is stated",
                                rules.file
                            ));
                        }
                        (Texel::Albedo, format!("far from the measured colour, {difference}"), true)
                    }
                }
            }
        };
        // Measured leaves are divided as the file says, unless it is said that they are measured.
        let is_measured = is_measured_asked || rules.has_surface(&material.name);
        let is_used = texel == Texel::Albedo || (is_leaf && !is_measured);
        let stated = material.diffuse_transmission;
        let note = stated.filter(|_| is_leaf && texel == Texel::Tint).map(|stated| match is_used {
            true => format!("of the light that it scatters {:.0} % pass, as its file says", 100.0 * stated),
            false => format!(
                "its file says that {:.0} % of its light pass; what is measured is taken",
                100.0 * stated
            ),
        });
        let passing = stated.filter(|_| is_used).map(|passes| (passes, material.transmission_color));
        let surface = surface_of(passing, texel, &measured, places, found.color.to_array());
        Decision {
            texture: texture.map(|mean| mean.to_array()),
            measured,
            texel,
            rule,
            is_surprise,
            warning,
            note,
            surface,
        }
    }
}

/// What is multiplied by a texel, or by a texel over the mean. Beyond R, G and B it is the measured surface, but for
/// the share that passes. `passing` is that share, and the colour of what passes where it has one of its own; `mean` is
/// that of the texels.
fn surface_of(
    passing: Option<(f32, Option<[f32; 3]>)>,
    texel: Texel,
    measured: &[MeanShares],
    colors: [usize; 3],
    mean: [f64; 3],
) -> MaterialSurface {
    let albedo = albedo_of(measured, colors, mean);
    // A colour of its own for what passes holds in the mean; else it is that of the texel.
    let parts = |band: usize| {
        let (passes, color) = passing?;
        let passes = f64::from(passes).clamp(0.0, 1.0);
        let at = colors.iter().position(|color| *color == band);
        let color = at.zip(color).map_or(1.0, |(at, color)| {
            let ratio = f64::from(color[at]) / mean[at];
            if ratio.is_finite() { ratio.min(MAX_RATIO) } else { 0.0 }
        });
        Some(MeanShares { reflectance: 1.0 - passes, transmittance: passes * color })
    };
    let scale = |(band, shares): (usize, &MeanShares)| match (texel, parts(band)) {
        (Texel::Albedo, Some(parts)) if colors.contains(&band) => parts,
        (Texel::Albedo, None) => {
            colors.iter().position(|color| *color == band).map_or(*shares, |at| albedo[at])
        }
        // All that a measured leaf scatters, divided as the file says.
        (Texel::Tint, Some(parts)) if parts.reflectance + parts.transmittance > 0.0 => {
            let scattered = shares.reflectance + shares.transmittance;
            let scale = scattered / (parts.reflectance + parts.transmittance);
            MeanShares { reflectance: scale * parts.reflectance, transmittance: scale * parts.transmittance }
        }
        _ => *shares,
    };
    let scales = measured.iter().enumerate().map(scale);
    let (reflectance, transmittance) = scales.map(|scale| (scale.reflectance, scale.transmittance)).unzip();
    MaterialSurface { texel, reflectance, transmittance }
}

/// Shares of red, green and blue at a texel of 1 where texels are the albedo: a leaf reflects its texel, and transmits
/// by the measured ratio of the band. Where a colour as bright as the mean would send out more than all light, one
/// ratio serves all bands and one factor scales them, so that white stays white.
fn albedo_of(measured: &[MeanShares], colors: [usize; 3], mean: [f64; 3]) -> [MeanShares; 3] {
    let ratios = colors.map(|band| {
        let ratio = measured.get(band).map_or(0.0, |shares| shares.transmittance / shares.reflectance);
        if ratio.is_finite() { ratio.min(MAX_RATIO) } else { 0.0 }
    });
    let brightest = |ratios: [f64; 3]| {
        let sent = mean.iter().zip(ratios).map(|(color, ratio)| color * (1.0 + ratio));
        sent.fold(1.0, f64::max)
    };
    if brightest(ratios) <= 1.0 {
        return ratios.map(|ratio| MeanShares { reflectance: 1.0, transmittance: ratio });
    }
    let ratio = ratios.into_iter().fold(0.0, f64::max);
    let scale = brightest([ratio; 3]).recip();
    [MeanShares { reflectance: scale, transmittance: scale * ratio }; 3]
}

/// Largest ratio of transmittance to reflectance: a leaf that reflects less of its light than that is black paint.
const MAX_RATIO: f64 = 1e3;

/// Per material: the share of its area that is clamped, and what it shows in each band.
fn show(
    mesh: &Mesh,
    coverage: &[Coverage],
    found: &[Found],
    decisions: &[Option<Decision>],
    colors: Option<[usize; 3]>,
) -> Vec<(f64, Vec<MeanShares>)> {
    let law = |(decision, found): (&Option<Decision>, &Found)| {
        let decision = decision.as_ref()?;
        // Other bands take no colour of texels (SPEC.md, section 9.3).
        Law::of_material(&decision.surface.of_bands(&colors?), found.color.as_vec3().to_array())
    };
    let laws: Vec<Option<Law>> = decisions.iter().zip(found).map(law).collect();
    let mut sums = vec![[DVec3::ZERO; 2]; laws.len()];
    let mut clamped = vec![0.0; laws.len()];
    on_surface(mesh, coverage, |material, color, share| {
        let Some(law) = &laws[material] else { return };
        let shares = law.at(color.to_array());
        let [reflected, transmitted] = &mut sums[material];
        *reflected += DVec3::from(shares.reflectance.map(f64::from)) * share;
        *transmitted += DVec3::from(shares.transmittance.map(f64::from)) * share;
        clamped[material] += if shares.is_clamped { share } else { 0.0 };
    });
    let of = |material: usize| {
        let Some(decision) = &decisions[material] else { return (0.0, Vec::new()) };
        let area_m2 = found[material].area_m2;
        let surface = &decision.surface;
        let own = surface.reflectance.iter().zip(&surface.transmittance);
        let own = own.map(|(&reflectance, &transmittance)| MeanShares { reflectance, transmittance });
        let mut shown: Vec<MeanShares> = match surface.texel {
            Texel::Tint => own.collect(),
            Texel::Albedo => decision.measured.clone(),
        };
        if area_m2 <= 0.0 {
            return (0.0, shown);
        }
        let clamped = clamped[material] / area_m2;
        let [reflected, transmitted] = sums[material].map(|sum| (sum / area_m2).to_array());
        let means: Vec<(usize, MeanShares)> = (0..)
            .zip(colors.into_iter().flatten())
            .map(|(color, place): (usize, usize)| {
                (place, MeanShares { reflectance: reflected[color], transmittance: transmitted[color] })
            })
            .collect();
        let is_near = |(place, mean): &(usize, MeanShares)| {
            let shares = &shown[*place];
            let near = |a: f64, b: f64| (a - b).abs() <= SAMPLING * b;
            near(mean.reflectance, shares.reflectance) && near(mean.transmittance, shares.transmittance)
        };
        let is_measured = decision.texel == Texel::Tint
            && (clamped == 0.0 || laws[material].is_none() || means.iter().all(is_near));
        if !is_measured {
            means.into_iter().for_each(|(place, mean)| shown[place] = mean);
        }
        (clamped, shown)
    };
    (0..laws.len()).map(of).collect()
}

/// By area over the materials of each class; the measured ones where every material shows these.
fn mean_of(measured: &Surfaces, classes: &[MaterialClass], materials: &[Option<MaterialColor>]) -> Surfaces {
    let of_class = |wanted: MaterialClass| -> Vec<MeanShares> {
        let own: Vec<MeanShares> = shares_of(measured, wanted).collect();
        let there: Vec<&MaterialColor> = classes
            .iter()
            .zip(materials)
            .filter(|(class, _)| **class == wanted)
            .filter_map(|(_, material)| material.as_ref().filter(|material| material.area_m2 > 0.0))
            .collect();
        let area_m2: f64 = there.iter().map(|material| material.area_m2).sum();
        if area_m2 <= 0.0 || there.iter().all(|material| material.shown == own) {
            return own;
        }
        let mean = |of: &dyn Fn(&MaterialColor) -> f64| {
            there.iter().map(|material| material.area_m2 * of(material)).sum::<f64>() / area_m2
        };
        (0..own.len())
            .map(|band| MeanShares {
                reflectance: mean(&|material| material.shown[band].reflectance).clamp(0.0, 1.0),
                transmittance: mean(&|material| material.shown[band].transmittance).clamp(0.0, 1.0),
            })
            .collect()
    };
    let [leaf, wood] = [MaterialClass::Leaf, MaterialClass::Wood].map(of_class);
    let bands = measured.bands.iter().zip(leaf).zip(wood);
    let bands = bands.map(|((band, leaf), wood)| {
        let reflectance = leaf.reflectance;
        let transmittance = leaf.transmittance.min(1.0 - reflectance);
        BandSurfaces {
            name: band.name.clone(),
            leaf: LeafSurface { reflectance, transmittance },
            wood: WoodSurface { reflectance: wood.reflectance },
        }
    });
    Surfaces { bands: bands.collect() }
}

/// Of leaf or wood, `[band]`.
fn shares_of(surfaces: &Surfaces, class: MaterialClass) -> impl Iterator<Item = MeanShares> + '_ {
    surfaces.bands.iter().map(move |band| match class {
        MaterialClass::Leaf => {
            MeanShares { reflectance: band.leaf.reflectance, transmittance: band.leaf.transmittance }
        }
        _ => MeanShares { reflectance: band.wood.reflectance, transmittance: 0.0 },
    })
}
