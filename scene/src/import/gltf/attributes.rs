//! The attributes of a primitive as its vertices have them in the end: with morph targets by their weights, colours,
//! and joints of all sets.

use glam::DMat4;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use super::accessor::{Accessor, Accessors};
use super::scene::{Placed, Scene};
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::known::gltf::{DECODE, advice_against};
use crate::import::limits;

/// Attributes of one primitive.
pub(super) struct Attributes<'a> {
    /// POSITION, morphed.
    pub positions: Morphed<'a>,
    /// NORMAL, morphed.
    pub normals: Option<Morphed<'a>>,
    /// TEXCOORD of the set that was asked for.
    pub uvs: Option<Accessor<'a>>,
    /// COLOR_0.
    pub colors: Option<Colors<'a>>,
    /// JOINTS_n and WEIGHTS_n, set by set.
    pub joints: Vec<[Accessor<'a>; 2]>,
}

/// An accessor with the weighted displacements of morph targets.
pub(super) struct Morphed<'a> {
    /// Values at rest.
    pub base: Accessor<'a>,
    targets: Vec<(f64, Accessor<'a>)>,
}

impl Morphed<'_> {
    /// Element `at` of three components.
    pub(super) fn get(&self, at: usize) -> [f64; 3] {
        let mut sum = self.base.get::<3>(at);
        for (weight, target) in &self.targets {
            let moved = target.get::<3>(at);
            sum = std::array::from_fn(|axis| sum[axis] + weight * moved[axis]);
        }
        sum
    }
}

/// Colours of vertices.
pub(super) struct Colors<'a> {
    accessor: Accessor<'a>,
    /// 1 over what stands for white.
    scale: f64,
}

impl Colors<'_> {
    /// Linear R, G, B and alpha of vertex `at`.
    pub(super) fn get(&self, at: usize) -> [f32; 4] {
        let mut color = [1.0 / self.scale; 4];
        self.accessor.read(at, &mut color);
        color.map(|value| (value * self.scale) as f32)
    }
}

/// Opens what a primitive has; `None` where it has no positions, which is a warning. `weights` are those of its
/// morph targets, `name` is for messages.
pub(super) fn open<'a>(
    files: &mut Files,
    accessors: &mut Accessors<'a>,
    primitive: &Primitive,
    weights: &[f32],
    name: &str,
    tex_coord: u32,
) -> Result<Option<Attributes<'a>>, ImportError> {
    let root = accessors.root;
    let attribute =
        |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
    let Some(position) = attribute(Semantic::Positions) else {
        refuse_compressed(files, primitive, name)?;
        files.warn(format!("{name} has no POSITION; ignored"));
        return Ok(None);
    };
    for (what, index) in [("POSITION", Some(position)), ("indices", primitive.indices.map(|i| i.value()))] {
        check_stored(files, root, primitive, &format!("{name}, {what}"), index)?;
    }
    let most = u64::from(u32::MAX);
    let base = accessors.open(files, &format!("{name}, POSITION"), position, &[Type::Vec3], most)?;
    let count = base.count;
    for (what, semantic) in [
        ("NORMAL", Semantic::Normals),
        ("TEXCOORD", Semantic::TexCoords(tex_coord)),
        ("COLOR_0", Semantic::Colors(0)),
    ] {
        let Some(index) = attribute(semantic) else { continue };
        let accessor = root.accessors.get(index);
        if accessor.is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none()) {
            let place = format!("{name}, {what}");
            refuse_compressed(files, primitive, &place)?;
            files.warn(format!("{place}: its accessor has no bufferView, so that all its numbers are 0"));
        }
    }
    if primitive.targets.iter().flatten().zip(weights).any(|(_, weight)| *weight != 0.0) {
        files.note("morph targets are read by the weights of nodes and meshes".to_owned());
    }
    let sized = |accessors: &mut Accessors<'a>, what: &str, index: Option<usize>, types: &[Type]| {
        let Some(index) = index else { return Ok(None) };
        let accessor = accessors.open(files, &format!("{name}, {what}"), index, types, most)?;
        if accessor.count != count {
            let found = format!("{} of {what}", accessor.count);
            return Err(files.malformed(name, found, format!("{count} as of POSITION")));
        }
        Ok(Some(accessor))
    };
    let normals = sized(accessors, "NORMAL", attribute(Semantic::Normals), &[Type::Vec3])?;
    let uvs = sized(accessors, "TEXCOORD", attribute(Semantic::TexCoords(tex_coord)), &[Type::Vec2])?;
    let colors = sized(accessors, "COLOR_0", attribute(Semantic::Colors(0)), &[Type::Vec3, Type::Vec4])?;
    let mut joints = Vec::new();
    while let (Some(joint), Some(weight)) =
        (attribute(Semantic::Joints(joints.len() as u32)), attribute(Semantic::Weights(joints.len() as u32)))
    {
        let set = joints.len();
        let joint = sized(accessors, &format!("JOINTS_{set}"), Some(joint), &[Type::Vec4])?;
        let weight = sized(accessors, &format!("WEIGHTS_{set}"), Some(weight), &[Type::Vec4])?;
        joints.extend(joint.zip(weight).map(|(joint, weight)| [joint, weight]));
    }
    let targets = |accessors: &mut Accessors<'a>, normals: bool| {
        let mut found = Vec::new();
        for (target, &weight) in primitive.targets.iter().flatten().zip(weights) {
            let (what, index) = match normals {
                false => ("POSITION of a morph target", target.positions),
                true => ("NORMAL of a morph target", target.normals),
            };
            let index = index.filter(|_| weight != 0.0).map(|index: Index<_>| index.value());
            if let Some(accessor) = sized(accessors, what, index, &[Type::Vec3])? {
                accessors.work += accessor.count as u64;
                files.limit("elements of morph targets read", accessors.work, 4 * limits::VERTICES)?;
                found.push((f64::from(weight), accessor));
            }
        }
        Ok::<_, ImportError>(found)
    };
    let positions = Morphed { base, targets: targets(accessors, false)? };
    let normals = match normals {
        Some(base) => Some(Morphed { base, targets: targets(accessors, true)? }),
        None => None,
    };
    let colors = match colors {
        Some(accessor) => Some(colors_of(files, name, accessor)?),
        None => None,
    };
    Ok(Some(Attributes { positions, normals, uvs, colors, joints }))
}

/// glTF 3.7.2.1 allows floats and normalised integers. Integers that are not normalised are meant to be.
fn colors_of<'a>(files: &mut Files, name: &str, accessor: Accessor<'a>) -> Result<Colors<'a>, ImportError> {
    use ComponentType::{F32, U8, U16};
    let largest = match accessor.component() {
        (F32, _) | (U8 | U16, true) => 1.0,
        (U8, false) => 255.0,
        (U16, false) => 65535.0,
        _ => {
            let kinds = [(F32, false), (U8, true), (U16, true)];
            accessor.check_components(files, &format!("{name}, COLOR_0"), &kinds)?;
            1.0
        }
    };
    if largest > 1.0 {
        files.warn(format!("{name}, COLOR_0: integers that are not normalised; taken as if they were"));
    }
    Ok(Colors { accessor, scale: 1.0 / largest })
}

/// An error where the data of an accessor are somewhere else than in a view, as compressed ones are.
fn check_stored(
    files: &Files,
    root: &Root,
    primitive: &Primitive,
    place: &str,
    index: Option<usize>,
) -> Result<(), ImportError> {
    let Some(accessor) = index.and_then(|index| root.accessors.get(index)) else { return Ok(()) };
    if accessor.buffer_view.is_some() || accessor.sparse.is_some() || accessor.count.0 == 0 {
        return Ok(());
    }
    refuse_compressed(files, primitive, place)?;
    Err(files.malformed(place, "an accessor without bufferView", "numbers stored in a bufferView"))
}

/// An error that names the extensions of a primitive whose geometry is not where glTF has it.
fn refuse_compressed(files: &Files, primitive: &Primitive, place: &str) -> Result<(), ImportError> {
    let others = primitive.extensions.iter().flat_map(|extensions| extensions.others.keys());
    // Those that are known and not refused say something beside the geometry.
    let names: Vec<&str> = others.map(String::as_str).filter(|name| advice_against(name).is_some()).collect();
    if names.is_empty() {
        return Ok(());
    }
    let name =
        format!("{}, which is not supported: the geometry of {place} is nowhere else", names.join(", "));
    let advice = names.iter().find_map(|name| advice_against(name)).filter(|advice| !advice.is_empty());
    Err(ImportError::RequiredExtension { file: files.file.clone(), name, advice: advice.unwrap_or(DECODE) })
}

/// The skin of a placed mesh.
pub(super) struct Skin<'a> {
    joints: Vec<[Accessor<'a>; 2]>,
    matrices: Vec<DMat4>,
}

impl<'a> Skin<'a> {
    /// `None` where the mesh has none, or none that can be read, which is a warning.
    pub(super) fn read(
        files: &mut Files,
        accessors: &mut Accessors<'a>,
        scene: &Scene,
        placed: &Placed,
        joints: Vec<[Accessor<'a>; 2]>,
        name: &str,
    ) -> Result<Option<Skin<'a>>, ImportError> {
        let Some(skin) = placed.skin else { return Ok(None) };
        let matrices = match joints.is_empty() {
            true => None,
            false => read_matrices(files, accessors, scene, skin)?,
        };
        if matrices.is_none() {
            files.warn(format!("{name} has a skin that cannot be read; it stands as stored"));
        }
        let skin = matrices.map(|matrices| Skin { joints, matrices });
        if skin.is_some() {
            files.note("skins are read in the pose that the file's joints have".to_owned());
        }
        if let Some(skin) = &skin {
            let count = skin.joints.first().map_or(0, |[joints, _]| joints.count);
            let odd = (0..count).filter(|&vertex| !skin.holds(vertex)).count();
            if odd > 0 {
                let joints = skin.matrices.len();
                files.warn(format!(
                    "{name}: {odd} of {count} vertices have no weight, or one on a joint that is not among the {joints} \
                     of its skin; those joints were left out"
                ));
            }
        }
        Ok(skin)
    }

    /// Joints and weights of a vertex, set by set.
    fn sets(&self, vertex: usize) -> impl Iterator<Item = [(usize, f64); 4]> {
        self.joints.iter().map(move |[joints, weights]| {
            let (joints, weights) = (joints.get::<4>(vertex), weights.get::<4>(vertex));
            std::array::from_fn(|k| (joints[k] as usize, weights[k]))
        })
    }

    /// Whether a vertex has a weight, and none on a joint that the skin lacks.
    fn holds(&self, vertex: usize) -> bool {
        let mut weighty = self.sets(vertex).flatten().filter(|(_, weight)| *weight > 0.0).peekable();
        weighty.peek().is_some() && weighty.all(|(joint, _)| joint < self.matrices.len())
    }

    /// glTF 3.7.3.1: the weighted sum of the joints' matrices. The node's own transform is ignored.
    pub(super) fn matrix(&self, vertex: usize) -> DMat4 {
        let known = |(joint, _): &(usize, f64)| *joint < self.matrices.len();
        let of_set =
            |set: [(usize, f64); 4]| set.into_iter().filter(known).map(|(_, weight)| weight).sum::<f64>();
        let total: f64 = self.sets(vertex).map(of_set).sum();
        let mut sum = DMat4::ZERO;
        for (joint, weight) in self.sets(vertex).flatten().filter(known) {
            if weight > 0.0 {
                sum += self.matrices[joint] * (weight / total);
            }
        }
        if sum == DMat4::ZERO { DMat4::IDENTITY } else { sum }
    }
}

/// `world_from_mesh` of each joint; `None` if a joint is not in the scene.
fn read_matrices(
    files: &mut Files,
    accessors: &mut Accessors,
    scene: &Scene,
    index: usize,
) -> Result<Option<Vec<DMat4>>, ImportError> {
    let root = accessors.root;
    let place = format!("skins[{index}]");
    let Some(skin) = root.skins.get(index) else {
        return Err(files.malformed(
            "the node tree",
            format!("skin {index}"),
            format!("one of {}", root.skins.len()),
        ));
    };
    let most = limits::MATERIALS;
    files.limit(format!("{place}: joints"), skin.joints.len() as u64, most)?;
    accessors.work += skin.joints.len() as u64;
    files.limit("skin joints read", accessors.work, 4 * limits::VERTICES)?;
    let inverse_bind = match skin.inverse_bind_matrices {
        Some(accessor) => Some(accessors.open(files, &place, accessor.value(), &[Type::Mat4], most)?),
        None => None,
    };
    let joint = |(at, node): (usize, usize)| -> Option<DMat4> {
        let world = *scene.worlds.get(node)?;
        let inverse = match &inverse_bind {
            Some(matrices) => DMat4::from_cols_array(&(at < matrices.count).then(|| matrices.get::<16>(at))?),
            None => DMat4::IDENTITY,
        };
        Some(world? * inverse)
    };
    Ok(skin.joints.iter().map(|node| node.value()).enumerate().map(joint).collect())
}
