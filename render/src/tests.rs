use std::f32::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use flb_format::Daylight;
use flb_scene::mesh::{AlphaMode, Filter, Image, Material, Texture, Wrap};
use flb_scene::sky::{Sky, SkyImage};
use flb_scene::{MaterialClass, Mesh};

use super::*;
use crate::highlight::{Highlight, Highlights};
use crate::reference::{Reference, render_reference};

/// Sums of a few products in f32.
const ROUNDING: f32 = 2e-6;

pub(crate) fn material(name: &str, color: [f32; 3]) -> Material {
    Material { base_color: [color[0], color[1], color[2], 1.0], ..Material::opaque(name) }
}

pub(crate) fn textured(image: u32, wrap: Wrap, alpha_mode: AlphaMode) -> Material {
    let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let texture = Texture { image, wrap: [wrap; 2], transform, filter: Filter::Linear };
    Material { color_texture: Some(texture), alpha_mode, ..material("textured", [1.0; 3]) }
}

/// A row of texels.
pub(crate) fn image(texels: &[[u8; 4]]) -> Image {
    Image {
        name: "texels".into(),
        width: texels.len() as u32,
        height: 1,
        rgba: texels.concat(),
        has_cut: texels.iter().any(|texel| texel[3] < 255),
    }
}

/// Adds a parallelogram from a corner along two edges, u and v from 0 to `repeats`.
pub(crate) fn add_quad(mesh: &mut Mesh, material: u32, corner: [f32; 3], edges: [[f32; 3]; 2], repeats: f32) {
    let first = mesh.positions.len() as u32;
    let [along, up] = edges.map(glam::Vec3::from);
    let normal = along.cross(up).normalize().to_array();
    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        mesh.positions.push((glam::Vec3::from(corner) + along * u + up * v).to_array());
        mesh.normals.push(normal);
        mesh.uvs.push([u * repeats, v * repeats]);
    }
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.triangle_material.extend([material; 2]);
}

/// A wall of 2 m x 2 m that faces south (+Z), where the camera stands.
pub(crate) fn wall(material: Material, images: Vec<Image>, repeats: f32) -> Mesh {
    let mut mesh = Mesh { materials: vec![material], images, ..Mesh::default() };
    add_quad(&mut mesh, 0, [-1.0, -1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], repeats);
    mesh
}

/// The sky of an image of 64 x 32 pixels, whose light is given by column and row.
pub(crate) fn sky_image(light: impl Fn(usize, usize) -> (f32, f32, f32) + Sync) -> Sky {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    exr::prelude::write_rgb_file(&path, 64, 32, light).unwrap();
    Sky::of_image(Arc::new(SkyImage::read(&path).unwrap()))
}

/// Light that knows no facing.
pub(crate) type PointLight<'a> = dyn Fn([f32; 3], &mut [f32; 3]) + Sync + 'a;

/// All settings of a picture.
#[derive(Clone)]
pub(crate) struct Setup {
    pub shading: Shading,
    pub width: u32,
    pub height: u32,
    pub samples: u32,
    pub view_azimuth_deg: f64,
    pub view_elevation_deg: f64,
    pub field_of_view_deg: f64,
    pub ground: bool,
    pub sun: [f64; 3],
    pub sun_strength: f32,
    pub ambient: f32,
    pub sun_color: [f32; 3],
    pub dome: Option<Sky>,
    pub drawn: Option<Sky>,
    pub indirect: Indirect,
    pub indirect_scale: f32,
    pub highlights: Highlights,
    pub sky: bool,
    pub backdrop: bool,
}

impl Default for Setup {
    fn default() -> Setup {
        let portrait = Portrait::default();
        let (Portrait { width, height, samples, view_azimuth_deg, .. }, lighting) =
            (portrait, Lighting::default());
        let Look { indirect, indirect_scale, highlights, has_sky, has_backdrop } = Look::default();
        Setup {
            shading: Shading::Paper,
            width,
            height,
            samples,
            view_azimuth_deg,
            view_elevation_deg: portrait.view_elevation_deg,
            field_of_view_deg: portrait.field_of_view_deg,
            ground: portrait.has_ground,
            sun: lighting.daylight.towards_sun,
            sun_strength: lighting.daylight.sun,
            ambient: lighting.daylight.sky,
            sun_color: lighting.sun_color,
            dome: lighting.dome,
            drawn: lighting.backdrop,
            indirect,
            indirect_scale,
            highlights,
            sky: has_sky,
            backdrop: has_backdrop,
        }
    }
}

impl Setup {
    pub(crate) fn portrait(&self) -> Portrait {
        Portrait {
            width: self.width,
            height: self.height,
            samples: self.samples,
            view_azimuth_deg: self.view_azimuth_deg,
            view_elevation_deg: self.view_elevation_deg,
            field_of_view_deg: self.field_of_view_deg,
            has_ground: self.ground,
        }
    }

    pub(crate) fn lighting(&self) -> Lighting {
        let daylight = Daylight { towards_sun: self.sun, sun: self.sun_strength, sky: self.ambient };
        Lighting {
            daylight,
            sun_color: self.sun_color,
            dome: self.dome.clone(),
            backdrop: self.drawn.clone(),
        }
    }

    pub(crate) fn look(&self) -> Look {
        let Setup { indirect, indirect_scale, highlights, sky: has_sky, backdrop: has_backdrop, .. } = *self;
        Look { indirect, indirect_scale, highlights, has_sky, has_backdrop }
    }
}

/// A picture of a plant in the light of a point.
pub(crate) fn render(
    mesh: &Mesh,
    classes: &[MaterialClass],
    light: &PointLight<'_>,
    setup: &Setup,
) -> Result<Picture, RenderError> {
    let plant = Species { mesh, classes, shading: setup.shading };
    let light = |query: LightQuery, phi: &mut [f32; 3]| light(query.point, phi);
    render_plant(&plant, &setup.portrait(), &setup.lighting(), &setup.look(), &light, &|_| Ok(()))
}

/// The same by paths.
pub(crate) fn reference(
    mesh: &Mesh,
    classes: &[MaterialClass],
    setup: &Setup,
) -> Result<Reference, RenderError> {
    let plant = Species { mesh, classes, shading: setup.shading };
    render_reference(&plant, &setup.portrait(), &setup.lighting(), &setup.look(), &|_| Ok(()))
}

/// All surfaces alike.
pub(crate) fn glossy(strength: f32) -> Highlights {
    let one = Highlight { strength, exponent: 6.0 };
    Highlights { leaf: one, wood: one, water: one }
}

pub(crate) fn plain() -> Setup {
    Setup {
        width: 32,
        height: 32,
        samples: 1,
        sun: [0.0, 0.0, 1.0],
        highlights: Highlights::MATT,
        view_elevation_deg: 0.0,
        ground: false,
        sky: false,
        indirect: Indirect::Off,
        ..Setup::default()
    }
}

pub(crate) fn dark(_: [f32; 3], phi: &mut [f32; 3]) {
    *phi = [0.0; 3];
}

/// Brighter towards the top and towards the east.
fn uneven(point: [f32; 3], phi: &mut [f32; 3]) {
    *phi = [0.5 + 0.2 * point[0], 0.7 + 0.3 * point[1], 0.4 + 0.1 * point[2]];
}

pub(crate) fn shoot(mesh: &Mesh, light: &PointLight<'_>, settings: &Setup) -> Picture {
    let classes = vec![MaterialClass::Leaf; mesh.materials.len()];
    render(mesh, &classes, light, settings).unwrap()
}

pub(crate) fn at(picture: &Picture, x: u32, y: u32) -> [f32; 3] {
    let first = ((y * picture.width + x) * 3) as usize;
    picture.rgb[first..first + 3].try_into().unwrap()
}

pub(crate) fn assert_close(found: [f32; 3], expected: [f32; 3]) {
    let far = (0..3).any(|band| (found[band] - expected[band]).abs() > ROUNDING);
    assert!(!far, "found {found:?}, expected {expected:?}");
}

#[test]
fn a_wall_sends_out_its_color_times_the_cosine() {
    let mesh = wall(material("wall", [0.8, 0.5, 0.2]), vec![], 1.0);
    assert_close(at(&shoot(&mesh, &dark, &plain()), 16, 16), [0.8, 0.5, 0.2]);
    let slanted = Setup { sun: [3.0, 0.0, 3.0], sun_strength: 2.0, ..plain() };
    let expected = [0.8, 0.5, 0.2].map(|v| v * 2.0 * FRAC_1_SQRT_2);
    assert_close(at(&shoot(&mesh, &dark, &slanted), 16, 16), expected);
}

#[test]
fn both_sides_of_a_leaf_are_lit_and_only_on_the_side_of_the_sun() {
    let mesh = wall(material("leaf", [0.5; 3]), vec![], 1.0);
    let north = Setup { sun: [0.0, 0.0, -1.0], view_azimuth_deg: 0.0, ..plain() };
    assert_close(at(&shoot(&mesh, &dark, &north), 16, 16), [0.5; 3]);
    let against = Setup { sun: [0.0, 0.0, -1.0], ..plain() };
    assert_close(at(&shoot(&mesh, &dark, &against), 16, 16), [0.0; 3]);
    let mut turned = mesh.clone();
    turned.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    turned.normals.iter_mut().for_each(|n| *n = n.map(|v| -v));
    assert_eq!(shoot(&turned, &dark, &plain()), shoot(&mesh, &dark, &plain()));
}

/// The wall, and in front of it (south of it, off the line of sight) a leaf whose shadow the low western sun
/// casts on the wall's middle.
fn wall_behind_leaf(leaf: Material, images: Vec<Image>) -> Mesh {
    let mut mesh = wall(material("wall", [1.0; 3]), images, 1.0);
    mesh.materials.push(leaf);
    // Towards the sun is (-1, 0, 1): a leaf at x = -1.5, z = 1.5 shades x = 0.
    add_quad(&mut mesh, 1, [-1.8, -0.3, 1.5], [[0.6, 0.0, 0.0], [0.0, 0.6, 0.0]], 1.0);
    mesh
}

/// Finds the pixel of a point on the wall by a light that knows where it is asked.
pub(crate) fn pixel_of(mesh: &Mesh, settings: &Setup, point: [f32; 2]) -> [u32; 2] {
    let place = |p: [f32; 3], phi: &mut [f32; 3]| {
        *phi = if p[2].abs() < 0.01 { [p[0] + 5.0, p[1] + 5.0, 1.0] } else { [0.0; 3] };
    };
    let settings = Setup { indirect: Indirect::Only, indirect_scale: 1.0, ..settings.clone() };
    let picture = shoot(mesh, &place, &settings);
    let mut best = (f32::INFINITY, [0, 0]);
    for y in 0..settings.height {
        for x in 0..settings.width {
            let [px, py, on_wall] = at(&picture, x, y);
            let off = libm::hypotf(px - 5.0 - point[0], py - 5.0 - point[1]);
            if on_wall > 0.5 && off < best.0 {
                best = (off, [x, y]);
            }
        }
    }
    assert!(best.0 < 0.1, "no pixel near {point:?}");
    best.1
}

#[test]
fn a_shadow_falls_where_it_should_and_a_cut_leaf_lets_the_sun_through() {
    let settings = Setup { width: 96, height: 96, sun: [-1.0, 0.0, 1.0], ..plain() };
    let lit = [FRAC_1_SQRT_2; 3];
    let opaque = wall_behind_leaf(material("leaf", [0.3; 3]), vec![]);
    let picture = shoot(&opaque, &dark, &settings);
    for (point, expected) in [
        ([0.0, 0.0], [0.0; 3]),
        ([0.2, 0.2], [0.0; 3]),
        ([0.5, 0.0], lit),
        ([-0.5, 0.0], lit),
        ([0.0, 0.5], lit),
    ] {
        let [x, y] = pixel_of(&opaque, &settings, point);
        assert_close(at(&picture, x, y), expected);
    }
    // The western half of the leaf (texel 0) is cut away, the eastern (texel 1) is there.
    let halves = image(&[[0, 255, 0, 100], [0, 255, 0, 140]]);
    let cut = textured(0, Wrap::Clamp, AlphaMode::Cut { cutoff: 0.5 });
    let mesh = wall_behind_leaf(cut, vec![halves.clone()]);
    let picture = shoot(&mesh, &dark, &settings);
    let [west, east] = [-0.15, 0.15].map(|x| pixel_of(&mesh, &settings, [x, 0.0]));
    assert_close(at(&picture, west[0], west[1]), lit);
    assert_close(at(&picture, east[0], east[1]), [0.0; 3]);
    // With the cut ignored, all of it is in the way again.
    let mesh = wall_behind_leaf(textured(0, Wrap::Clamp, AlphaMode::Opaque), vec![halves]);
    assert_close(at(&shoot(&mesh, &dark, &settings), west[0], west[1]), [0.0; 3]);
}

#[test]
fn a_ray_passes_through_what_is_cut_away_to_what_lies_behind() {
    let gone = textured(0, Wrap::Repeat, AlphaMode::Cut { cutoff: 0.5 });
    let mut mesh = wall(gone, vec![image(&[[255, 0, 0, 0]])], 1.0);
    mesh.materials.push(material("behind", [0.1, 0.2, 0.3]));
    add_quad(&mut mesh, 1, [-1.0, -1.0, -0.5], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], 1.0);
    let everywhere = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [1.0; 3];
    let settings = Setup { indirect: Indirect::Only, indirect_scale: 1.0, ..plain() };
    assert_close(at(&shoot(&mesh, &everywhere, &settings), 16, 16), [0.1, 0.2, 0.3]);
}

#[test]
fn direct_and_indirect_add_up() {
    let mut mesh = wall_behind_leaf(material("leaf", [0.2, 0.6, 0.1]), vec![]);
    add_quad(&mut mesh, 0, [-1.0, -1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0]], 1.0);
    let settings = Setup {
        sun: [-0.6, 0.7, 0.4],
        samples: 4,
        ground: true,
        sky: true,
        highlights: glossy(0.1),
        view_elevation_deg: 20.0,
        ..plain()
    };
    let [on, off, only] = [Indirect::On, Indirect::Off, Indirect::Only]
        .map(|indirect| shoot(&mesh, &uneven, &Setup { indirect, ..settings.clone() }));
    assert!(off.rgb.iter().any(|&v| v > 0.1) && only.rgb.iter().any(|&v| v > 0.1));
    for (at, &on) in on.rgb.iter().enumerate() {
        let sum = off.rgb[at] + only.rgb[at];
        assert!((on - sum).abs() < ROUNDING, "value {at}: {on} is not {} + {}", off.rgb[at], only.rgb[at]);
    }
}

#[test]
fn the_side_of_the_sun_is_the_bright_side() {
    // A tent whose ridge points at the camera: one slope faces west (left), the other east.
    let mut mesh = Mesh { materials: vec![material("tent", [0.7; 3])], ..Mesh::default() };
    add_quad(&mut mesh, 0, [-1.0, 0.0, -1.0], [[0.0, 0.0, 2.0], [1.0, 1.0, 0.0]], 1.0);
    add_quad(&mut mesh, 0, [1.0, 0.0, 1.0], [[0.0, 0.0, -2.0], [-1.0, 1.0, 0.0]], 1.0);
    let half = |picture: &Picture, from: u32| -> f32 {
        (0..32).flat_map(|y| (from..from + 16).map(move |x| (x, y))).map(|(x, y)| at(picture, x, y)[0]).sum()
    };
    let settings = |x: f64| Setup { sun: [x, 0.3, 0.0], view_elevation_deg: 40.0, ..plain() };
    let (west, east) = (shoot(&mesh, &dark, &settings(-1.0)), shoot(&mesh, &dark, &settings(1.0)));
    assert!(half(&west, 0) > 10.0 && half(&west, 16) < 1.0, "{} {}", half(&west, 0), half(&west, 16));
    assert!(half(&east, 16) > 10.0 && half(&east, 0) < 1.0, "{} {}", half(&east, 0), half(&east, 16));
}

#[test]
fn texture_coordinates_wrap_as_the_texture_says() {
    // u runs from 0 to 4 over the wall: black and white texels, four copies, mirrored ones, or one edge.
    let texels = image(&[[0, 0, 0, 255], [255, 255, 255, 255]]);
    let plain_wall = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let everywhere = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [1.0; 3];
    let settings = Setup { indirect: Indirect::Only, indirect_scale: 1.0, ..plain() };
    for (wrap, expected) in [
        (Wrap::Repeat, [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]),
        (Wrap::Mirror, [0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0]),
        (Wrap::Clamp, [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
    ] {
        let mesh = wall(textured(0, wrap, AlphaMode::Opaque), vec![texels.clone()], 4.0);
        let settings = Setup { width: 128, height: 128, ..settings.clone() };
        let picture = shoot(&mesh, &everywhere, &settings);
        for (texel, &expected) in expected.iter().enumerate() {
            let x = -1.0 + (texel as f32 + 0.5) * 0.25;
            let [x, y] = pixel_of(&plain_wall, &settings, [x, 0.05]);
            let found = at(&picture, x, y)[0];
            assert!((found - expected).abs() < 0.1, "{wrap:?}, texel {texel}: {found}, expected {expected}");
        }
    }
}

#[test]
fn color_is_read_as_srgb() {
    let gray = image(&[[128, 188, 0, 255]]);
    let mesh = wall(textured(0, Wrap::Repeat, AlphaMode::Opaque), vec![gray], 1.0);
    let found = at(&shoot(&mesh, &dark, &plain()), 16, 16);
    assert_close(found, [0.215_860_5, 0.502_886_5, 0.0]);
}

#[test]
fn threads_do_not_change_a_picture() {
    let mesh = wall_behind_leaf(material("leaf", [0.2, 0.6, 0.1]), vec![]);
    let settings = Setup { samples: 5, ground: true, sky: true, sun: [-1.0, 0.5, 1.0], ..plain() };
    let pictures = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shoot(&mesh, &uneven, &settings))
    });
    assert_eq!(pictures[0], pictures[1]);
    assert_eq!(pictures[0], pictures[2]);
}

#[test]
fn the_whole_plant_lies_inside_the_picture() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    for (azimuth, elevation, width, height) in
        [(180.0, 0.0, 40, 40), (140.0, 50.0, 64, 24), (30.0, -60.0, 20, 60)]
    {
        let settings = Setup {
            width,
            height,
            view_azimuth_deg: azimuth,
            view_elevation_deg: elevation,
            indirect: Indirect::Only,
            ..plain()
        };
        let bright = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [1.0; 3];
        let picture = shoot(&mesh, &bright, &settings);
        let is_lit = |x: u32, y: u32| at(&picture, x, y)[0] > 0.0;
        assert!((0..width).all(|x| !is_lit(x, 0) && !is_lit(x, height - 1)));
        assert!((0..height).all(|y| !is_lit(0, y) && !is_lit(width - 1, y)));
        let lit = (0..width).flat_map(|x| (0..height).map(move |y| (x, y))).filter(|&(x, y)| is_lit(x, y));
        let share = lit.count() as f32 / (width * height) as f32;
        assert!(share > 0.1, "{azimuth} {elevation}: only {share} of the picture is plant");
    }
}

#[test]
fn settings_outside_their_limits_are_refused_by_name() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let refused = |change: &dyn Fn(&mut Setup)| {
        let mut settings = plain();
        change(&mut settings);
        render(&mesh, &[MaterialClass::Leaf], &dark, &settings).unwrap_err().to_string()
    };
    assert_eq!(refused(&|s| s.width = 0), "render setting `width` is 0, expected 1..=16384");
    assert_eq!(refused(&|s| s.height = 16_385), "render setting `height` is 16385, expected 1..=16384");
    assert!(refused(&|s| (s.width, s.height) = (16_384, 8_192)).contains("at most 67108864 pixels"));
    assert_eq!(refused(&|s| s.samples = 4_097), "render setting `samples` is 4097, expected 1..=4096");
    assert!(refused(&|s| s.sun = [0.0; 3]).contains("`towards_sun` is [0.0, 0.0, 0.0]"));
    assert!(refused(&|s| s.sun[1] = f64::NAN).contains("`towards_sun`"));
    assert!(refused(&|s| s.sun_strength = f32::NAN).contains("`sun` is NaN"));
    assert!(refused(&|s| s.ambient = -1.0).contains("`sky` is -1"));
    assert!(refused(&|s| s.indirect_scale = f32::INFINITY).contains("`indirect_scale` is inf"));
    assert!(refused(&|s| s.view_elevation_deg = 90.0).contains("`view_elevation_deg` is 90"));
    assert!(refused(&|s| s.field_of_view_deg = 0.0).contains("`field_of_view_deg` is 0"));
}

#[test]
fn meshes_that_cannot_be_rendered_are_refused() {
    let classes = [MaterialClass::Leaf];
    let refused = |mesh: &Mesh, classes: &[MaterialClass]| {
        render(mesh, classes, &dark, &plain()).unwrap_err().to_string()
    };
    let good = wall(material("wall", [1.0; 3]), vec![], 1.0);
    assert!(refused(&Mesh::default(), &[]).contains("no triangles"));
    assert_eq!(refused(&good, &[]), "0 material classes for a mesh with 1 materials");
    let mut bad = good.clone();
    bad.positions[2][1] = f32::NAN;
    assert!(refused(&bad, &classes).starts_with("triangle 0: vertex 2 lies at"));
    let mut bad = good.clone();
    bad.triangles[1][2] = 4;
    assert_eq!(refused(&bad, &classes), "triangle 1: vertex 4 of 4");
    let mut bad = good.clone();
    bad.triangle_material[1] = 7;
    assert_eq!(refused(&bad, &classes), "triangle 1: material 7 of 1");
    let mut bad = good;
    bad.triangle_material.pop();
    assert!(refused(&bad, &classes).contains("2 triangles but 1 material indices"));
}

#[test]
fn light_that_is_not_finite_is_an_error() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let settings = Setup { indirect: Indirect::On, ..plain() };
    let broken = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [0.0, f32::NAN, 0.0];
    let error = render(&mesh, &[MaterialClass::Leaf], &broken, &settings).unwrap_err();
    assert!(matches!(error, RenderError::NotFinite { band: "G", .. }), "{error}");
}

#[test]
fn many_coincident_triangles_are_rendered() {
    let mut mesh = wall(material("wall", [0.5; 3]), vec![], 1.0);
    for _ in 0..3_000 {
        add_quad(&mut mesh, 0, [-1.0, -1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], 1.0);
    }
    assert_close(at(&shoot(&mesh, &dark, &Setup { width: 8, height: 8, ..plain() }), 4, 4), [0.5; 3]);
}

#[test]
fn a_grown_plant_renders_with_leaves_in_the_sky_and_a_shadow_on_the_ground() {
    let mesh = oak(4_000);
    let settings = Setup { width: 64, height: 64, samples: 2, sun: [1.0, 1.0, 0.0], ..Setup::default() };
    let picture = shoot(&mesh, &dark, &settings);
    let [r, g, b] = (22..42)
        .flat_map(|x| (10..30).map(move |y| (x, y)))
        .map(|(x, y)| at(&picture, x, y))
        .fold([0.0; 3], |sum, rgb| [0, 1, 2].map(|band| sum[band] + rgb[band]));
    assert!(g > r && g > b, "a crown is green: {r} {g} {b}");
    let light_below = |ground: bool| -> f32 {
        let picture = shoot(&mesh, &dark, &Setup { ground, sky: false, ..settings.clone() });
        (0..20).flat_map(|x| (50..60).map(move |y| (x, y))).map(|(x, y)| at(&picture, x, y)[0]).sum()
    };
    assert!(light_below(true) > light_below(false));
}

/// A grown oak: material 0 is wood, 1 leaves.
pub(crate) fn oak(triangles: u32) -> Mesh {
    grown(flb_fixtures::PlantKind::Oak, triangles)
}

/// A built-in plant: bark, then leaves.
pub(crate) fn grown(kind: flb_fixtures::PlantKind, triangles: u32) -> Mesh {
    flb_testkit::grown::mesh(&flb_fixtures::grow(kind, 1, triangles).unwrap(), [1.0; 4])
}
