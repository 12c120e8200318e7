//! Walks the JSON of a glTF past all that it says, without keeping it, and warns of what is not read.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use super::Rule;
use super::gltf::{Place, find};
use crate::import::error::quoted;
use crate::import::files::Files;

/// Kinds of things that are told.
const TOLD: usize = 64;

/// What is not read, by name: where it is first, how often it is there, and what that means.
#[derive(Default)]
struct Unread {
    kinds: BTreeMap<String, (String, u64, &'static str)>,
    at: String,
}

/// Warns of everything in the JSON of a glTF that is not read, once a kind.
pub(crate) fn warn_of_unread(files: &mut Files, json: &[u8]) {
    let mut unread = Unread::default();
    let mut parser = serde_json::Deserializer::from_slice(json);
    // What is no JSON has been refused before.
    let _ = Walk { place: Place::File, depth: 0, unread: &mut unread }.deserialize(&mut parser);
    for (name, (first, count, why)) in unread.kinds {
        let more = if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
        let at = if first.is_empty() { String::new() } else { format!(" ({first}{more})") };
        files.warn(format!("{name}{at} is not read: {why}"));
    }
}

impl Unread {
    fn add(&mut self, name: &str, why: &'static str) {
        if let Some((_, count, _)) = self.kinds.get_mut(name) {
            *count += 1;
        } else if self.kinds.len() < TOLD {
            self.kinds.insert(quoted(name), (self.at.clone(), 1, why));
        }
    }
}

/// One object, or a list of them.
struct Walk<'u> {
    place: Place,
    /// Of objects: those of depth 1 are told by their list and number.
    depth: u32,
    unread: &'u mut Unread,
}

impl<'de> DeserializeSeed<'de> for Walk<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Walk<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            let place = match key.as_str() {
                "extras" => {
                    map.next_value::<IgnoredAny>()?;
                    continue;
                }
                "extensions" => Some(Place::Extensions),
                _ => None,
            };
            let row = find(self.place, &key);
            let holds = place.or(row.and_then(|row| row.holds));
            if self.depth == 0 {
                self.unread.at.clone_from(&key);
            }
            if let Some(place) = holds {
                map.next_value_seed(Walk { place, depth: self.depth + 1, unread: self.unread })?;
                continue;
            }
            match row.map(|row| row.rule) {
                None if self.place == Place::Extensions => {
                    map.next_value::<IgnoredAny>()?;
                    self.unread.add(&format!("the extension {key}"), "it is not known");
                }
                None => {
                    map.next_value::<IgnoredAny>()?;
                    self.unread.add(&key, "it is not known");
                }
                Some(Rule::Warned(why)) => {
                    map.next_value::<IgnoredAny>()?;
                    self.unread.add(&key, why);
                }
                Some(Rule::WarnedUnless(why, nothing)) => {
                    let value = map.next_value::<Value>()?;
                    if !is_same(&value, &serde_json::from_str(nothing).unwrap_or(Value::Null)) {
                        self.unread.add(&key, why);
                    }
                }
                Some(Rule::Read | Rule::NoMeaning(_) | Rule::Refused(_)) => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let (name, mut number) = (self.unread.at.clone(), 0u64);
        let Walk { place, depth, unread } = self;
        loop {
            if depth == 1 {
                unread.at = format!("{name}[{number}]");
            }
            let walk = Walk { place, depth, unread: &mut *unread };
            if list.next_element_seed(walk)?.is_none() {
                return Ok(());
            }
            number += 1;
        }
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }
}

/// Whether two values are the same, whether numbers are written as whole ones or not.
fn is_same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b))
        }
        _ => a == b,
    }
}
