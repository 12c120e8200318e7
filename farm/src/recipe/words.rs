//! Words of settings, as the command line spells them, to and from their values.

use serde::{Deserialize, Deserializer, Serializer, de::Error};

use super::{ModelName, SolverName};

/// The value of a word, or an error that lists all words.
fn read<'de, D: Deserializer<'de>, T: Copy>(
    deserializer: D,
    all: &[T],
    name: fn(T) -> &'static str,
) -> Result<Option<T>, D::Error> {
    let word = String::deserialize(deserializer)?;
    let names = || all.iter().map(|value| name(*value)).collect::<Vec<_>>().join(", ");
    let found = all.iter().copied().find(|value| name(*value) == word);
    found.map(Some).ok_or_else(|| D::Error::custom(format!("found {word:?}, expected one of {}", names())))
}

/// A module for `#[serde(with)]` of an optional value that has a name.
macro_rules! words {
    ($module:ident, $type:ty, $all:expr, $name:expr) => {
        pub(super) mod $module {
            use super::*;

            pub(in crate::recipe) fn deserialize<'de, D: Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Option<$type>, D::Error> {
                read(deserializer, &$all, $name)
            }

            pub(in crate::recipe) fn serialize<S: Serializer>(
                value: &Option<$type>,
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                let name: fn($type) -> &'static str = $name;
                match value {
                    Some(value) => serializer.serialize_str(name(*value)),
                    None => serializer.serialize_none(),
                }
            }
        }
    };
}

use flb_baker::crown::LeafAngleChoice;
use flb_format::light::FieldKind;
use flb_format::{Codec, Purpose, Quality};
use flb_transport::ordinates::NamedSuns;

const QUALITIES: [Quality; 5] =
    [Quality::Draft, Quality::Standard, Quality::Fine, Quality::Reference, Quality::Papers];
const FIELDS: [FieldKind; 2] = [FieldKind::Scattered, FieldKind::Total];
const LEAF_ANGLES: [LeafAngleChoice; 4] = [
    LeafAngleChoice::Measured,
    LeafAngleChoice::Spherical,
    LeafAngleChoice::Planophile,
    LeafAngleChoice::Erectophile,
];

words!(quality, Quality, QUALITIES, Quality::name);
words!(purpose, Purpose, Purpose::ALL, Purpose::name);
words!(model, ModelName, ModelName::ALL, ModelName::name);
words!(solver, SolverName, SolverName::ALL, SolverName::name);
words!(suns, NamedSuns, NamedSuns::ALL, NamedSuns::name);
words!(field, FieldKind, FIELDS, FieldKind::name);
words!(leaf_angles, LeafAngleChoice, LEAF_ANGLES, LeafAngleChoice::name);
words!(codec, Codec, Codec::ALL, Codec::name);

impl SolverName {
    /// All names.
    pub const ALL: [SolverName; 3] = [SolverName::Sweep, SolverName::Explicit, SolverName::Literal];

    /// "sweep", "explicit" or "literal".
    pub fn name(self) -> &'static str {
        match self {
            SolverName::Sweep => "sweep",
            SolverName::Explicit => "explicit",
            SolverName::Literal => "literal",
        }
    }
}
