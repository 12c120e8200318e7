//! Words in names that tell leaf from wood, in the languages and habits of exporters.
//!
//! A name is split where letters meet other characters and where lower case meets upper:
//! `Leaves_Mat.001` is `leaves`, `mat`; `oakBark2` is `oak`, `bark`. A part counts if it is a listed
//! word, or (for words marked `within`) if it starts or ends with one: `Eichenblatt`, `oakleaf`.
//! Where a name holds words of both kinds, the LAST one decides, as in compounds of English and
//! German: `leaf_stem` is wood, `branch_leaves` is leaf. So a last noun that is no plant's, as in
//! `flower_pot` and `grass_ground`, or that is not known, as in `leaf_tray`, leaves the class open.
//! Where both things are meant, as in `leaf_bark_atlas` and `branches_leaves`, neither decides. What an engine keeps
//! beside a plant, as `UCX_trunk` and `leaves_billboard`, is no part of it, wherever the word stands.

mod lists;

use std::collections::HashMap;
use std::sync::LazyLock;

use lists::{
    AND, ATLASES, BRANCHES, COVERS, FLOWERS, FLOWERS_WITHIN, FOREIGN, FOREIGN_WITHIN, GROWN, LEAF,
    LEAF_WITHIN, LEAVES, NEUTRAL, OF, PLURALS, ROOTS, STAND_INS, STAND_INS_WITHIN, TRUNKS, TWIGS, WOOD,
    WOOD_WITHIN,
};
use unicode_normalization::UnicodeNormalization;

use crate::class::MaterialClass;

/// Evidence of a name for a class.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Told {
    /// Leaf or wood, and the word that says so.
    Class(MaterialClass, String),
    /// Word of something that is no plant: only its user knows what it is to the light.
    Foreign(String),
    /// A leaf word and a wood word, both of which are meant.
    Both([String; 2]),
    /// A class word before a noun that is not known: the noun.
    Unsure(String),
    /// No word of a class.
    Nothing,
}

/// Reads the evidence of a name for a class.
pub fn told(name: &str) -> Told {
    let parts = parts_of_name(name);
    if let Some(word) = stand_in_of(&parts) {
        return Told::Foreign(word);
    }
    let mut unknown: Option<&String> = None;
    for (at, part) in parts.iter().enumerate().rev() {
        match told_by_part(part) {
            Told::Class(class, word) => match unknown {
                Some(noun) if !is_in(PLURALS, part) => return Told::Unsure(noun.clone()),
                _ if at > 0 && parts[0] == "col" => return Told::Foreign(parts[0].clone()),
                _ => {
                    let plain = || both(&parts[..=at], class).unwrap_or(Told::Class(class, word));
                    return head_before(&parts[..at], part).map_or_else(plain, Told::Foreign);
                }
            },
            Told::Nothing if is_neutral(part) => {}
            Told::Nothing => unknown = unknown.or(Some(part)),
            // Before a word of a plant, as in `rock_fern`, it is no head.
            foreign => return foreign,
        }
    }
    Told::Nothing
}

/// The thing that a name is of, where its head stands first: a word of a thing right before a word of [`COVERS`], or
/// before one of [`OF`].
fn head_before(before: &[String], word: &str) -> Option<String> {
    let is_thing = |part: &&String| matches!(told_by_part(part), Told::Foreign(_));
    let says = |part: &&String| !is_neutral(part);
    let next = before.iter().rev().find(says).filter(|_| is_in(COVERS, word)).filter(is_thing);
    let of = before.windows(2).find(|pair| is_in(OF, &pair[1]) && is_thing(&&pair[0])).map(|pair| &pair[0]);
    next.or(of).cloned()
}

/// Whether a name is that of an image of several things: `leaf_atlas`.
pub(crate) fn is_of_several(name: &str) -> bool {
    parts_of_name(name).iter().any(|part| is_in(ATLASES, part))
}

/// Whether a name is that of a flower: the word that makes it leaf is one of flowers.
pub(crate) fn is_flower(name: &str) -> bool {
    match told(name) {
        Told::Class(MaterialClass::Leaf, word) => {
            let mut within = FLOWERS_WITHIN.split_whitespace();
            is_in(FLOWERS, &word) || within.any(|part| word.starts_with(part) || word.ends_with(part))
        }
        _ => false,
    }
}

/// Whether a word of leaf is said of bare wood, too, or one of wood of cards of leaves.
pub(crate) fn is_of_either(word: &str) -> bool {
    is_in(TWIGS, word) || is_in(BRANCHES, word)
}

/// Whether a name is that of the first node of a file, and no root of a plant: `RootNode`, `GLTF_SceneRootNode`.
pub(crate) fn is_first_node(name: &str) -> bool {
    let parts = parts_of_name(name);
    parts.iter().any(|part| part == "root" || part == "rootnode")
        && parts.iter().all(|part| is_neutral(part) || is_in(ROOTS, part) || part == "rootnode")
}

/// Whether a word of a class says that and nothing else: leaves, or a trunk. A branch may be a card of leaves.
pub(crate) fn is_plainly(class: MaterialClass, word: &str) -> bool {
    match class {
        MaterialClass::Leaf => is_in(LEAVES, word),
        MaterialClass::Wood => is_in(TRUNKS, word),
        MaterialClass::Neither => false,
    }
}

/// The word of a name that says it is something beside a plant that stands for it.
pub fn stand_in(name: &str) -> Option<String> {
    stand_in_of(&parts_of_name(name))
}

fn stand_in_of(parts: &[String]) -> Option<String> {
    let is = |part: &&String| {
        is_in(STAND_INS, part) || STAND_INS_WITHIN.split_whitespace().any(|word| part.ends_with(word))
    };
    parts.iter().find(is).cloned()
}

/// Whether the last of `parts`, a word of `class`, and one before it are both meant.
fn both(parts: &[String], class: MaterialClass) -> Option<Told> {
    let (last, before) = parts.split_last()?;
    let said = |[first, last]: [&str; 2]| match class {
        MaterialClass::Leaf => Told::Both([last.to_owned(), first.to_owned()]),
        _ => Told::Both([first.to_owned(), last.to_owned()]),
    };
    // `trunkleaf`.
    let halves = |first: &str, second: &str| {
        let start = first.split_whitespace().find(|word| word.len() > 2 && last.starts_with(word))?;
        let end =
            second.split_whitespace().find(|word| word.len() > 2 && last[start.len()..].ends_with(word))?;
        Some(said([start, end]))
    };
    if let Some(found) = halves(LEAVES, TRUNKS).or_else(|| halves(TRUNKS, LEAVES)) {
        return Some(found);
    }
    if class == MaterialClass::Leaf && is_in(GROWN, last) {
        let says = |part: &&String| !is_neutral(part) && !is_in(AND, part) && !is_in(OF, part);
        let on = before.iter().rev().find(says);
        // A wood fern is a fern.
        let is_bark = |part: &&String| {
            matches!(told_by_part(part), Told::Class(MaterialClass::Wood, _))
                && !(part.as_str() == "wood" && last.starts_with("fern"))
        };
        if let Some(part) = on.filter(is_bark) {
            return Some(said([part, last]));
        }
    }
    let mut joined = false;
    let mut is_next = true;
    for part in before.iter().rev() {
        joined |= is_in(AND, part);
        match told_by_part(part) {
            Told::Class(other, _) if other != class => {
                let [leaf, wood] = if class == MaterialClass::Leaf { [last, part] } else { [part, last] };
                let several = is_in(PLURALS, part) && !is_in(TRUNKS, part) || part == "trunks";
                let two = is_in(LEAVES, leaf) && (several || is_next && is_in(TRUNKS, wood));
                if two || joined {
                    return Some(said([part, last]));
                }
            }
            _ => {}
        }
        is_next &= is_in(AND, part);
    }
    None
}

/// Words of a name, in lower case, without digits: parted by other characters and where case changes.
pub(crate) fn parts_of_name(name: &str) -> Vec<String> {
    // Some systems write an umlaut as a letter and a mark.
    parts_of(&name.nfc().collect::<String>())
}

/// The class that a name tells, and the word that tells it.
pub fn class_of_name(name: &str) -> Option<(MaterialClass, String)> {
    match told(name) {
        Told::Class(class, word) => Some((class, word)),
        Told::Foreign(_) | Told::Both(_) | Told::Unsure(_) | Told::Nothing => None,
    }
}

fn is_neutral(part: &str) -> bool {
    part.chars().count() <= 1 || WORDS.get(part) == Some(&Word::Neutral)
}

fn told_by_part(part: &str) -> Told {
    let class = |class| Told::Class(class, part.to_owned());
    let word = WORDS.get(part).copied();
    match word {
        Some(Word::Leaf) => return class(MaterialClass::Leaf),
        Some(Word::Wood) => return class(MaterialClass::Wood),
        _ => {}
    }
    let ends = |words: &str| words.split_whitespace().any(|word| part.ends_with(word));
    if word == Some(Word::Foreign) || ends(FOREIGN_WITHIN) {
        return Told::Foreign(part.to_owned());
    }
    // `leafstem` or `barkleaf`: what ends the part decides.
    if ends(WOOD_WITHIN) {
        return class(MaterialClass::Wood);
    }
    if ends(LEAF_WITHIN) {
        return class(MaterialClass::Leaf);
    }
    // `leafmat`, but not `leafless`: what follows must say nothing.
    let starts = |words: &str| {
        let rest = |word| part.strip_prefix(word).is_some_and(|rest| rest == "s" || is_ending(rest));
        words.split_whitespace().any(rest)
    };
    match (starts(LEAF_WITHIN), starts(WOOD_WITHIN)) {
        (true, _) => class(MaterialClass::Leaf),
        (false, true) => class(MaterialClass::Wood),
        (false, false) => Told::Nothing,
    }
}

fn is_in(words: &str, part: &str) -> bool {
    words.split_whitespace().any(|word| word == part)
}

/// What a word is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    Leaf,
    Wood,
    Foreign,
    Neutral,
}

/// All whole words: a file may have a million names.
static WORDS: LazyLock<HashMap<&str, Word>> = LazyLock::new(|| {
    let lists = [(LEAF, Word::Leaf), (WOOD, Word::Wood), (FOREIGN, Word::Foreign), (NEUTRAL, Word::Neutral)];
    lists.into_iter().flat_map(|(list, kind)| list.split_whitespace().map(move |word| (word, kind))).collect()
});

/// What may follow a class word within one part: a neutral word, or an ending of a script that has no parts.
fn is_ending(rest: &str) -> bool {
    is_neutral(rest) || rest.chars().all(|letter| !letter.is_ascii())
}

/// Parts of letters, in lower case.
fn parts_of(name: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut previous = ' ';
    let letters: Vec<char> = name.chars().collect();
    for (i, &letter) in letters.iter().enumerate() {
        if letter.is_alphabetic() {
            let next_is_lower = letters.get(i + 1).is_some_and(|next| next.is_lowercase());
            let starts = !previous.is_alphabetic()
                || (letter.is_uppercase()
                    && (previous.is_lowercase() || (previous.is_uppercase() && next_is_lower)));
            if starts {
                parts.push(String::new());
            }
            parts.last_mut().expect("the first letter starts a part").extend(letter.to_lowercase());
        }
        previous = letter;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use MaterialClass::{Leaf, Wood};

    #[test]
    fn names_are_split_at_case_and_other_characters() {
        assert_eq!(parts_of("Leaves_Mat.001"), ["leaves", "mat"]);
        assert_eq!(parts_of("oakBark2"), ["oak", "bark"]);
        assert_eq!(parts_of("MASTERBranchUV1"), ["master", "branch", "uv"]);
        assert_eq!(parts_of("Äste-3"), ["äste"]);
    }

    #[test]
    fn known_names_have_their_class() {
        let table = [
            ("leaves", Some(Leaf)),
            ("Leaves_Mat.001", Some(Leaf)),
            ("Bla\u{308}tter", Some(Leaf)),
            ("Sta\u{308}mme_01", Some(Wood)),
            ("oakBark", Some(Wood)),
            ("Twig", Some(Leaf)),
            ("Trunk", Some(Wood)),
            ("potted_plant_02_leaves", Some(Leaf)),
            ("potted_plant_02_pot", None),
            ("branches", Some(Wood)),
            ("Eichenblatt", Some(Leaf)),
            ("Baumrinde", Some(Wood)),
            ("leaf_stem", Some(Wood)),
            ("BranchLeaves", Some(Leaf)),
            ("oakleaf02", Some(Leaf)),
            ("boxwood", None),
            ("system", None),
            ("material0", None),
            ("ColorCutout_Leaf-1", Some(Leaf)),
            ("樹皮", Some(Wood)),
            ("листья", Some(Leaf)),
            ("leafmat", Some(Leaf)),
            ("Leaf_Quercus_dark_2k", Some(Leaf)),
            ("leaves_zelkova", Some(Leaf)),
            ("leafless", None),
            ("leafless_bark", Some(Wood)),
            ("crown_cap", Some(Wood)),
            ("rock_fern", Some(Leaf)),
            ("stone_pine_needles", Some(Leaf)),
            ("water_lily_flower", Some(Leaf)),
            ("ground_ivy_leaves", Some(Leaf)),
            ("feuilles_de_chene", Some(Leaf)),
            ("", None),
        ];
        for (name, class) in table {
            assert_eq!(class_of_name(name).map(|(class, _)| class), class, "{name}");
        }
    }

    #[test]
    fn a_last_noun_that_is_no_plants_or_not_known_leaves_the_class_open() {
        let foreign = [
            "flower_pot",
            "FlowerPot",
            "flowerpot",
            "grass_ground",
            "GrassGround.003",
            "Blumentopf",
            "bark_mulch",
            "potted_plant_02_pot",
            "ivy_wall",
            "moss_rock_mat",
            "soil",
            "leaf_planter_lod0",
            "UCX_hull",
            "UCX_trunk_01",
            "collision_bark",
            "col_bark",
            "Occluder_trunk",
            "trunk_collider",
            "tree-colonly",
            "TreeCollider",
            "leaves_billboard",
            "Impostor_Leaves",
            "Ground_grass_0",
            "rock_moss_01",
            "pot_de_fleurs",
            "maceta_con_flores",
            "concrete_flower",
            "plant_pot_wood",
            "floor_wood",
            "Bark_Chips",
            "Porcelain",
            "Blumenkasten",
            "Wicker_01",
            "花盆",
        ];
        for name in foreign {
            assert!(matches!(told(name), Told::Foreign(_)), "{name}: {:?}", told(name));
        }
        for name in ["leaf_beetle", "flower_seller", "branch_office_2"] {
            assert!(matches!(told(name), Told::Unsure(_)), "{name}: {:?}", told(name));
        }
        for name in ["Plant_A", "col", "col_0", "Tree_Base"] {
            assert!(!matches!(told(name), Told::Foreign(_)), "{name}");
        }
    }

    #[test]
    fn a_name_of_two_things_says_neither() {
        let both = [
            "leaf_bark_atlas",
            "Oak_Bark_Leaf_Atlas",
            "leaves_and_trunk",
            "trunkleaf",
            "leafbark2",
            "TreeTrunkLeaves",
            "branches_leaves",
            "BranchesLeaves",
            "Leaves_Oak_Bark",
            "leaf_and_stem",
            "Rinde_und_Laub",
            "Bark_Moss",
            "trunk_with_moss",
            "Wood_Moss_01",
            "Stem_flower",
            "branch_blossom",
            "bark_leafy",
            "bark_moss_diff",
        ];
        for name in both {
            assert!(matches!(told(name), Told::Both(_)), "{name}: {:?}", told(name));
        }
        assert_eq!(told("leaf_bark_atlas"), Told::Both(["leaf".to_owned(), "bark".to_owned()]));
        assert_eq!(told("TreeTrunkLeaves"), Told::Both(["leaves".to_owned(), "trunk".to_owned()]));
        let one = [
            ("cherry_blossom_bark", Wood),
            ("tree_fern_trunk", Wood),
            ("moss_bark", Wood),
            ("Broadleaf_Trunk", Wood),
            ("big_leaf_maple_bark", Wood),
            ("paperbark_leaf", Leaf),
            ("stem_leaf", Leaf),
            ("twig_bark", Wood),
            ("leaf_stem", Wood),
            ("wood_fern_01", Leaf),
            ("rock_fern", Leaf),
            ("oak_moss", Leaf),
            ("twig_flower", Leaf),
        ];
        for (name, class) in one {
            assert_eq!(class_of_name(name).map(|(class, _)| class), Some(class), "{name}");
        }
    }

    #[test]
    fn no_word_is_in_two_lists() {
        let lists = [LEAF, WOOD, FOREIGN, NEUTRAL, STAND_INS, AND];
        for (at, list) in lists.iter().enumerate() {
            for word in list.split_whitespace() {
                assert!(lists[at + 1..].iter().all(|other| !is_in(other, word)), "{word}");
            }
        }
    }

    #[test]
    fn words_are_written_as_parts_are() {
        for word in [LEAF, WOOD, FOREIGN, NEUTRAL, PLURALS, ROOTS, STAND_INS, LEAVES, TRUNKS]
            .iter()
            .flat_map(|list| list.split_whitespace())
        {
            assert_eq!(parts_of(word), [word], "{word} could never match");
        }
    }
}
