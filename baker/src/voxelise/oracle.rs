//! Voxelising without any acceleration: every triangle against every voxel, all thirteen axes, every texel.
//! The same definitions as [`super::voxelise`], for grids of at most 64^3; tests compare the two exactly.

use super::clips::Clips;
use super::cutter::Cutter;
use super::occupancy::{CLUSTER_EDGE, Cluster};
use super::triangle::UNITS;
use super::{Scene, VoxelError, VoxelSettings};
use flb_scene::{MaterialClass, Mesh};

/// Largest number of voxels per edge.
pub const MAX_VOXELS: u32 = 64;

/// The clusters that [`super::voxelise`] finds, by brute force.
///
/// # Errors
/// As [`super::voxelise`], and more than 64 voxels per edge.
pub fn clusters(
    mesh: &Mesh,
    classes: &[MaterialClass],
    settings: &VoxelSettings,
) -> Result<Vec<Cluster>, VoxelError> {
    if settings.voxels > MAX_VOXELS {
        let &VoxelSettings { voxels: found, lattice, .. } = settings;
        return Err(VoxelError::Voxels { found, lattice, limit: MAX_VOXELS });
    }
    let scene = Scene::new(mesh, classes, settings)?;
    let edge = (settings.voxels / CLUSTER_EDGE) as u16;
    let positions = (0..edge).flat_map(|z| (0..edge).flat_map(move |y| (0..edge).map(move |x| [x, y, z])));
    let mut clusters: Vec<Cluster> = positions.map(Cluster::empty).collect();
    for triangle in (0..mesh.triangles.len()).filter_map(|triangle| scene.snapped(triangle)) {
        for cluster in &mut clusters {
            for index in 0..512 {
                let inner = [index % 8, index / 8 % 8, index / 64];
                let voxel: [i64; 3] =
                    std::array::from_fn(|axis| i64::from(cluster.position[axis]) * 8 + inner[axis] as i64);
                let present = || {
                    triangle.cut.as_ref().is_none_or(|cut| {
                        Cutter::new(&triangle, cut, 2, &mut Clips::new())
                            .touches(voxel, |piece, within| cut.cut.touches_by_every_texel(piece, within))
                    })
                };
                if overlaps(&triangle.vertices, voxel) && present() {
                    let words = if triangle.wood { &mut cluster.wood } else { &mut cluster.leaf };
                    words[inner[2]] |= 1 << (inner[1] * 8 + inner[0]);
                }
            }
        }
    }
    clusters.retain(|cluster| cluster.leaf.iter().chain(&cluster.wood).any(|&word| word != 0));
    Ok(clusters)
}

/// The separating axis test (Akenine-Moller 2001), axis by axis, closed.
fn overlaps(vertices: &[[i64; 3]; 3], voxel: [i64; 3]) -> bool {
    let wide = vertices.map(|vertex| vertex.map(i128::from));
    let unit_axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let edges: [[i128; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|axis| wide[(i + 1) % 3][axis] - wide[i][axis]));
    let cross = |a: [i128; 3], b: [i128; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [i128; 3], b: [i128; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mut axes = unit_axes.to_vec();
    axes.push(cross(edges[0], edges[1]));
    axes.extend(unit_axes.iter().flat_map(|&unit| edges.map(|edge| cross(unit, edge))));
    let corners: [[i128; 3]; 8] = std::array::from_fn(|corner| {
        std::array::from_fn(|axis| i128::from((voxel[axis] + (corner as i64 >> axis & 1)) * UNITS))
    });
    axes.into_iter().all(|axis| {
        let range = |points: &[[i128; 3]]| {
            let along = points.iter().map(|&point| dot(axis, point));
            (along.clone().min().expect("points"), along.max().expect("points"))
        };
        let ((low, high), (box_low, box_high)) = (range(&wide), range(&corners));
        low <= box_high && box_low <= high
    })
}
