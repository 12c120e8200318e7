//! Golden snapshots of every stage on the built-in plants. A snapshot that changes is a change of the
//! product: look at it, and say in the commit why it is right. `INSTA_UPDATE=always` writes them anew.

use flb_baker::bake::{BakeSettings, ModelSettings, NoStore, PaperSettings};
use flb_fixtures::PlantKind;
use flb_scene::Unobserved;
use flb_tests::default_bake::grown;
use flb_tests::describe;
use flb_tests::pipeline::{Baked, Recipe};

use crate::plants::baked;

/// What a stage made of every plant.
fn of_all(describe: impl Fn(&Baked) -> String) -> String {
    PlantKind::ALL.map(|kind| format!("{}: {}", kind.name(), describe(baked(kind)))).concat()
}

#[test]
fn plants_are_golden() {
    insta::assert_snapshot!("plants", of_all(|b| describe::plant(&b.plant, &b.glb)));
}

#[test]
fn imported_meshes_are_golden() {
    insta::assert_snapshot!("meshes", of_all(|b| describe::mesh(&b.mesh)));
}

#[test]
fn classes_are_golden() {
    insta::assert_snapshot!(
        "classes",
        of_all(|b| "\n".to_owned() + &describe::classes(&b.mesh, &b.classified))
    );
}

#[test]
fn occupancies_are_golden() {
    insta::assert_snapshot!("occupancies", of_all(|b| describe::occupancy(&b.occupancy)));
}

#[test]
fn media_are_golden() {
    insta::assert_snapshot!("media", of_all(|b| describe::medium(&b.medium)));
}

#[test]
fn fields_are_golden() {
    insta::assert_snapshot!("fields", of_all(|b| describe::fields(&b.solution)));
}

#[test]
fn blocks_are_golden() {
    let report = |b: &Baked| b.encoded.report.clone().expect("was just coded");
    insta::assert_snapshot!("blocks", of_all(|b| describe::blocks(&b.file, &report(b))));
}

#[test]
fn container_maps_are_golden() {
    insta::assert_snapshot!("containers", of_all(|b| describe::container(&b.file)));
}

#[test]
fn stages_one_by_one_make_what_a_bake_makes() {
    let recipe = Recipe::small(PlantKind::LeafCard);
    let staged = baked(recipe.kind);
    let model = ModelSettings::Paper(PaperSettings::default());
    let (lattice, voxels) = (recipe.lattice, recipe.voxels);
    let settings = BakeSettings { lattice, voxels, model, ..BakeSettings::default() };
    let plant = grown(recipe.kind, recipe.triangles);
    let whole = flb_baker::bake::bake(plant, &settings, &NoStore, &Unobserved).expect("a good plant").fields;
    assert!(whole.medium == staged.medium);
    assert!(whole.bases == staged.solution.bases);
    assert_eq!(whole.meta.grid, staged.encoded.meta.grid);
}

/// The next float: the smallest change that there is.
fn nudge(value: &mut f32) {
    *value = f32::from_bits(value.to_bits() + 1);
}

mod planted {
    //! Every description must show the smallest change of what it describes.

    use super::*;
    use flb_baker::{Occupancy, voxelise::Cluster};

    fn shrub() -> &'static Baked {
        baked(PlantKind::Shrub)
    }

    #[test]
    fn one_bit_of_a_glb_shows() {
        let (baked, mut glb) = (shrub(), shrub().glb.clone());
        *glb.last_mut().expect("a GLB has bytes") ^= 1;
        assert_ne!(describe::plant(&baked.plant, &glb), describe::plant(&baked.plant, &baked.glb));
    }

    #[test]
    fn one_bit_of_a_mesh_shows() {
        let mesh = &shrub().mesh;
        let mut other = mesh.clone();
        nudge(&mut other.positions[7][1]);
        assert_ne!(describe::mesh(&other), describe::mesh(mesh));
        let mut other = mesh.clone();
        other.images[0].rgba[3] ^= 1;
        assert_ne!(describe::mesh(&other), describe::mesh(mesh));
        let mut other = mesh.clone();
        other.triangles[0].swap(1, 2);
        assert_ne!(describe::mesh(&other), describe::mesh(mesh));
    }

    #[test]
    fn another_rule_of_a_class_shows() {
        let baked = shrub();
        let mut other = baked.classified.clone();
        other[0].rule.push('!');
        assert_ne!(describe::classes(&baked.mesh, &other), describe::classes(&baked.mesh, &baked.classified));
    }

    #[test]
    fn one_voxel_of_an_occupancy_shows() {
        let occupancy = &shrub().occupancy;
        let rebuilt = |clusters: Vec<Cluster>| {
            let areas = occupancy.areas().to_vec();
            Occupancy::from_parts(*occupancy.grid(), occupancy.voxels(), clusters, areas)
                .expect("the parts keep the invariants")
        };
        let mut clusters = occupancy.clusters().to_vec();
        let same = rebuilt(clusters.clone());
        assert_eq!(describe::occupancy(&same), describe::occupancy(occupancy));
        // A leaf voxel becomes wood as well: the same voxels are occupied as before.
        let word =
            clusters.iter_mut().flat_map(|c| c.leaf.iter().zip(&mut c.wood)).find(|(l, w)| **l & !**w != 0);
        let (leaf, wood) = word.expect("a shrub has leaves");
        *wood |= 1 << (*leaf & !*wood).trailing_zeros();
        assert_ne!(describe::occupancy(&rebuilt(clusters)), describe::occupancy(occupancy));
    }

    #[test]
    fn one_bit_of_a_medium_shows() {
        let medium = &shrub().medium;
        let site = medium.density.iter().position(|d| *d > 0.0 && *d < 1.0).expect("a shrub has matter");
        let mut other = medium.clone();
        nudge(&mut other.density[site]);
        assert_ne!(describe::medium(&other), describe::medium(medium));
        let mut other = medium.clone();
        nudge(&mut other.leaf_area_density[site]);
        assert_ne!(describe::medium(&other), describe::medium(medium));
    }

    #[test]
    fn one_bit_of_a_field_shows() {
        let solution = &shrub().solution;
        let mut other = solution.clone();
        nudge(&mut other.bases[18].1.values_mut()[40_000]);
        assert_ne!(describe::fields(&other), describe::fields(solution));
        let mut other = solution.clone();
        other.reports[5].sweeps += 100;
        assert_ne!(describe::fields(&other), describe::fields(solution));
        let mut other = solution.clone();
        other.reports[5].converged = false;
        assert_ne!(describe::fields(&other), describe::fields(solution));
    }

    #[test]
    fn another_threshold_shows_in_blocks_and_map() {
        let baked = shrub();
        let recipe = Recipe { threshold: 0.005_01, ..Recipe::small(PlantKind::Shrub) };
        let encoded = flb_tests::pipeline::encode(
            &recipe,
            &baked.mesh,
            &baked.classes(),
            &baked.medium,
            &baked.solution,
        );
        let file = flb_tests::pipeline::write(&encoded);
        let [a, b] = [&baked.encoded, &encoded].map(|e| e.report.clone().expect("was just coded"));
        assert_ne!(describe::blocks(&file, &b), describe::blocks(&baked.file, &a));
        assert_ne!(describe::container(&file), describe::container(&baked.file));
    }
}
