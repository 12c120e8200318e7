//! How [`SunBasis`] and [`LeafAngles`] are written: each value in one way only.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{MAX_SOLID_OFFSET, SunBasis};
use crate::beam::reaches;
use crate::sun::directions::SunDirections;
use crate::turbid::{INCLINATIONS, LeafAngles};

/// Randomly oriented leaves, instead of 32 equal shares.
const SPHERICAL: &str = "spherical";

/// For an optional member: it may be absent, not null.
pub(crate) fn present<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

/// Of solids: present, and within its range.
pub(crate) fn solid_offset<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let found = f64::deserialize(deserializer)?;
    match (0.0..=MAX_SOLID_OFFSET).contains(&found) {
        true => Ok(Some(found)),
        false => Err(D::Error::custom(format!(
            "light.solid_offset is {found}, expected a number from 0 to {MAX_SOLID_OFFSET}"
        ))),
    }
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlainSuns {
    kind: String,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    degree: Option<u8>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    reaches: Option<Vec<u32>>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    single: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    leaning: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    directions: Option<Vec<[f64; 3]>>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    triangles: Option<Vec<[u32; 3]>>,
}

impl Serialize for SunBasis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut plain = PlainSuns { kind: self.name().to_owned(), ..PlainSuns::default() };
        match self {
            SunBasis::Lattice18 => {}
            SunBasis::Harmonics { degree, single, leaning } => {
                plain.degree = Some(*degree);
                plain.reaches = Some(reaches(*single).to_vec());
                plain.single = single.then_some(true);
                plain.leaning = leaning.then_some(true);
            }
            SunBasis::Directions(list) => {
                plain.directions = Some(list.directions().to_vec());
                plain.triangles =
                    Some(list.triangles().iter().map(|triangle| triangle.map(u32::from)).collect());
            }
        }
        plain.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for SunBasis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<SunBasis, D::Error> {
        let plain = PlainSuns::deserialize(deserializer)?;
        let PlainSuns { kind, degree, reaches: found, single, leaning, directions, triangles } = plain;
        match (kind.as_str(), degree, found, [single, leaning], directions, triangles) {
            ("lattice18", None, None, [None, None], None, None) => Ok(SunBasis::Lattice18),
            ("harmonics", Some(degree), Some(found), [None | Some(true), None | Some(true)], None, None)
                if found == reaches(single.is_some()) =>
            {
                Ok(SunBasis::Harmonics { degree, single: single.is_some(), leaning: leaning.is_some() })
            }
            ("directions", None, None, [None, None], Some(directions), Some(triangles)) => {
                let list = SunDirections::new(directions, triangles).map_err(D::Error::custom)?;
                Ok(SunBasis::Directions(list.into()))
            }
            (_, degree, found, [single, leaning], directions, triangles) => {
                let count = |list: Option<usize>| list.map_or("no".to_owned(), |count| count.to_string());
                Err(D::Error::custom(format!(
                    "light.suns of kind {kind:?}, degree {degree:?}, reaches {found:?}, single {single:?}, leaning \
                     {leaning:?}, {} directions, {} triangles: expected \"lattice18\" alone; \"harmonics\" with a degree \
                     and reaches {:?}, or with a degree, reaches {:?} and single true, and leaning true or none; or \
                     \"directions\" with directions and triangles",
                    count(directions.map(|list| list.len())),
                    count(triangles.map(|list| list.len())),
                    reaches(false),
                    reaches(true)
                )))
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum PlainAngles {
    Name(String),
    Shares(Vec<f64>),
}

impl Serialize for LeafAngles {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.is_spherical() {
            serializer.serialize_str(SPHERICAL)
        } else {
            serializer.collect_seq(self.shares())
        }
    }
}

impl<'de> Deserialize<'de> for LeafAngles {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<LeafAngles, D::Error> {
        let expected =
            "expected \"spherical\", or 32 shares from 0 to 1, not all equal, that sum to 1 within 1e-6";
        let wrong = |found: String| D::Error::custom(format!("light.leaf_angles are {found}: {expected}"));
        match PlainAngles::deserialize(deserializer).map_err(|_| wrong("of another type".to_owned()))? {
            PlainAngles::Name(name) if name == SPHERICAL => Ok(LeafAngles::spherical()),
            PlainAngles::Name(name) => Err(wrong(format!("{name:?}"))),
            PlainAngles::Shares(shares) => {
                let found = || format!("{} shares that sum to {}", shares.len(), shares.iter().sum::<f64>());
                let array: [f64; INCLINATIONS] = shares.as_slice().try_into().map_err(|_| wrong(found()))?;
                LeafAngles::from_shares(array)
                    .filter(|angles| !angles.is_spherical())
                    .ok_or_else(|| wrong(found()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaf_angles_come_back_bit_for_bit_and_in_one_spelling() {
        for angles in [LeafAngles::spherical(), LeafAngles::planophile(), LeafAngles::erectophile()] {
            let text = serde_json::to_string(&angles).expect("they are numbers");
            let back: LeafAngles = serde_json::from_str(&text).expect("they were written so");
            assert_eq!(back, angles);
            assert_eq!(serde_json::to_string(&back).expect("they are numbers"), text);
        }
        assert_eq!(serde_json::to_string(&LeafAngles::spherical()).expect("a name"), "\"spherical\"");
        let even = serde_json::to_string(&[1.0 / 32.0; 32]).expect("numbers");
        let short = serde_json::to_string(&[1.0 / 31.0; 31]).expect("numbers");
        let sum = serde_json::to_string(&[0.03; 32]).expect("numbers");
        let mut below = [2.0 / 32.0; 32];
        below[..16].fill(0.0);
        below[0] = -0.5;
        below[1] = 0.5;
        let below = serde_json::to_string(&below).expect("numbers");
        for wrong in [&even[..], &short, &sum, &below, "\"planophile\"", "{}", "null", "[]"] {
            let error = serde_json::from_str::<LeafAngles>(wrong).expect_err(wrong).to_string();
            assert!(
                error.contains("light.leaf_angles are") && error.contains("expected"),
                "{wrong}: {error}"
            );
        }
    }

    const TETRAHEDRON: &str = r#"{"kind":"directions","directions":[[0.6,0.8,0.0],[0.6,-0.8,0.0],[-0.6,0.0,0.8],[-0.6,0.0,-0.8]],"triangles":[[0,1,3],[0,2,1],[0,3,2],[1,2,3]]}"#;

    #[test]
    fn suns_have_no_members_of_another_kind() {
        let harmonics = |single, leaning| SunBasis::Harmonics { degree: 2, single, leaning };
        let directions: SunBasis = serde_json::from_str(TETRAHEDRON).expect("a tetrahedron");
        assert_eq!(serde_json::to_string(&directions).expect("plain"), TETRAHEDRON);
        let all = [(false, false), (true, false), (false, true), (true, true)];
        let harmonics = all.map(|(single, leaning)| harmonics(single, leaning));
        for suns in harmonics.into_iter().chain([SunBasis::Lattice18, directions]) {
            let text = serde_json::to_string(&suns).expect("plain");
            assert_eq!(serde_json::from_str::<SunBasis>(&text).expect(&text), suns);
        }
        for wrong in [
            r#"{"kind":"lattice18","degree":1}"#,
            r#"{"kind":"harmonics","degree":1}"#,
            r#"{"kind":"harmonics","degree":1,"reaches":[1,3]}"#,
            r#"{"kind":"harmonics","degree":null,"reaches":[1,3,8]}"#,
            r#"{"kind":"harmonics","degree":1,"reaches":[1,3,8],"more":0}"#,
            r#"{"kind":"harmonics","degree":1,"reaches":[1,3,8],"single":false}"#,
            r#"{"kind":"harmonics","degree":1,"reaches":[1,3,8],"single":true}"#,
            r#"{"kind":"harmonics","degree":1,"reaches":[8]}"#,
            r#"{"kind":"lattice18","single":true}"#,
            r#"{"kind":"lattice18","leaning":true}"#,
            r#"{"kind":"harmonics","degree":1,"reaches":[1,3,8],"leaning":false}"#,
            r#"{"kind":"harmonics","degree":1,"reaches":[1,3,8],"leaning":null}"#,
            &TETRAHEDRON.replace("directions\",", "directions\",\"leaning\":true,"),
            r#"{"kind":"sh2"}"#,
            r#""lattice18""#,
            r#"{"kind":"directions"}"#,
            &TETRAHEDRON.replace("directions\",", "directions\",\"degree\":1,"),
            &TETRAHEDRON.replace("directions\",", "lattice18\","),
            &TETRAHEDRON.replace(",\"triangles\":[[0,1,3],[0,2,1],[0,3,2],[1,2,3]]", ""),
            &TETRAHEDRON.replace("0.8,0.0]", "0.8]"),
            &TETRAHEDRON.replace("[1,2,3]", "[1,2]"),
            &TETRAHEDRON.replace("[1,2,3]", "[1,2,-3]"),
            &TETRAHEDRON.replace("[1,2,3]", "[1,2,3.5]"),
        ] {
            assert!(serde_json::from_str::<SunBasis>(wrong).is_err(), "{wrong}");
        }
    }
}
