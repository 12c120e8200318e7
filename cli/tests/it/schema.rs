//! A checker for the part of JSON Schema (draft 2020-12) that `cli/schema/*.json` uses. A keyword that
//! it does not know is a failure: nothing is passed over in silence.

use std::path::Path;

use serde_json::Value;

/// Every command, by its schema. `help.rs` holds the list against `flb --help`.
pub(crate) fn commands() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema");
    let files = std::fs::read_dir(&folder).expect("the schemas lie beside the command");
    let names = files.map(|file| file.expect("an entry").file_name().into_string().expect("a plain name"));
    let mut commands: Vec<String> =
        names.map(|name| name.strip_suffix(".json").expect("schemas alone").to_owned()).collect();
    commands.sort_unstable();
    commands
}

/// The schema of a command's `--json`.
pub(crate) fn schema(command: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("schema/{command}.json"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What of `value` does not fit the schema, one sentence each.
pub(crate) fn misfits(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "$", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    let schema =
        schema.as_object().unwrap_or_else(|| panic!("{place}: a schema is an object, found {schema}"));
    for (keyword, expected) in schema {
        let fits = match keyword.as_str() {
            "$schema" | "$id" | "$defs" | "title" | "description" => true,
            "$ref" => {
                let name =
                    expected.as_str().and_then(|r| r.strip_prefix("#/$defs/")).expect("a local reference");
                check(root, &root["$defs"][name], value, place, found);
                true
            }
            "type" => match expected {
                Value::Array(types) => types.iter().any(|t| is_of_type(value, t)),
                one => is_of_type(value, one),
            },
            "enum" => expected.as_array().expect("enum is a list").contains(value),
            "const" => expected == value,
            "minimum" => value.as_f64().is_none_or(|v| v >= expected.as_f64().expect("a number")),
            "maximum" => value.as_f64().is_none_or(|v| v <= expected.as_f64().expect("a number")),
            "minItems" => {
                value.as_array().is_none_or(|v| v.len() as u64 >= expected.as_u64().expect("a count"))
            }
            "maxItems" => {
                value.as_array().is_none_or(|v| v.len() as u64 <= expected.as_u64().expect("a count"))
            }
            "required" => {
                for key in expected.as_array().expect("required is a list") {
                    let key = key.as_str().expect("a key");
                    if value.is_object() && value.get(key).is_none() {
                        found.push(format!("{place}: {key} is missing"));
                    }
                }
                true
            }
            "properties" => {
                for (key, inner) in expected.as_object().expect("properties is an object") {
                    if let Some(value) = value.get(key) {
                        check(root, inner, value, &format!("{place}.{key}"), found);
                    }
                }
                true
            }
            "additionalProperties" => {
                assert_eq!(expected, &Value::Bool(false), "{place}: only false is known here");
                for key in value.as_object().into_iter().flat_map(|object| object.keys()) {
                    if schema.get("properties").and_then(|p| p.get(key)).is_none() {
                        found.push(format!("{place}: {key} is not in the schema"));
                    }
                }
                true
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, expected, item, &format!("{place}[{i}]"), found);
                }
                true
            }
            unknown => panic!("{place}: keyword {unknown} is not known to this checker"),
        };
        if !fits {
            found.push(format!("{place}: found {value}, expected {keyword} {expected}"));
        }
    }
}

fn is_of_type(value: &Value, name: &Value) -> bool {
    match name.as_str().expect("a type is a word") {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|v| v.fract() == 0.0),
        other => panic!("type {other} is not of JSON Schema"),
    }
}
