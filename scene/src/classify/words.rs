//! Words in names that tell leaf from wood, in the languages and habits of exporters.
//!
//! A name is split where letters meet other characters and where lower case meets upper:
//! `Leaves_Mat.001` is `leaves`, `mat`; `oakBark2` is `oak`, `bark`. A part counts if it is a listed
//! word, or (for words marked `within`) if it starts or ends with one: `Eichenblatt`, `oakleaf`.
//! Where a name holds words of both kinds, the LAST one decides, as in compounds of English and
//! German: `leaf_stem` is wood, `branch_leaves` is leaf.

use crate::class::MaterialClass;

/// Leaf, as whole parts of a name. A twig is leaf: real files call their leaf cards so.
const LEAF: &[&str] = &[
    // English
    "leaf",
    "leaves",
    "leafs",
    "lf",
    "lvs",
    "foliage",
    "fol",
    "frond",
    "fronds",
    "needle",
    "needles",
    "twig",
    "twigs",
    "petal",
    "petals",
    "blade",
    "blades",
    "grass",
    "flower",
    "flowers",
    "blossom",
    "blossoms",
    "bloom",
    "sepal",
    "canopy",
    "crown",
    "leafcard",
    "leafcards",
    "leaflet",
    "leaflets",
    "ivy",
    "fern",
    "moss",
    "pinnule",
    "greenery",
    // German
    "blatt",
    "blaetter",
    "blätter",
    "laub",
    "nadel",
    "nadeln",
    "wedel",
    "zweig",
    "zweige",
    "gras",
    "bluete",
    "blüte",
    "blueten",
    "blüten",
    "halm",
    "halme",
    "laubwerk",
    // French, Italian, Spanish, Portuguese
    "feuille",
    "feuilles",
    "feuillage",
    "aiguille",
    "aiguilles",
    "fleur",
    "fleurs",
    "herbe",
    "foglia",
    "foglie",
    "fogliame",
    "fiore",
    "fiori",
    "erba",
    "hoja",
    "hojas",
    "follaje",
    "flor",
    "flores",
    "hierba",
    "folha",
    "folhas",
    "folhagem",
    "petalo",
    "petali",
    "petalos",
    "pétale",
    "pétales",
    // Dutch, Swedish, Polish, Czech
    "blad",
    "bladeren",
    "naald",
    "naalden",
    "löv",
    "lov",
    "barr",
    "lisc",
    "liść",
    "liscie",
    "liście",
    "listi",
    "listí",
];

/// Wood, as whole parts of a name.
const WOOD: &[&str] = &[
    // English
    "bark",
    "trunk",
    "trunks",
    "branch",
    "branches",
    "bough",
    "boughs",
    "limb",
    "limbs",
    "stem",
    "stems",
    "stalk",
    "stalks",
    "wood",
    "log",
    "logs",
    "stump",
    "root",
    "roots",
    "cane",
    "canes",
    "culm",
    "petiole",
    "cambium",
    "brn",
    "trk",
    "cap",
    "caps",
    // German
    "rinde",
    "borke",
    "stamm",
    "staemme",
    "stämme",
    "ast",
    "aeste",
    "äste",
    "holz",
    "wurzel",
    "wurzeln",
    "stiel",
    "stängel",
    "staengel",
    // French, Italian, Spanish, Portuguese
    "ecorce",
    "écorce",
    "tronc",
    "branche",
    "branches",
    "tige",
    "tiges",
    "bois",
    "racine",
    "racines",
    "corteccia",
    "tronco",
    "ramo",
    "rami",
    "legno",
    "gambo",
    "radice",
    "corteza",
    "rama",
    "ramas",
    "tallo",
    "madera",
    "casca",
    "galho",
    "galhos",
    "madeira",
    "caule",
    // Dutch, Swedish, Polish, Czech
    "schors",
    "boomstam",
    "tak",
    "takken",
    "stengel",
    "gren",
    "grenar",
    "kora",
    "kmen",
    "pien",
    "pień",
    "galaz",
    "gałąź",
    "vetev",
    "větev",
];

/// Leaf words that count at the start or end of a longer part.
const LEAF_WITHIN: &[&str] = &[
    "leaf",
    "leaves",
    "foliage",
    "frond",
    "needle",
    "petal",
    "blatt",
    "blaetter",
    "blätter",
    "nadeln",
    "feuille",
    "葉",
    "叶",
    "листь",
];

/// Wood words that count at the start or end of a longer part. Not `wood` and `holz`, which end the
/// names of species (boxwood), nor `stem` (system).
const WOOD_WITHIN: &[&str] = &[
    "bark",
    "trunk",
    "branch",
    "stamm",
    "rinde",
    "幹",
    "枝",
    "树皮",
    "树干",
    "树枝",
    "樹皮",
    "кора",
    "ветк",
    "ствол",
];

/// The class that a name tells, and the word that tells it.
pub fn class_of_name(name: &str) -> Option<(MaterialClass, String)> {
    parts_of(name).into_iter().rev().find_map(|part| Some((class_of_part(&part)?, part)))
}

fn class_of_part(part: &str) -> Option<MaterialClass> {
    let within = |words: &[&str]| words.iter().any(|word| part.starts_with(word) || part.ends_with(word));
    if LEAF.contains(&part) {
        Some(MaterialClass::Leaf)
    } else if WOOD.contains(&part) {
        Some(MaterialClass::Wood)
    } else {
        // `leafstem` or `barkleaf`: what ends the part decides.
        match (within(LEAF_WITHIN), within(WOOD_WITHIN)) {
            (true, true) if WOOD_WITHIN.iter().any(|word| part.ends_with(word)) => Some(MaterialClass::Wood),
            (true, _) => Some(MaterialClass::Leaf),
            (false, true) => Some(MaterialClass::Wood),
            (false, false) => None,
        }
    }
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
            ("", None),
        ];
        for (name, class) in table {
            assert_eq!(class_of_name(name).map(|(class, _)| class), class, "{name}");
        }
    }

    #[test]
    fn no_word_is_in_both_lists() {
        assert!(LEAF.iter().all(|word| !WOOD.contains(word)));
    }

    #[test]
    fn words_are_written_as_parts_are() {
        for word in LEAF.iter().chain(WOOD) {
            assert_eq!(parts_of(word), [*word], "{word} could never match");
        }
    }
}
