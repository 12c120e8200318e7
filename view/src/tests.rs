//! Frames without a window, of a picture made by hand. They need an adapter; lavapipe (`scripts/setup test` installs
//! it) will do.

use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use flb_gpu::Gpu;
use flb_render::Picture;
use flb_render::forest::Eye;
use flb_stage::stream::{Painted, Progress};

use crate::screen::Screen;
use crate::{Controls, Shot, Show, ViewError};

const SIZE: [u32; 2] = [400, 200];

fn screen() -> Screen {
    // The message says what to install.
    Screen::offscreen(Gpu::open(Default::default()).unwrap_or_else(|error| panic!("{error}")))
}

fn controls() -> Controls {
    let eye = Eye { position_m: [0.0, 2.0, 10.0], look_at_m: [0.0, 1.0, 0.0], fov_deg: 40.0 };
    Controls::new(Shot { eye, sun_deg: [100.0, 30.0], show: Show::Whole }, 0.0)
}

/// Left half red, right half blue, of light that is brighter the farther up.
fn painted(failures: &[&str]) -> Painted {
    let [width, height] = [40, 20];
    let color = |i: usize| {
        let light = 1.0 - (i / width) as f32 / height as f32;
        if i % width < width / 2 { [light, 0.0, 0.0] } else { [0.0, 0.0, light] }
    };
    let rgb = (0..width * height).flat_map(color).collect();
    let failures = failures.iter().map(|failure| (*failure).to_owned()).collect();
    Painted {
        picture: Picture { width: width as u32, height: height as u32, rgb },
        shot: controls().shot,
        samples: 1,
        progress: Progress {
            quality: 0.5,
            loaded_bytes: 1_000_000,
            budget_bytes: 2_000_000,
            is_final: false,
            failures,
            ..Progress::default()
        },
        seconds: [0.1, 0.2],
    }
}

fn at(rgb: &[u8], x: usize, y: usize) -> [u8; 3] {
    let first = 3 * (y * SIZE[0] as usize + x);
    [rgb[first], rgb[first + 1], rgb[first + 2]]
}

fn key(key: Key) -> Vec<Event> {
    vec![Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE }]
}

fn drag(button: PointerButton, from: [f32; 2], to: [f32; 2]) -> [Vec<Event>; 3] {
    let [from, to] = [from, to].map(|[x, y]| Pos2::new(x, y));
    let press = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE };
    [
        vec![Event::PointerMoved(from), press(from, true)],
        vec![Event::PointerMoved(to)],
        vec![press(to, false)],
    ]
}

#[test]
fn the_picture_fills_what_the_panel_leaves_and_exposure_is_seen_at_once() {
    let (mut screen, mut controls) = (screen(), controls());
    let (empty, drawn) = screen.shot(SIZE, Vec::new(), &mut controls).expect("a frame");
    assert_eq!(at(&empty, 20, 100), [0; 3], "nothing was painted yet");
    assert!(drawn.picture_px[0] < SIZE[0] && drawn.picture_px[1] == SIZE[1], "{:?}", drawn.picture_px);
    screen.set(painted(&[]));
    let (frame, _) = screen.shot(SIZE, Vec::new(), &mut controls).expect("a frame");
    let middle = drawn.picture_px[0] as usize / 2;
    let [left, right] = [at(&frame, middle - 20, 20), at(&frame, middle + 20, 20)];
    assert!(left[0] > 100 && left[2] < 20 && right[2] > 100 && right[0] < 20, "{left:?} {right:?}");
    assert!(at(&frame, middle - 20, 20)[0] > at(&frame, middle - 20, 180)[0], "row 0 is on top");
    // As the picture's own bytes have it.
    let bytes = painted(&[]).picture.tone_mapped(0.0);
    let corner = at(&frame, 1, 1);
    assert!(corner[0].abs_diff(bytes[0]) <= 2, "{corner:?} for {:?}", &bytes[..3]);
    controls.exposure = -3.0;
    let (darker, _) = screen.shot(SIZE, Vec::new(), &mut controls).expect("a frame");
    assert!(at(&darker, middle - 20, 20)[0] < left[0] / 2);
    let (whole, drawn) = screen.shot(SIZE, key(Key::H), &mut controls).expect("a frame");
    assert_eq!(drawn.picture_px, SIZE, "without the panel");
    assert!(at(&whole, 390, 20)[2] > at(&whole, 390, 20)[0], "blue to the very edge");
}

#[test]
fn the_mouse_turns_and_moves_the_camera_but_not_on_the_panel() {
    let start = controls();
    let (mut screen, mut controls) = (screen(), controls());
    screen.set(painted(&[]));
    // What lies under the mouse is known from the frame before.
    screen.shot(SIZE, Vec::new(), &mut controls).expect("a frame");
    let play = |screen: &mut Screen, controls: &mut Controls, events: [Vec<Event>; 3]| {
        for events in events {
            screen.shot(SIZE, events, controls).expect("a frame");
        }
    };
    play(&mut screen, &mut controls, drag(PointerButton::Primary, [60.0, 60.0], [100.0, 60.0]));
    assert_eq!(controls.shot.eye.look_at_m, start.shot.eye.look_at_m);
    assert!(controls.shot.eye.position_m[0] < -0.5, "{:?}", controls.shot.eye);
    controls.reset();
    play(&mut screen, &mut controls, drag(PointerButton::Secondary, [60.0, 60.0], [100.0, 60.0]));
    assert_eq!(controls.shot.eye.position_m, start.shot.eye.position_m);
    assert!(controls.shot.eye.look_at_m[0] > 0.5, "{:?}", controls.shot.eye);
    controls.reset();
    play(&mut screen, &mut controls, drag(PointerButton::Middle, [60.0, 60.0], [60.0, 100.0]));
    assert!(controls.shot.eye.position_m[1] > 2.5 && controls.shot.eye.look_at_m[1] > 1.5);
    controls.reset();
    play(&mut screen, &mut controls, drag(PointerButton::Primary, [330.0, 190.0], [380.0, 195.0]));
    assert_eq!(controls.shot.eye, start.shot.eye, "the panel keeps its events");
}

#[test]
fn keys_choose_what_is_shown_and_move_the_sun() {
    let (mut screen, mut controls) = (screen(), controls());
    screen.set(painted(&[]));
    let shows = [
        (Key::Num2, Show::Indirect),
        (Key::Num3, Show::Direct),
        (Key::Num4, Show::Base(0)),
        (Key::Num5, Show::Level),
        (Key::Num6, Show::Residency),
        (Key::Num7, Show::Error),
        (Key::Num1, Show::Whole),
    ];
    for (number, show) in shows {
        screen.shot(SIZE, key(number), &mut controls).expect("a frame");
        assert_eq!(controls.shot.show, show);
    }
    let before = controls.shot;
    screen.shot(SIZE, key(Key::W), &mut controls).expect("a frame");
    assert!(controls.shot.eye.position_m[2] < before.eye.position_m[2], "W goes forward");
    screen.shot(SIZE, key(Key::ArrowUp), &mut controls).expect("a frame");
    assert!(controls.shot.sun_deg[1] > before.sun_deg[1]);
    screen.shot(SIZE, key(Key::R), &mut controls).expect("a frame");
    screen.shot(SIZE, key(Key::Space), &mut controls).expect("a frame");
    assert!(controls.sun_speed > 0.0);
}

#[test]
fn what_went_wrong_stands_in_the_panel_and_over_the_picture() {
    let (mut screen, mut controls) = (screen(), controls());
    let reddish = |rgb: &[u8]| {
        rgb.as_chunks::<3>()
            .0
            .iter()
            .filter(|p| p[0] > 150 && p[0] > p[1].saturating_add(40) && p[1] > 30)
            .count()
    };
    let tall = [400, 700];
    let mut clean = painted(&[]);
    clean.picture.rgb.fill(0.0);
    screen.set(clean.clone());
    let (frame, _) = screen.shot(tall, Vec::new(), &mut controls).expect("a frame");
    assert_eq!(reddish(&frame), 0);
    clean.progress.failures = vec!["oak.flb: page 7 is damaged".to_owned()];
    screen.set(clean);
    let (frame, _) = screen.shot(tall, Vec::new(), &mut controls).expect("a frame");
    assert!(reddish(&frame) > 50, "{} pixels of it", reddish(&frame));
    screen.set(painted(&[]));
    screen.message = Some("the scene cannot be drawn".to_owned());
    let (frame, _) = screen.shot(tall, Vec::new(), &mut controls).expect("a frame");
    assert!(reddish(&frame) > 50);
}

#[test]
fn a_size_that_no_texture_has_is_refused() {
    let (mut screen, mut controls) = (screen(), controls());
    for size in [[0, 10], [10, 0], [1 << 20, 10]] {
        let error = screen.shot(size, Vec::new(), &mut controls).map(|_| ()).expect_err("no such texture");
        let ViewError::Size { width, height, .. } = error else { panic!("{error}") };
        assert_eq!([width, height], size);
    }
}
