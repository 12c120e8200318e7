//! Triangles of a placed glTF mesh into the soup.

use glam::{DMat3, DMat4, DVec3};
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Mode, Primitive};
use gltf::json::validation::Checked;

use super::accessor::{Accessor, Accessors};
use super::attributes::{self, Attributes, Skin};
use super::morphs;
use super::scene::{Placed, Scene};
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::limits;
use crate::import::points::{Reach, Stored, check_steps};
use crate::import::soup::{FileFrame, Soup, Vertex};

/// Where the triangles of a primitive go.
pub(super) struct Target<'a> {
    /// All triangles so far.
    pub soup: &'a mut Soup,
    /// Axes and unit.
    pub frame: FileFrame,
    /// Index of the primitive's material in the mesh being made.
    pub material: u32,
    /// Number of the set of texture coordinates that the material reads, if it reads one.
    pub tex_coord: Option<u32>,
}

/// Memory that [`add`] takes per triangle: three corners, the vertices among them, and their new numbers.
const CORNERS_BYTES: u64 = 36;

/// Adds one primitive at one place. `name` is for messages.
pub(super) fn add(
    files: &mut Files,
    accessors: &mut Accessors,
    scene: &Scene,
    placed: &Placed,
    primitive: &Primitive,
    name: &str,
    target: Target,
) -> Result<(), ImportError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(files.malformed(name, "an unknown mode", "0..=6"));
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        files.warn(format!("{name} is of {mode:?}, not triangles; ignored"));
        return Ok(());
    }
    let weights = placed
        .node
        .map_or(scene.weights.as_slice(), |node| morphs::of_node(accessors.root, node, placed.mesh));
    let Some(Attributes { positions, normals, uvs, colors, joints }) =
        attributes::open(files, accessors, primitive, weights, name, target.tex_coord.unwrap_or(0))?
    else {
        return Ok(());
    };
    let indices = match primitive.indices {
        Some(index) => {
            let most = 3 * limits::TRIANGLES;
            Some(accessors.open(files, &format!("{name}, indices"), index.value(), &[Type::Scalar], most)?)
        }
        None => None,
    };
    let count = positions.base.count;
    let corners = corners(files, name, mode, indices.as_ref(), count, target.soup.triangles.len())?;
    let skin = Skin::read(files, accessors, scene, placed, joints, name)?;
    if let (None, Some(tex_coord)) = (&uvs, target.tex_coord) {
        files.warn(format!(
            "{name} lacks TEXCOORD_{tex_coord}, which its texture reads: its first texel is taken"
        ));
    }

    let mut used = corners.clone();
    used.sort_unstable();
    used.dedup();
    let mut new_index = Vec::with_capacity(used.len());
    let rigid =
        Transform::new(if placed.skin.is_some() && skin.is_none() { DMat4::IDENTITY } else { placed.world });
    let mut reach = Reach::NONE;
    for &vertex in &used {
        let at = vertex as usize;
        let stored = positions.get(at);
        reach.add(stored);
        let skinned = skin.as_ref().map(|skin| Transform::new(skin.matrix(at)));
        let transform = skinned.as_ref().unwrap_or(&rigid);
        let frame = target.frame;
        let position = transform.matrix.transform_point3(DVec3::from_array(stored)).to_array();
        let position = frame.place(position);
        let turned = |normal| frame.turn(transform.turn_normal(normal));
        let normal = normals.as_ref().map_or([0.0; 3], |normals| turned(normals.get(at)));
        let uv = uvs.as_ref().map_or([0.0; 2], |uvs| uvs.get::<2>(at).map(|x| x as f32));
        let place = || match placed.node {
            Some(node) => format!("{name}, vertex {vertex} (node {node})"),
            None => format!("{name}, vertex {vertex}"),
        };
        let color = colors.as_ref().map(|colors| colors.get(at));
        let vertex = Vertex { position, normal, uv, color };
        new_index.push(target.soup.push_vertex(files, vertex, place)?);
    }
    if positions.base.component() == (ComponentType::F32, false) {
        let triangles = corners.as_chunks::<3>().0.iter();
        let stored = triangles.map(|triangle| triangle.map(|vertex| positions.get(vertex as usize)));
        check_steps(files, &format!("{name}, POSITION"), &reach, Stored::F32, stored)?;
    }
    let lookup = |vertex: u32| new_index[used.binary_search(&vertex).expect("used holds every corner")];
    for &[a, b, c] in corners.as_chunks::<3>().0 {
        // glTF 3.7.4: a mirroring transform turns the winding round.
        let [b, c] = if rigid.mirrors && skin.is_none() { [c, b] } else { [b, c] };
        target.soup.push_triangle(files, [a, b, c].map(lookup), target.material)?;
    }
    files.release(CORNERS_BYTES * corners.len() as u64 / 3);
    Ok(())
}

/// Three vertex numbers per triangle, all below `vertices`; memory for them is held.
fn corners(
    files: &mut Files,
    name: &str,
    mode: Mode,
    indices: Option<&Accessor>,
    vertices: usize,
    triangles_so_far: usize,
) -> Result<Vec<u32>, ImportError> {
    let count = indices.map_or(vertices, |indices| indices.count);
    let triangles = match mode {
        Mode::Triangles => count / 3,
        _ => count.saturating_sub(2),
    };
    if mode == Mode::Triangles && !count.is_multiple_of(3) {
        files.warn(format!("{name}: the last {} of {count} corners make no triangle; ignored", count % 3));
    }
    files.limit("triangles", triangles as u64 + triangles_so_far as u64, limits::TRIANGLES)?;
    files.hold("the corners of triangles", CORNERS_BYTES * triangles as u64)?;
    let vertex = |at: usize| -> Result<u32, ImportError> {
        let Some(indices) = indices else { return Ok(at as u32) };
        match indices.get_index(at) {
            Some(index) if (index as usize) < vertices => Ok(index),
            _ => {
                let [found] = indices.get::<1>(at);
                let place = format!("{name}, index {at}");
                Err(files.malformed(place, format!("vertex {found}"), format!("one of {vertices}")))
            }
        }
    };
    let mut corners = Vec::with_capacity(3 * triangles);
    for triangle in 0..triangles {
        // glTF 3.7.2.1: the corners of triangle i of each topology.
        let at = match mode {
            Mode::TriangleStrip => [triangle, triangle + 1 + triangle % 2, triangle + 2 - triangle % 2],
            Mode::TriangleFan => [triangle + 1, triangle + 2, 0],
            _ => [3 * triangle, 3 * triangle + 1, 3 * triangle + 2],
        };
        for at in at {
            corners.push(vertex(at)?);
        }
    }
    Ok(corners)
}

/// A matrix and what it does to normals.
struct Transform {
    matrix: DMat4,
    /// The cofactor matrix: the inverse transpose times the determinant, defined for flat scales too.
    normal_matrix: DMat3,
    mirrors: bool,
}

impl Transform {
    fn new(matrix: DMat4) -> Transform {
        let linear = DMat3::from_mat4(matrix);
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let mirrors = linear.determinant() < 0.0;
        let sign = if mirrors { -1.0 } else { 1.0 };
        let normal_matrix = DMat3::from_cols(y.cross(z) * sign, z.cross(x) * sign, x.cross(y) * sign);
        Transform { matrix, normal_matrix, mirrors }
    }

    fn turn_normal(&self, normal: [f64; 3]) -> [f64; 3] {
        (self.normal_matrix * DVec3::from_array(normal)).to_array()
    }
}
