use super::*;
use crate::mesh::{Filter, Image, Texture, Wrap};
use crate::mesh::{Foot, Material, PartUse};
use MaterialClass::{Leaf, Neither, Wood};
use flb_format::meta::Bounds;

/// One triangle per material.
fn mesh(names: &[&str]) -> Mesh {
    let material = |name: &&str| Material::opaque(*name);
    Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        uvs: vec![[0.0; 2]; 3],
        triangles: vec![[0, 1, 2]; names.len()],
        triangle_material: (0..names.len() as u32).collect(),
        materials: names.iter().map(material).collect(),
        ..Mesh::default()
    }
}

/// Gives material `index` a texture of ten texels, `cut` of which have alpha 0.
fn with_texture(mut mesh: Mesh, index: usize, name: &str, cut: usize, alpha_mode: AlphaMode) -> Mesh {
    let rgba = (0..10).flat_map(|i| [9, 9, 9, if i < cut { 0 } else { 255 }]).collect();
    let image = mesh.images.len() as u32;
    mesh.images.push(Image { name: name.to_owned(), width: 10, height: 1, rgba, has_cut: cut > 0 });
    let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    mesh.materials[index].color_texture =
        Some(Texture { image, wrap: [Wrap::Repeat; 2], transform, filter: Filter::Linear });
    mesh.materials[index].alpha_mode = alpha_mode;
    mesh
}

fn rules(leaf: &[&str], wood: &[&str], ignore: &[&str]) -> ClassRules {
    let list = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
    ClassRules { leaf: list(leaf), wood: list(wood), ignore: list(ignore), ..ClassRules::default() }
}

fn classes(mesh: &Mesh, rules: &ClassRules) -> Vec<MaterialClass> {
    classify(mesh, rules).unwrap().into_iter().map(|classified| classified.class).collect()
}

fn part(names: &[&str], material: u32) -> Part {
    let bounds_m = Bounds { min: [0.0; 3], max: [1.0; 3] };
    let uses = vec![PartUse { material, triangles: 1, area_m2: 0.5, bounds_m, foot: Foot::default() }];
    Part { names: names.iter().map(|&name| name.to_owned()).collect(), node: None, uses }
}

const CUT: AlphaMode = AlphaMode::Cut { cutoff: 0.5 };

#[test]
fn rules_are_asked_in_their_order() {
    let mut mesh = with_texture(mesh(&["b"]), 0, "a.png", 5, CUT);
    let rule = |mesh: &Mesh| classify(mesh, &ClassRules::default()).unwrap().remove(0);
    assert_eq!(rule(&mesh).rule, "the alpha of 'a.png' cuts 50 % away");
    mesh.materials[0].diffuse_transmission = Some(0.0);
    assert_eq!(rule(&mesh).class, Leaf, "a factor of 0 is an opaque leaf");
    mesh.materials[0].passes_by_texture = true;
    assert_eq!(rule(&mesh).class, Wood, "a texture of what passes that is black says opaque");
    mesh.materials[0].diffuse_transmission = Some(0.5);
    assert_eq!(rule(&mesh).rule, "diffuse transmission 0.5");
    mesh.parts = vec![part(&["Trunk", "Oak"], 0)];
    assert_eq!(rule(&mesh).rule, "'trunk' in the name of its part 'Trunk'");
    mesh.images[0].name = "leaf.png".to_owned();
    assert_eq!(rule(&mesh).rule, "'leaf' in the name of its texture 'leaf.png'");
    mesh.materials[0].name = "bark".to_owned();
    assert_eq!(rule(&mesh).rule, "'bark' in its name");
    let species =
        SpeciesRules { file: "oak.toml".to_owned(), wood: vec!["b*".to_owned()], ..SpeciesRules::default() };
    let file = ClassRules { species: Some(species), ..ClassRules::default() };
    let decided = classify(&mesh, &file).unwrap();
    assert_eq!((decided[0].class, decided[0].rule.as_str()), (Wood, "oak.toml: wood 'b*'"));
    let both = ClassRules { species: file.species, ..rules(&["BARK"], &[], &[]) };
    let decided = classify(&mesh, &both).unwrap();
    assert_eq!((decided[0].class, decided[0].rule.as_str()), (Leaf, "--leaf 'BARK'"));
}

#[test]
fn alpha_that_cuts_hardly_anything_is_no_evidence() {
    let solid = with_texture(mesh(&["m"]), 0, "x.png", 0, CUT);
    assert!(classify(&solid, &ClassRules::default()).is_err());
    let unused = with_texture(mesh(&["m"]), 0, "x.png", 5, AlphaMode::Opaque);
    assert!(classify(&unused, &ClassRules::default()).is_err());
}

#[test]
fn a_texture_s_name_speaks_where_the_material_s_does_not() {
    let mesh = with_texture(mesh(&["material0", "Trunk"]), 0, "oak_leaf.jpg", 0, AlphaMode::Opaque);
    assert_eq!(classes(&mesh, &ClassRules::default()), [Leaf, Wood]);
}

#[test]
fn an_opaque_rest_of_leaf_is_wood_and_says_so() {
    let rest = mesh(&["plant_leaves", "thing"]);
    let decided = classify(&rest, &ClassRules::default()).unwrap();
    assert_eq!(decided[1].class, Wood);
    assert!(decided[1].rule.contains("taken as wood"), "{}", decided[1].rule);
    assert_eq!(classes(&rest, &rules(&[], &[], &["th*"])), [Leaf, Neither]);
}

#[test]
fn what_is_no_plant_by_its_name_is_open_whatever_else_speaks() {
    for name in ["plant_pot", "FlowerPot", "grass_ground", "leaf_tray"] {
        let pot = mesh(&["leaves", name]);
        let error = classify(&pot, &ClassRules::default()).unwrap_err().to_string();
        assert!(
            error.contains(&format!("--ignore '{name}'")) && error.contains("is no word of a plant"),
            "{error}"
        );
        assert_eq!(classes(&pot, &rules(&[], &[name], &[])), [Leaf, Wood]);
    }
    let cut = with_texture(mesh(&["grass_ground"]), 0, "a.png", 5, CUT);
    assert!(classify(&cut, &ClassRules::default()).is_err(), "alpha does not make a leaf of the ground");
    let unsure = mesh(&["bark", "leaf_beetle"]);
    let error = classify(&unsure, &ClassRules::default()).unwrap_err().to_string();
    assert!(error.contains("'beetle' in its name is not known"), "{error}");
}

#[test]
fn a_pattern_may_name_a_part() {
    let mut atlas = mesh(&["atlas", "atlas"]);
    atlas.parts = vec![part(&["Mesh_1"], 0), part(&["Mesh_2"], 1)];
    let by_part = rules(&["atlas@mesh_1"], &["*@Mesh_2"], &[]);
    assert_eq!(classes(&atlas, &by_part), [Leaf, Wood]);
    assert_eq!(by_part.split_patterns(), ["atlas@mesh_1", "*@Mesh_2"]);
    let all_but_one = rules(&["atlas"], &["*@Mesh_2"], &[]);
    assert!(all_but_one.split_patterns() == ["*@Mesh_2"]);
    assert_eq!(classes(&atlas, &all_but_one)[0], Leaf);
    let error = classify(&atlas, &rules(&["*@Mesh_3"], &[], &[])).unwrap_err();
    assert!(matches!(error, ImportError::NothingMatched { .. }), "{error}");
}

#[test]
fn what_is_open_is_an_error_with_the_flags() {
    for names in [&["material0", "material1"][..], &["leaves", "bark", "thing"]] {
        let mesh = mesh(names);
        let error = classify(&mesh, &ClassRules::default()).unwrap_err().to_string();
        let open = names.last().unwrap();
        for words in [
            format!("--leaf '{open}'"),
            format!("--wood '{open}'"),
            "undecided".to_owned(),
            names[0].to_owned(),
        ] {
            assert!(error.contains(&words), "{words} in {error}");
        }
    }
}

#[test]
fn a_pattern_that_matches_nothing_is_an_error() {
    for rules in [rules(&["needle*"], &[], &[]), rules(&[], &["needle*"], &[]), rules(&[], &[], &["needle*"])]
    {
        let error = classify(&mesh(&["leaf", "bark"]), &rules).unwrap_err().to_string();
        assert!(
            error.contains("'needle*' matches no material; the materials are: 'leaf', 'bark'"),
            "{error}"
        );
    }
    let error = classify(&mesh(&["leaf"]), &rules(&["a{b"], &[], &[])).unwrap_err();
    assert!(matches!(error, ImportError::BadPattern { .. }), "{error}");
}

#[test]
fn an_exact_name_beats_a_wider_pattern() {
    let mesh = mesh(&["a", "b", "pot[1"]);
    assert_eq!(classes(&mesh, &rules(&["A"], &["*"], &["pot[1"])), [Leaf, Wood, Neither]);
}

#[test]
fn a_dead_tree_is_fine_and_nothing_at_all_is_not() {
    let mesh = mesh(&["x", "y"]);
    assert_eq!(classes(&mesh, &rules(&[], &["*"], &[])), [Wood, Wood]);
    let error = classify(&mesh, &rules(&[], &[], &["*"])).unwrap_err();
    assert!(matches!(error, ImportError::NothingToBake { .. }), "{error}");
}

#[test]
fn a_material_without_triangles_is_not_asked_for() {
    let mut mesh = mesh(&["leaf", "thing"]);
    mesh.triangles.pop();
    mesh.triangle_material.pop();
    assert_eq!(classes(&mesh, &ClassRules::default()), [Leaf, Neither]);
    let rows = table::table(&mesh, &ClassRules::default()).unwrap();
    assert_eq!((rows[0].triangles, rows[0].area_m2, rows[0].class), (1, 0.5, "leaf"));
    assert_eq!((rows[1].triangles, rows[1].class, rows[1].rule.as_str()), (0, "neither", "no triangles"));
}

#[test]
fn a_material_of_both_is_open_unless_its_parts_say_more() {
    let mut atlas = with_texture(mesh(&["leaves", "leaf_bark_atlas"]), 1, "a.png", 5, CUT);
    let error = classify(&atlas, &ClassRules::default()).unwrap_err().to_string();
    assert!(error.contains("its name says both 'leaf' and 'bark'"), "{error}");
    assert!(error.contains("known: 'leaf_bark_atlas'\n"), "{error}");
    atlas.parts = vec![part(&["Trunk"], 1)];
    assert_eq!(classes(&atlas, &ClassRules::default()), [Leaf, Wood]);
}

#[test]
fn an_opaque_rest_is_wood_unless_it_is_green() {
    let of = |color: [f32; 3]| {
        let mut plant = mesh(&["leaf_small", "Monstera"]);
        plant.materials[1].base_color = [color[0], color[1], color[2], 1.0];
        classify(&plant, &ClassRules::default())
    };
    for color in [[0.8; 3], [0.25, 0.15, 0.08], [0.1, 0.11, 0.06]] {
        assert_eq!(of(color).unwrap()[1].class, Wood, "{color:?}");
    }
    let error = of([0.08, 0.3, 0.04]).unwrap_err().to_string();
    assert!(error.contains("opaque as wood is, but green as leaves are"), "{error}");
    // A tulip, a lemon, a hydrangea.
    for color in [[0.6, 0.02, 0.03], [0.8, 0.6, 0.05], [0.15, 0.2, 0.7]] {
        let error = of(color).unwrap_err().to_string();
        assert!(error.contains("opaque as wood is, but neither brown nor grey"), "{color:?}: {error}");
    }
}

#[test]
fn words_of_twigs_and_branches_are_held_against_the_color() {
    let of = |name: &str, color: [f32; 3]| {
        let mut plant = mesh(&["leaves", name]);
        plant.materials[1].base_color = [color[0], color[1], color[2], 1.0];
        classify(&plant, &ClassRules::default())
            .map(|found| found[1].class)
            .map_err(|error| error.to_string())
    };
    let (brown, green) = ([0.25, 0.15, 0.08], [0.08, 0.3, 0.04]);
    assert!(of("twigs", brown).is_err_and(|error| error.contains("but it is opaque, and brown or grey")));
    assert!(of("fir_branch", green).is_err_and(|error| error.contains("but it is green")));
    assert_eq!(of("Zweige", green).ok(), Some(Leaf));
    assert_eq!(of("Twig", [0.18, 0.16, 0.03]).ok(), Some(Leaf), "a yellow maple");
    assert_eq!(of("branches", brown).ok(), Some(Wood));
    assert_eq!(of("branches", [1.0; 3]).ok(), Some(Wood), "white says nothing");
    assert_eq!(of("Stem", green).ok(), Some(Wood), "stems are green");
}

#[test]
fn nodes_above_a_part_have_no_word_against_its_color() {
    let of = |names: &[&str], color: [f32; 3]| {
        let mut plant = mesh(&["leaves", "Material.002"]);
        plant.materials[1].base_color = [color[0], color[1], color[2], 1.0];
        plant.parts = vec![part(&["Leaves"], 0), part(names, 1)];
        classify(&plant, &ClassRules::default())
            .map(|found| found[1].class)
            .map_err(|error| error.to_string())
    };
    let (brown, green, red) = ([0.25, 0.15, 0.08], [0.08, 0.3, 0.04], [0.6, 0.02, 0.03]);
    let below = ["Cube", "Cube.001", "Trunk"];
    assert_eq!(of(&below, brown).ok(), Some(Wood));
    assert!(of(&below, green).is_err_and(|error| error.contains("'Trunk', but it is green")));
    assert!(of(&below, red).is_err_and(|error| error.contains("but it is neither brown nor grey")));
    assert_eq!(of(&["Trunk", "Tree"], green).ok(), Some(Wood), "its own name says enough");
    let flower = ["Cube", "Cube.001", "Flower"];
    assert_eq!(of(&flower, red).ok(), Some(Leaf));
    assert!(of(&flower, brown).is_err_and(|error| error.contains("opaque, and brown or grey")));
    // The first node of a file is no root of a plant.
    for root in ["root", "RootNode", "GLTF_SceneRootNode", "Armature_rootJoint"] {
        let found = of(&["Object_4", root], green);
        assert!(found.is_err_and(|error| error.contains("green as leaves")), "{root}");
    }
    assert_eq!(of(&["roots", "Oak"], brown).ok(), Some(Wood));
}

#[test]
fn cards_of_wood_without_a_color_of_bark_are_open() {
    let of = |cut: usize, color: [u8; 3]| {
        let mut cards = with_texture(mesh(&["leaves", "branches"]), 1, "a.png", cut, CUT);
        cards.uvs = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]];
        cards.images[0]
            .rgba
            .as_chunks_mut::<4>()
            .0
            .iter_mut()
            .for_each(|texel| texel[..3].copy_from_slice(&color));
        classify(&cards, &ClassRules::default())
    };
    // Green, olive, a blue spruce, a white and a pink blossom, orange, red and yellow in autumn, a copper beech.
    let leaves = [
        [89, 149, 63],
        [120, 130, 100],
        [110, 135, 130],
        [240, 238, 230],
        [235, 180, 200],
        [200, 110, 30],
        [170, 40, 30],
        [220, 200, 50],
        [80, 35, 40],
    ];
    for color in leaves {
        let error = of(6, color).unwrap_err().to_string();
        assert!(error.contains("'branches' in its name is of wood, but alpha cuts"), "{color:?}: {error}");
    }
    // Bare twigs: brown, grey, bluish grey, red-brown, black.
    for color in [[89, 70, 63], [150, 145, 140], [130, 132, 135], [120, 60, 40], [0; 3]] {
        assert_eq!(of(6, color).unwrap()[1].class, Wood, "{color:?}");
    }
    let error = of(2, [89, 149, 63]).unwrap_err().to_string();
    assert!(error.contains("'branches' in its name, but it is green"), "{error}");
}
