//! Doubts about what exporters add to a plant, and what they forget.

use super::*;
use crate::mesh::{Image, Texture, Wrap};

/// A tree with many leaves, and these triangles of leaf beside them.
fn with_cards(cards: &[foot::Triangle]) -> ClassedMesh {
    let [wood, mut leaves] = tree();
    for ring in 0..20 {
        let (sin, cos) = (libm::sin(0.3 * f64::from(ring)), libm::cos(0.3 * f64::from(ring)));
        leaves.extend((0..10).map(|at| leaf([3.0 * sin, 4.0 + 0.5 * f64::from(at), 3.0 * cos])));
    }
    leaves.extend_from_slice(cards);
    plant(&wood, &leaves, |point| point)
}

/// A card of two triangles, as wide and high as the tree.
fn card() -> [foot::Triangle; 2] {
    let [a, b, c, d] = [[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 10.0, 0.0], [-4.0, 10.0, 0.0]];
    [[a, b, c], [a, c, d]]
}

fn names(plant: &ClassedMesh) -> Vec<&'static str> {
    all_found(plant, Up::Y).iter().map(Doubt::name).collect()
}

#[test]
fn a_card_of_the_whole_plant_among_its_leaves_is_a_doubt() {
    assert_eq!(names(&with_cards(&[])), [""; 0]);
    let found = all_found(&with_cards(&card()), Up::Y);
    let [doubt @ Doubt::Card { triangles: 2, share, .. }] = &found[..] else { panic!("{found:?}") };
    assert!(*share > 0.9, "{share}");
    let text = doubt.to_string();
    assert!(text.contains("2 triangles as large as the plant are 9"), "{text}");
    // Ground of grass under it.
    let [a, b, c, d] = [[-5.0, 0.0, -5.0], [5.0, 0.0, -5.0], [5.0, 0.0, 5.0], [-5.0, 0.0, 5.0]];
    assert_eq!(names(&with_cards(&[[a, b, c], [a, c, d]])), ["card"]);
    // A tree of whole-tree cards alone; tufts of crossed cards have no other leaves.
    let [wood, _] = tree();
    assert!(names(&plant(&wood, &card(), |point| point)).contains(&"card"));
    assert!(!names(&plant(&wood, &card(), |point| point.map(|c| 0.05 * c))).contains(&"card"));
}

/// A grid of `cells` by `cells` over u and v from 0 to 1, two triangles a cell.
fn sheet(cells: u32, point: impl Fn(f64, f64) -> Point) -> Vec<foot::Triangle> {
    let at = |i: u32, j: u32| point(f64::from(i) / f64::from(cells), f64::from(j) / f64::from(cells));
    let cells = (0..cells).flat_map(|j| (0..cells).map(move |i| (i, j)));
    cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

#[test]
fn ground_that_is_finely_cut_and_hulls_that_are_open_below_are_doubts() {
    let ground = sheet(6, |u, v| [10.0 * u - 5.0, 0.02 * libm::sin(9.0 * u).abs(), 10.0 * v - 5.0]);
    assert_eq!(names(&with_cards(&ground)), ["card"]);
    let dome = sheet(8, |u, v| {
        let (turn, rise) = (std::f64::consts::TAU * u, 1.5 * v);
        let (wide, up) = (4.0 * libm::cos(rise), 4.0 * libm::sin(rise));
        [wide * libm::cos(turn), 5.0 + up, wide * libm::sin(turn)]
    });
    let found = all_found(&with_cards(&dome), Up::Y);
    assert!(found.iter().any(|doubt| doubt.name() == "hull"), "{found:?}");
    // A rosette, whose leaves begin in one point.
    let rosette = (0..24).flat_map(|at| {
        let (sin, cos) = (libm::sin(0.27 * f64::from(at)), libm::cos(0.27 * f64::from(at)));
        let out =
            |far: f64, aside: f64, up: f64| [far * cos - aside * sin, 5.0 + up, far * sin + aside * cos];
        let tip = out(4.5, 0.0, 2.0 + f64::from(at % 3));
        [[[0.0, 5.0, 0.0], out(2.0, 0.4, 1.5), tip], [[0.0, 5.0, 0.0], tip, out(2.0, -0.4, 1.5)]]
    });
    let found = names(&with_cards(&rosette.collect::<Vec<_>>()));
    assert!(!found.contains(&"hull"), "{found:?}");
    // One large leaf of a herb, a bowl: not as wide as the plant.
    let bowl = sheet(8, |u, v| [2.0 * u, 6.0 + (u - 0.5) * (u - 0.5) + (v - 0.5) * (v - 0.5), 2.0 * v]);
    assert_eq!(names(&with_cards(&bowl)), [""; 0]);
}

#[test]
fn leaves_that_show_the_flat_border_of_their_image_are_a_doubt() {
    let leaf = 0;
    let found = |background: u8, shown: f32| {
        let mut tree = with_alpha(leaf, AlphaMode::Opaque, shown, |_| 255);
        let image = &mut tree.mesh.images[0];
        image.has_cut = false;
        for at in 0..64 * 64 {
            let (x, y) = (at % 64, at / 64);
            let is_leaf = (8..56).contains(&x) && (8..56).contains(&y);
            let color = if is_leaf { [80, 160, 40] } else { [background; 3] };
            image.rgba[4 * at..4 * at + 3].copy_from_slice(&color);
        }
        names(&tree)
    };
    assert_eq!(found(255, 1.0), ["background"]);
    assert_eq!(found(0, 1.0), ["background"]);
    assert_eq!(found(120, 1.0), [""; 0], "a photograph on grey");
}

#[test]
fn a_trunk_that_wears_the_leaves_material_alone_is_a_doubt() {
    let [wood, leaves] = tree();
    let tree = plant(&wood, &leaves, |point| point);
    let is_leaf = |at: &usize| tree.classes[tree.mesh.triangle_material[*at] as usize] == MaterialClass::Leaf;
    let all: Vec<usize> = (0..tree.mesh.triangles.len()).filter(is_leaf).collect();
    let range = all[0]..all[0] + all.len();
    assert_eq!(all.last(), Some(&(range.end - 1)));
    let called = |name: &str| {
        let mut tree = tree.clone();
        tree.mesh.parts = vec![part(&tree, &[name], range.clone())];
        all_found(&tree, Up::Y).into_iter().find(|doubt| doubt.name() == "names")
    };
    let text = called("Trunk").expect("a doubt").to_string();
    assert!(text.contains("are leaf by material, expected wood by the names of their parts: '"), "{text}");
    assert!(text.contains("@Trunk'"), "{text}");
    for name in ["Leaves", "Branches", "Stem_leaves", "Cube"] {
        assert_eq!(called(name), None, "{name}");
    }
}

#[test]
fn plants_whose_crowns_meet_are_a_doubt_and_stems_of_a_shrub_are_not() {
    let [wood, leaves] = tree();
    let found = |apart_m: f64| {
        let aside = |part: &[foot::Triangle]| -> Vec<foot::Triangle> {
            part.iter().map(|t| t.map(|[x, y, z]| [x + apart_m, y, z])).collect()
        };
        let [more_wood, more_leaves] = [&wood, &leaves].map(|part| aside(part));
        let all: Vec<foot::Triangle> =
            [&wood, &leaves, &more_wood, &more_leaves].into_iter().flatten().copied().collect();
        let mut both = plant(&all, &[], |point| point);
        let one = wood.len() + leaves.len();
        both.mesh.triangle_material = (0..all.len()).map(|at| u32::from(at % one < wood.len())).collect();
        let whole = |name: &str, first: usize| part(&both, &[name], first..first + one);
        both.mesh.parts = vec![whole("Tree_01", 0), whole("Tree_02", one)];
        all_found(&both, Up::Y)
    };
    // The crowns are 8.2 m wide.
    let doubts = found(6.0);
    let [Doubt::Apart { stands }] = &doubts[..] else { panic!("{doubts:?}") };
    assert_eq!(stands, &["Tree_01", "Tree_02"]);
    assert!(!found(2.0).iter().any(|doubt| doubt.name() == "apart"));
    // Stems that begin at one foot and lean far apart.
    let stems = trees(&[("stem.1", 1.0, [0.5, 0.0, 0.0]), ("stem.2", 1.0, [-0.5, 0.0, 0.0])]);
    let mut whole = stems.clone();
    whole.mesh.parts = [0, 2]
        .map(|first| {
            let [wood, leaves] = [first, first + 1].map(|at| stems.mesh.parts[at].clone());
            Part { uses: [wood.uses, leaves.uses].concat(), ..wood }
        })
        .to_vec();
    assert!(!names(&whole).contains(&"apart"), "{:?}", names(&whole));
}

/// Trees on one spot: a node each, with a mesh of wood and one of leaves below it.
fn trees(all: &[(&str, f64, Point)]) -> ClassedMesh {
    let [wood, leaves] = tree();
    let turned = |(_, scale, lean): &(&str, f64, Point), part: &[foot::Triangle]| -> Vec<foot::Triangle> {
        let corner =
            |corner: Point| std::array::from_fn(|axis| scale * (corner[axis] + lean[axis] * corner[1]));
        part.iter().map(|triangle| triangle.map(corner)).collect()
    };
    let woods = all.iter().flat_map(|tree| turned(tree, &wood)).collect::<Vec<_>>();
    let crowns = all.iter().flat_map(|tree| turned(tree, &leaves)).collect::<Vec<_>>();
    let mut found = plant(&woods, &crowns, |point| point);
    let parts = all.iter().enumerate().flat_map(|(at, (name, ..))| {
        let [of_wood, of_leaves] = [(wood.len(), 0), (leaves.len(), woods.len())]
            .map(|(count, first)| first + at * count..first + (at + 1) * count);
        [part(&found, &["wood", name, "scene"], of_wood), part(&found, &["leaves", name, "scene"], of_leaves)]
    });
    found.mesh.parts = parts.collect();
    found
}

#[test]
fn plants_on_one_spot_are_a_doubt_and_stems_that_lean_apart_are_not() {
    let spots = |all: &[(&str, f64, Point)]| {
        let found = all_found(&trees(all), Up::Y);
        found.into_iter().filter(|doubt| ["one-spot", "levels"].contains(&doubt.name())).collect::<Vec<_>>()
    };
    let [upright, lean] = [[0.0; 3], [0.0, 0.0, 0.03]];
    assert_eq!(spots(&[("Oak_A", 1.0, upright)]), []);
    // Variants of one size, a young one in an old one, three.
    let found = spots(&[("Oak_A", 1.0, upright), ("Oak_B", 1.0, lean)]);
    let [doubt @ Doubt::OneSpot { names }] = &found[..] else { panic!("{found:?}") };
    assert_eq!(names, &["Oak_A", "Oak_B"]);
    let text = Mend::Flags.said(doubt);
    let expected =
        "2 plants with a trunk each stand on one spot: 'Oak_A', 'Oak_B'; expected one plant; --node";
    assert!(text.starts_with(expected), "{text}");
    let young = spots(&[("young", 0.6, lean), ("old", 1.0, upright)]);
    assert!(matches!(&young[..], [Doubt::OneSpot { names }] if names == &["young", "old"]), "{young:?}");
    let three = spots(&[("a", 0.9, lean), ("b", 1.0, upright), ("c", 0.8, [0.05, 0.0, 0.0])]);
    assert!(matches!(&three[..], [Doubt::OneSpot { names }] if names.len() == 3), "{three:?}");
    // A mesh that two nodes have, turned.
    let mut turned = trees(&[("Oak", 1.0, upright), ("Oak.001", 1.0, lean)]);
    turned.mesh.parts = [("Oak", 0), ("Oak.001", 2)]
        .map(|(name, first)| {
            let [wood, leaves] = [first, first + 1].map(|at| turned.mesh.parts[at].clone());
            let names = [name, "Oak"].map(str::to_owned).to_vec();
            Part { names, node: None, uses: [wood.uses, leaves.uses].concat() }
        })
        .to_vec();
    let found = all_found(&turned, Up::Y);
    let is_told = |doubt: &Doubt| matches!(doubt, Doubt::OneSpot { names } if names == &["Oak", "Oak.001"]);
    assert!(found.iter().any(is_told), "{found:?}");
    // Stems of one stool, each to its side.
    assert_eq!(spots(&[("stem.1", 1.0, [0.4, 0.0, 0.0]), ("stem.2", 0.9, [-0.3, 0.0, 0.3])]), []);
}

#[test]
fn the_finest_level_is_named_though_its_name_has_none() {
    let [wood, leaves] = tree();
    let mut all = plant(&wood, &leaves, |point| point);
    let triangles = 0..all.mesh.triangles.len();
    all.mesh.parts = ["Oak", "Oak_LOD1"].map(|name| part(&all, &[name], triangles.clone())).to_vec();
    let found = all_found(&all, Up::Y);
    let [Doubt::Levels { names }] = &found[..] else { panic!("{found:?}") };
    assert_eq!(names, &["Oak", "Oak_LOD1"]);
}

/// The colour of each vertex.
type Paint<'p> = &'p dyn Fn(usize) -> [f32; 3];

/// The tree with an image whose alpha is that of each column of 64; leaves and wood show the first `shown` of them.
fn with_alpha(material: usize, mode: AlphaMode, shown: f32, alpha: impl Fn(usize) -> u8) -> ClassedMesh {
    let [wood, leaves] = tree();
    let mut tree = plant(&wood, &leaves, |point| point);
    let rgba = (0..64 * 64).flat_map(|at| [80, 160, 40, alpha(at % 64)]).collect();
    tree.mesh.images = vec![Image { name: "a.png".to_owned(), width: 64, height: 64, rgba, has_cut: true }];
    let (wrap, transform) = ([Wrap::Repeat; 2], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    tree.mesh.materials[material].color_texture =
        Some(Texture { image: 0, wrap, transform, filter: crate::mesh::Filter::Linear });
    tree.mesh.materials[material].alpha_mode = mode;
    tree.mesh.uvs = vec![[0.0; 2]; tree.mesh.positions.len()];
    let corners = [[0.0, 0.1], [shown, 0.1], [0.0, 0.9]];
    for triangle in tree.mesh.triangles.clone() {
        (0..3).for_each(|corner| tree.mesh.uvs[triangle[corner] as usize] = corners[corner]);
    }
    tree
}

#[test]
fn colours_of_vertices_over_a_texture_are_doubted_where_they_look_like_data() {
    let painted = |of: Paint<'_>| {
        let mut tree = with_alpha(0, AlphaMode::Opaque, 1.0, |_| 255);
        tree.mesh.colors = (0..tree.mesh.positions.len()).map(of).collect();
        all_found(&tree, Up::Y)
    };
    let random =
        |vertex: usize, band: u32| (crate::sampling::hash(3 * vertex as u32 + band) % 256) as f32 / 255.0;
    let looks: [(Paint<'_>, Option<Painted>); 12] = [
        (&|_| [0.0; 3], Some(Painted::Black)),
        (&|vertex| [0.0, 0.0, random(vertex, 0)], Some(Painted::OneChannel)),
        (&|vertex| [0, 1, 2].map(|band| random(vertex, band)), Some(Painted::AllHues)),
        (&|vertex| [random(vertex, 0), 0.0, random(vertex, 1)], Some(Painted::TwoChannels)),
        (&|vertex| [random(vertex, 0), random(vertex, 1), 0.0], Some(Painted::TwoChannels)),
        (&|vertex| [0.1 * random(vertex, 0), 0.0, 0.0], Some(Painted::OneChannel)),
        // Shade, and an autumn from green to red.
        (&|vertex| [0.2 + 0.8 * random(vertex, 0); 3], None),
        (&|vertex| [random(vertex, 0), 1.0 - random(vertex, 0), 0.1], None),
        (&|_| [1.0, 0.3, 0.1], None),
        // A ginkgo, and a red maple.
        (&|vertex| [1.0, 0.7 + 0.2 * random(vertex, 0), 0.0], None),
        (&|vertex| [0.7 + 0.2 * random(vertex, 0), 0.02, 0.0], None),
        (&|_| [1.0; 3], None),
    ];
    for (of, expected) in looks {
        match (&painted(of)[..], expected) {
            ([], None) => {}
            ([doubt @ Doubt::VertexColors { material, look }], Some(expected)) => {
                assert_eq!(*look, expected);
                assert!(doubt.to_string().contains(material), "{doubt}");
            }
            found => panic!("{found:?}"),
        }
    }
    // Without a texture they are the colour itself.
    let [wood, leaves] = tree();
    let mut plain = plant(&wood, &leaves, |point| point);
    plain.mesh.colors =
        (0..plain.mesh.positions.len()).map(|vertex| [0, 1, 2].map(|band| random(vertex, band))).collect();
    assert!(all_found(&plain, Up::Y).is_empty());
    // Over a colour they are data, too, or that colour once more.
    let own = [0.3, 0.2, 0.1];
    for material in &mut plain.mesh.materials {
        material.base_color = [own[0], own[1], own[2], 1.0];
    }
    assert!(matches!(all_found(&plain, Up::Y)[0], Doubt::VertexColors { look: Painted::AllHues, .. }));
    plain.mesh.colors.fill(own);
    assert!(matches!(all_found(&plain, Up::Y)[0], Doubt::VertexColors { look: Painted::Same, .. }));
    plain.mesh.colors.fill([0.9, 0.95, 0.8]);
    assert!(all_found(&plain, Up::Y).is_empty());
}

#[test]
fn wood_that_a_map_of_gloss_cuts_is_a_doubt_and_outlines_are_none() {
    let cut = AlphaMode::Cut { cutoff: 0.5 };
    let gloss = |column: usize| 30 + 3 * column as u8;
    let outline = |column: usize| if column < 32 { 255 } else { 0 };
    assert_eq!(names(&with_alpha(1, cut, 1.0, gloss)), ["wood-cut"]);
    assert_eq!(names(&with_alpha(1, AlphaMode::Blend, 1.0, gloss)), ["wood-cut"]);
    assert_eq!(names(&with_alpha(1, cut, 1.0, outline)), [""; 0]);
    assert_eq!(names(&with_alpha(1, AlphaMode::Opaque, 1.0, gloss)), [""; 0]);
    let text = all_found(&with_alpha(1, cut, 1.0, gloss), Up::Y)[0].to_string();
    assert!(text.contains("the alpha of 'a.png' cuts") && text.contains("map of gloss"), "{text}");
}

#[test]
fn leaves_that_are_opaque_beyond_their_outline_are_a_doubt() {
    let outline = |column: usize| if column < 32 { 255 } else { 0 };
    let found = all_found(&with_alpha(0, AlphaMode::Opaque, 1.0, outline), Up::Y);
    let [doubt @ Doubt::Uncut { outside, .. }] = &found[..] else { panic!("{found:?}") };
    assert!((0.15..0.4).contains(outside), "{outside}");
    assert!(doubt.to_string().contains("expected MASK"), "{doubt}");
    // What no triangle shows is padding; a map of anything else is no outline.
    assert_eq!(names(&with_alpha(0, AlphaMode::Opaque, 0.5, outline)), [""; 0]);
    assert_eq!(names(&with_alpha(0, AlphaMode::Opaque, 1.0, |column| 30 + 3 * column as u8)), [""; 0]);
    assert_eq!(names(&with_alpha(0, AlphaMode::Cut { cutoff: 0.5 }, 1.0, outline)), [""; 0]);
}
