use proptest::prelude::*;

use super::*;
use crate::mesh::testing::{card, identity, image};

fn wrap() -> impl Strategy<Value = Wrap> {
    prop_oneof![Just(Wrap::Repeat), Just(Wrap::Mirror), Just(Wrap::Clamp)]
}

fn cut_of(mesh: &Mesh) -> Cut {
    match Coverage::of(mesh, 0).expect("a good mesh") {
        Coverage::Cut(cut) => cut,
        other => panic!("expected a cut, found {other:?}"),
    }
}

/// The texel that a wrap mode means, one turn at a time.
fn wrapped_slowly(mut at: i64, size: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Clamp => at.max(0).min(size - 1),
        Wrap::Repeat => {
            while at < 0 {
                at += size;
            }
            at % size
        }
        Wrap::Mirror => {
            let mirrored = at < 0;
            let turns = if mirrored { -1 - at } else { at };
            let (turn, inside) = (turns / size, turns % size);
            // The first copy to the left is mirrored: reflect, then count turns as on the right.
            if turn % 2 == 0 { inside } else { size - 1 - inside }
        }
    }
}

proptest! {
    #[test]
    fn wrap_modes_mean_the_same_texel_as_stepping_does(at in -300i64..300, size in 1u32..40, wrap in wrap()) {
        let cut = Cut::from_fn(size, 1, [wrap; 2], identity(0, wrap).transform, |x, _| x == 0);
        prop_assert_eq!(cut.wrapped(0, at) as i64, wrapped_slowly(at, i64::from(size), wrap));
    }

    #[test]
    fn verdicts_and_rows_agree_with_every_texel(
        size in (1u32..80, 1u32..30), seed: u64, blob in 1u64..30,
        from in (-90i64..90, -90i64..90), span in (0i64..100, 0i64..40), wrap in [wrap(), wrap()],
    ) {
        let bit = |x: u32, y: u32| {
            (u64::from(x) / blob * 7 + u64::from(y) / blob).wrapping_add(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 63 == 0
        };
        let cut = Cut::from_fn(size.0, size.1, wrap, identity(0, Wrap::Repeat).transform, bit);
        let texels = TexelBox { min: [from.0, from.1], max: [from.0 + span.0, from.1 + span.1] };
        let row = |y: i64| (texels.min[0]..=texels.max[0]).map(move |x| [x, y]);
        let mut all = (texels.min[1]..=texels.max[1]).flat_map(row).map(|texel| cut.present(texel));
        match cut.verdict(&texels) {
            Verdict::Absent => prop_assert!(!all.any(|there| there)),
            Verdict::Present => prop_assert!(all.all(|there| there)),
            Verdict::Mixed => {}
        }
        let image_row = cut.wrapped(1, from.1);
        let any = row(from.1).any(|texel| cut.present(texel));
        prop_assert_eq!(cut.any_in_row(image_row, texels.min[0], texels.max[0]), any);
        let length = cut.present_before(image_row, (texels.max[0] + 1) as f64) - cut.present_before(image_row, texels.min[0] as f64);
        let count = row(from.1).filter(|&texel| cut.present(texel)).count();
        prop_assert!((length - count as f64).abs() < 1e-9, "{} against {}", length, count);
    }

    #[test]
    fn texels_clear_around_a_texel_are_absent(
        size in (1u32..1400, 1u32..30), turn: bool, seed: u64, share in 0u64..40,
        at in prop::array::uniform2(-2000i64..2000), wrap in [wrap(), wrap()],
    ) {
        // Images over 512 texels wide count groups of 2 or 4, and the last group may be cut short.
        let size = if turn { (size.1, size.0) } else { size };
        let bit = |x: u32, y: u32| {
            (u64::from(x) * 2000 + u64::from(y)).wrapping_add(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 50 < share
        };
        let cut = Cut::from_fn(size.0, size.1, wrap, identity(0, Wrap::Repeat).transform, bit);
        let clear = cut.clear_around(at);
        let reach = clear.min(40);
        let mut around = (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| [at[0] + dx, at[1] + dy]));
        prop_assert!(!around.any(|texel| cut.present(texel)), "{clear}");
        // And it is not much too small inside the image: groups of up to 4 texels, and one group at a seam.
        let reach = (clear + 13).min(60);
        let mut around = (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| [at[0] + dx, at[1] + dy]));
        let inside = cut.wrapped(0, at[0]) as i64 == at[0] && cut.wrapped(1, at[1]) as i64 == at[1];
        prop_assert!(!inside || reach == 60 || around.any(|texel| cut.present(texel)), "{clear}");
    }

    #[test]
    fn the_share_of_a_box_is_that_of_its_texels(seed: u64, x in 0u32..20, y in 0u32..20, w in 1u32..20, h in 1u32..20) {
        let bit = |x: u32, y: u32| u64::from(x * 64 + y).wrapping_add(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 62 != 0;
        let cut = Cut::from_fn(40, 40, [Wrap::Repeat; 2], identity(0, Wrap::Repeat).transform, bit);
        let [x0, y0, x1, y1] = [x, y, x + w, y + h].map(f64::from);
        let piece = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        let texels = (x..x + w).flat_map(|x| (y..y + h).map(move |y| (x, y)));
        let expected = texels.filter(|&(x, y)| bit(x, y)).count() as f64 / f64::from(w * h);
        let found = cut.share(&piece, &TexelBox::of([x0, y0], [x1, y1]));
        prop_assert!((found - expected).abs() < 1e-9, "{} against {}", found, expected);
    }
}

#[test]
fn a_texel_at_the_cutoff_is_present() {
    let mut mesh = card(image(4, 1, |_, _| true), Wrap::Repeat);
    for (texel, alpha) in [127u8, 128, 51, 255].into_iter().enumerate() {
        mesh.images[0].rgba[texel * 4 + 3] = alpha;
    }
    let present =
        |mesh: &Mesh| [0.1, 0.3, 0.6, 0.9].map(|u| Coverage::of(mesh, 0).expect("good").present_at([u, 0.5]));
    assert_eq!(present(&mesh), [false, true, false, true]);
    mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 128.0 / 255.0 };
    assert!(present(&mesh)[3]);
    mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.2 };
    mesh.materials[0].base_color[3] = 0.5;
    assert_eq!(present(&mesh), [true, true, false, true]);
}

#[test]
fn a_texture_transform_moves_the_cut() {
    let mut mesh = card(image(2, 2, |x, y| x == 1 && y == 0), Wrap::Repeat);
    let before = Coverage::of(&mesh, 0).expect("good");
    assert!(before.present_at([0.75, 0.25]) && !before.present_at([0.25, 0.25]));
    let texture = mesh.materials[0].color_texture.as_mut().expect("a card has one");
    texture.transform = [[2.0, 0.0, 0.5], [0.0, 1.0, 0.0]];
    let after = Coverage::of(&mesh, 0).expect("good");
    assert!(after.present_at([0.1, 0.25]) && !after.present_at([0.3, 0.25]) && after.present_at([0.6, 0.25]));
}

#[test]
fn coordinates_far_outside_the_image_wrap() {
    let cut = cut_of(&card(image(2, 1, |x, _| x == 0), Wrap::Repeat));
    assert!(cut.present_at([-37.0, 40.5]) && !cut.present_at([-36.5, 0.0]));
    assert!(cut.present_at([f32::MAX, f32::MIN]) || !cut.present_at([f32::MAX, f32::MIN]), "no panic");
    let mut texels = [[f32::MAX, 0.0], [f32::MIN, 1.0], [0.0, f32::MAX]].map(|uv| cut.texel_from_uv(uv));
    cut.near_origin(&mut texels);
    let within = TexelBox::of([-1e300, -1e300], [1e300, 1e300]);
    assert!(cut.touches(&texels, &within), "judged by its box");
    assert!((0.0..=1.0).contains(&cut.share(&texels, &within)));
}

#[test]
fn colour_and_alpha_images_multiply() {
    let mut mesh = card(image(2, 2, |x, _| x == 0), Wrap::Repeat);
    mesh.images.push(image(8, 8, |_, y| y < 4));
    mesh.materials[0].alpha_texture = Some(identity(1, Wrap::Repeat));
    let both = Coverage::of(&mesh, 0).expect("good");
    let at = [[0.2, 0.2], [0.2, 0.8], [0.8, 0.2], [0.8, 0.8]].map(|uv| both.present_at(uv));
    assert_eq!(at, [true, false, false, false]);
    mesh.images[0].has_cut = false;
    let alpha_only = Coverage::of(&mesh, 0).expect("good");
    assert!(alpha_only.present_at([0.8, 0.2]) && !alpha_only.present_at([0.2, 0.8]));
}

#[test]
fn uniform_images_are_full_or_nothing() {
    let full = card(image(3, 3, |_, _| true), Wrap::Repeat);
    assert_eq!(Coverage::of(&full, 0), Ok(Coverage::Full));
    let nothing = card(image(3, 3, |_, _| false), Wrap::Repeat);
    assert_eq!(Coverage::of(&nothing, 0), Ok(Coverage::Nothing));
    let mut opaque = nothing.clone();
    opaque.materials[0].alpha_mode = AlphaMode::Opaque;
    assert_eq!(Coverage::of(&opaque, 0), Ok(Coverage::Full));
}
