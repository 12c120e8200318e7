//! The reading in parts against the reading as a whole, which toml does by itself.

use proptest::prelude::*;

use super::*;

/// Pieces of scenes, sound and unsound, each of whole lines.
const PIECES: &[&str] = &[
    "[[species]]\nname = \"oak\"\nupright = true",
    "[[species]]\nname = \"fir\"\nfile = '''\n[[instance]]\nfir.glb'''",
    "[[species]]\nname = \"ash\"\nupright = true\nlight = \"\"\"a\n[[instance]]\nspecies = \\\"oak\\\"\n\"\"\"",
    "[[instance]]\nspecies = \"oak\"\nposition_m = [1, 2, 3]",
    "[[instance]]\nspecies = \"fir\"\nposition_m = [ # x, y, z\n 1.5,\n 2, 3,\n]\nyaw_deg = 30",
    " [[ \"inst\\u0061nce\" ]] # quoted\n\tspecies = 'oak'\n\t'position_m' = [-0.0, 1e-3, 3]\n\tscale = 2",
    "[[instance]]\nposition_m = [0, 0, 0]\nrotation = [0, 0.6, 0, 0.8]\nspecies = \"\"\"oak\"\"\"",
    "[[instance]]\nspecies = \"oak\"\nposition_m = [0, 0, 0]\nrotation = [0.6, 0, 0, 0.8]",
    "[[instance]]\nspecies = \"elm\"\nposition_m = [0, 0, 0]",
    "[[instance]]\nspecies = \"oak\"\nposition_m = [0, 0]",
    "[[instance]]\nspecies = \"oak\"\nposition_m = [0, 0, nan]",
    "[[instance]]\nspecies = \"oak\"\nposition_m = [0, 0, 0]\nscale = 0",
    "[[instance]]\nspecies = \"oak\"\nspecies = \"oak\"\nposition_m = [0, 0, 0]",
    "[[instance]]\nspecies = \"oak\"\nposition_m.x = 1",
    "[[instance]]\nname.first = 1\nname.last = \"[[instance]]\"",
    "[[instance]]",
    "[[instance]] x = 1",
    "[[instance]",
    "[ [instance]]",
    "[[instance.x]]\ny = 1",
    "[instance.position_m]\ny = 1",
    "[instance]\nspecies = \"oak\"",
    "[[species.instance]]\nx = 1",
    "instance = [{ species = \"oak\", position_m = [0, 0, 0] }, { species = \"fir\", position_m = [1,\n1, 1] }]",
    "instance = [\n  { species = \"oak\", position_m = [0, 0, 0], scale = 3 }, # [[instance]]\n]",
    "'instance' = [ # none\n]",
    "instance = [[\"oak\", [0, 0, 0], 30, 1, 2], [\"oak\"]]",
    "instance = [{ species = \"oak\", position_m = [0, 0, 0] },, { species = \"oak\" }]",
    "instance = [{ species = \"oak\", position_m = [0, 0, 0] }",
    "instance = [{ species = \"oak\", position_m = [0, 0, 0] }}",
    "instance = [3, \"x\"]",
    "instance = 3",
    "instance.species = \"oak\"",
    "bands = [\"R\", # [[instance]]\n \"G\"\n]",
    "bands = [\n[[instance]]\n]",
    "light = '[[instance]]'",
    "sky = { ambient = 0.5 }",
    "sky.ambient = -1",
    "[sky]\nambient = 1",
    "[ground]\nheight_m = 0\n[water]\nheight_m = 1",
    "sun.fixed = [[1, 2]]",
    "camera = {\n  position_m = [0, 1, 2], # eye\n  fov_deg = 40,\n  height_px = 9,\n}",
    "terrain = 1",
    "# [[instance]]",
    "# \u{1}",
    "",
    "\t ",
    "x",
    "= 1",
    "]",
    "}",
    "\"\"\"",
    "'''",
    "\"x",
    "a = [\n",
    "\u{feff}",
    "\r",
];

/// Where the first species and a scene's sound pieces stand in the table.
const SOUND: usize = 7;

fn outcomes(text: &str) -> [Result<Scene, ImportError>; 2] {
    let folder = Path::new("scenes");
    [Scene::parse_in_parts, Scene::parse_as_a_whole].map(|parse| parse("a.toml", folder, text))
}

/// Fails unless both ways accept the text, or neither does. Where the message of one mistake is certain, it is the
/// same.
fn check(text: &str, is_one_mistake: bool) {
    let [parts, whole] = outcomes(text);
    match (parts, whole) {
        (Ok(parts), Ok(whole)) => assert_eq!(parts, whole, "{text}"),
        (Err(parts), Err(whole)) => {
            if is_one_mistake {
                assert_eq!(parts.to_string(), whole.to_string(), "{text}");
            }
        }
        (parts, whole) => panic!("{text}\nin parts: {parts:?}\nas a whole: {whole:?}"),
    }
}

fn any_text(pieces: impl Strategy<Value = Vec<usize>>) -> impl Strategy<Value = String> {
    (pieces, any::<bool>(), any::<bool>()).prop_map(|(pieces, crlf, ends)| {
        let mut text = pieces.iter().map(|&piece| PIECES[piece]).collect::<Vec<_>>().join("\n");
        if ends {
            text.push('\n');
        }
        if crlf { text.replace('\n', "\r\n") } else { text }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

    #[test]
    fn parts_and_the_whole_give_the_same_scene_or_both_an_error(
        text in any_text(proptest::collection::vec(0..PIECES.len(), 0..8)),
    ) {
        check(&text, false);
    }

    #[test]
    fn one_unsound_piece_among_sound_ones_gives_the_same_scene_or_the_same_message(
        before in proptest::collection::vec(3..SOUND, 0..4),
        odd in 0..PIECES.len(),
        after in proptest::collection::vec(3..SOUND, 0..4),
    ) {
        let pieces = [vec![0, 1, 3], before, vec![odd], after, vec![3, 4]].concat();
        let text = pieces.iter().map(|&piece| PIECES[piece]).collect::<Vec<_>>().join("\n");
        check(&text, true);
    }

    #[test]
    fn a_changed_byte_changes_both(
        text in any_text(proptest::collection::vec(0..SOUND, 1..6)),
        place in any::<proptest::sample::Index>(),
        sign in proptest::sample::select("[]{}=.,\"'#\n\r \\x1".chars().collect::<Vec<_>>()),
        cut in any::<bool>(),
    ) {
        let at = text.floor_char_boundary(place.index(text.len()));
        let mut changed = text;
        if cut {
            changed.remove(at);
        }
        changed.insert(at, sign);
        check(&changed, false);
    }
}

#[test]
fn every_sound_piece_is_sound_and_some_texts_of_the_properties_are_accepted() {
    let all: Vec<&str> = PIECES[..SOUND].to_vec();
    let [parts, whole] = outcomes(&all.join("\n"));
    assert_eq!(parts.expect("it is sound").instances.len(), 4);
    assert!(whole.is_ok());
    for piece in
        PIECES.iter().filter(|piece| piece.starts_with("instance = [\n") || piece.starts_with("'inst"))
    {
        let text = format!("{piece}\n{}", PIECES[0]);
        let [parts, whole] = outcomes(&text);
        assert_eq!(parts.expect("it is sound"), whole.expect("it is sound"), "{text}");
    }
}

#[test]
fn a_large_text_tells_the_line_of_a_mistake_as_a_small_one_does() {
    let plant = format!("{}\n", PIECES[3]);
    let large = MAX_TREE.tokens / 15;
    let mistakes = [
        ("scale = 0\n", "instance.scale: found 0"),
        ("scale = \"x\"\n", "invalid type: string"),
        ("species = \"oak\"\n", "duplicate key"),
        ("tree = 1\n", "unknown field `tree`"),
        ("[x]\n", "unknown field `x`"),
        ("x = [\n", "TOML parse error"),
    ];
    for (mistake, words) in mistakes {
        let of = |plants: usize| {
            let before = plant.repeat(plants);
            let text = format!("{}\n{before}{plant}{mistake}{plant}", PIECES[0]);
            let message = Scene::parse("a.toml", Path::new(""), &text).expect_err(mistake).to_string();
            assert!(message.contains(words), "{message}");
            let number = message.split("line ").nth(1).expect("a line");
            let line: usize = number.split([',', ':']).next().expect("a number").parse().expect("a number");
            (line, message)
        };
        let ((near, small), (far, huge)) = (of(0), of(large));
        assert_eq!(far, near + 3 * large, "{small}\n{huge}");
        // But for that line's number nothing is told in another way.
        let parts = |message: &str, line: usize| {
            let first = message.lines().next().unwrap_or_default().replace(&format!("line {line}"), "line");
            (first, message.lines().last().unwrap_or_default().replace(&format!("line {line}"), "line"))
        };
        assert_eq!(parts(&small, near), parts(&huge, far));
    }
}

#[test]
fn what_toml_would_make_a_large_tree_of_is_a_limit() {
    let scene = format!("{}\n{}\n", PIECES[0], PIECES[3]);
    let parse = |text: &str| Scene::parse("a.toml", Path::new(""), text);
    let tokens = MAX_TREE.tokens;
    let cases = [
        (
            format!("{scene}[x]\n{}", "a=1\n".repeat(tokens / 4)),
            "words and signs of TOML beside its instances: ",
        ),
        (format!("{scene}x=[{}]", "1,".repeat(tokens / 2)), "words and signs of TOML of an instance: "),
        (format!("#{}\n{scene}", "c".repeat(MAX_TREE.bytes)), "bytes of TOML beside its instances: "),
        (format!("{scene}#{}\n", "c".repeat(MAX_TREE.bytes)), "bytes of TOML of an instance: "),
    ];
    for (text, words) in cases {
        let error = parse(&text).expect_err(words);
        assert_eq!(error.fault(), crate::import::Fault::Limit, "{error}");
        assert!(error.to_string().starts_with(&format!("a.toml: {words}")), "{error}");
    }
    // As many instances as there may be, each a line.
    let line = "{species=\"oak\",position_m=[0,0,0]},\n";
    let all = |count: usize| format!("instance=[{}]\n[[species]]\nname=\"oak\"\n", line.repeat(count));
    assert_eq!(parse(&all(MAX_INSTANCES)).expect("it is sound").instances.len(), MAX_INSTANCES);
    let message = parse(&all(MAX_INSTANCES + 1)).expect_err("too many").to_string();
    assert_eq!(message, "a.toml: instances: 1048577 is over the limit of 1048576");
    let long = " ".repeat(MAX_SCENE_BYTES as usize + 1);
    let message = parse(&long).expect_err("too long").to_string();
    assert_eq!(message, "a.toml: bytes of the scene: 67108865 is over the limit of 67108864");
}
