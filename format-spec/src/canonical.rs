//! Canonical JSON: one value, one byte string. RFC 8785 (JSON Canonicalization Scheme) with limits of
//! our own; SPEC.md section 9 restates the rules.

use serde_json::{Number, Value};

/// Deepest nesting of arrays and objects; the outermost object is level 1.
pub const MAX_DEPTH: usize = 32;
/// Largest magnitude of a number without a fraction, 2^53: beyond it integers and doubles part.
pub const MAX_INTEGER: u64 = 1 << 53;

/// Reason why bytes are not canonical JSON.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum JsonFault {
    /// Not JSON at all.
    #[error("{0}")]
    Syntax(String),
    /// JSON, but not in the canonical form, or over its limits.
    #[error("{0}")]
    Form(String),
}

/// Writes a value in its canonical form.
pub fn to_bytes(value: &Value) -> Result<Vec<u8>, JsonFault> {
    let mut out = String::new();
    write_value(value, 0, &mut out)?;
    Ok(out.into_bytes())
}

/// Parses canonical JSON; refuses any other spelling of the same value.
pub fn from_bytes(bytes: &[u8]) -> Result<Value, JsonFault> {
    let depth = check_text(bytes)?;
    if depth > MAX_DEPTH {
        return Err(JsonFault::Form(format!("nested deeper than {MAX_DEPTH} levels")));
    }
    let value = parse(bytes)?;
    let canonical = to_bytes(&value)?;
    if canonical != bytes {
        let at = canonical.iter().zip(bytes).take_while(|(a, b)| a == b).count();
        return Err(JsonFault::Form(format!("it departs from the canonical form at its byte {at}")));
    }
    Ok(value)
}

fn parse(bytes: &[u8]) -> Result<Value, JsonFault> {
    serde_json::from_slice(bytes).map_err(|e| JsonFault::Syntax(e.to_string()))
}

/// Checks that bytes are JSON at any depth, without recursion, and returns the depth: each array and
/// object is parsed by itself, what it holds replaced by a number.
fn check_text(bytes: &[u8]) -> Result<usize, JsonFault> {
    let text = std::str::from_utf8(bytes).map_err(|e| JsonFault::Syntax(e.to_string()))?.as_bytes();
    let mut open = vec![Vec::new()];
    let (mut deepest, mut in_string, mut escaped) = (0, false, false);
    for &byte in text {
        if !in_string && matches!(byte, b'[' | b'{') {
            open.push(Vec::new());
            deepest = deepest.max(open.len() - 1);
        }
        open.last_mut().expect("the outermost stays open").push(byte);
        if in_string {
            in_string = escaped || byte != b'"';
            escaped = !escaped && byte == b'\\';
        } else if byte == b'"' {
            in_string = true;
        } else if matches!(byte, b']' | b'}') && open.len() > 1 {
            parse(&open.pop().expect("there are two at least"))?;
            open.last_mut().expect("the outermost stays open").extend(b" 0 ");
        }
    }
    if open.len() > 1 {
        return Err(JsonFault::Syntax(format!("{} arrays or objects are not closed", open.len() - 1)));
    }
    parse(&open[0])?;
    Ok(deepest)
}

fn write_value(value: &Value, depth: usize, out: &mut String) -> Result<(), JsonFault> {
    let nested = matches!(value, Value::Array(_) | Value::Object(_));
    if nested && depth >= MAX_DEPTH {
        return Err(JsonFault::Form(format!("nested deeper than {MAX_DEPTH} levels")));
    }
    match value {
        Value::Null => out.push_str("null"),
        Value::Bool(true) => out.push_str("true"),
        Value::Bool(false) => out.push_str("false"),
        Value::Number(number) => write_number(number, out)?,
        Value::String(text) => write_string(text, out),
        Value::Array(items) => {
            out.push('[');
            for (i, item) in items.iter().enumerate() {
                if i > 0 {
                    out.push(',');
                }
                write_value(item, depth + 1, out)?;
            }
            out.push(']');
        }
        Value::Object(members) => {
            let mut members: Vec<_> = members.iter().collect();
            members.sort_by(|a, b| a.0.encode_utf16().cmp(b.0.encode_utf16()));
            out.push('{');
            for (i, (key, item)) in members.into_iter().enumerate() {
                if i > 0 {
                    out.push(',');
                }
                write_string(key, out);
                out.push(':');
                write_value(item, depth + 1, out)?;
            }
            out.push('}');
        }
    }
    Ok(())
}

fn write_string(text: &str, out: &mut String) {
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\u{8}' => out.push_str("\\b"),
            '\t' => out.push_str("\\t"),
            '\n' => out.push_str("\\n"),
            '\u{c}' => out.push_str("\\f"),
            '\r' => out.push_str("\\r"),
            c if c < ' ' => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
}

fn write_number(number: &Number, out: &mut String) -> Result<(), JsonFault> {
    let value = number.as_f64().filter(|v| v.is_finite());
    let value = value.ok_or_else(|| JsonFault::Form(format!("number {number} is not finite")))?;
    let integer = number.as_u64().or(number.as_i64().map(i64::unsigned_abs));
    let over = integer.is_some_and(|i| i > MAX_INTEGER)
        || (value.fract() == 0.0 && value.abs() > MAX_INTEGER as f64);
    if over {
        return Err(JsonFault::Form(format!("integer {number} is over 2^53 in magnitude")));
    }
    out.push_str(&format_double(value));
    Ok(())
}

/// A finite double as ECMAScript writes it (ECMA-262, Number::toString): of the fewest digits that
/// read back as the same double the nearest to it, of two equally near the even; -0 as 0. The
/// standard library's `{:e}` parts ties otherwise, hence the crate.
fn format_double(value: f64) -> String {
    ryu_js::Buffer::new().format_finite(value).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::excessive_precision, reason = "exact values, so that the ties can be seen")]
    fn doubles_are_written_as_ecmascript_writes_them() {
        let table = [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-1.5, "-1.5"),
            (0.1, "0.1"),
            (1e-6, "0.000001"),
            (1e-7, "1e-7"),
            (1.25e-7, "1.25e-7"),
            (123456.789, "123456.789"),
            (5e-324, "5e-324"),
            (9007199254740992.0, "9007199254740992"),
            (0.30000000000000004, "0.30000000000000004"),
            (1e21, "1e+21"),
            (1.5e300, "1.5e+300"),
            (1e20, "100000000000000000000"),
            // Ties between the shortest: the even digit wins.
            (545.67999267578125, "545.6799926757812"),
            (1.0 / 33_554_432.0, "2.9802322387695312e-8"),
            (2053053597086840.25, "2053053597086840.2"),
        ];
        for (value, text) in table {
            assert_eq!(format_double(value), text);
        }
    }

    #[test]
    fn other_spellings_of_a_value_are_refused() {
        from_bytes(br#"{"a":[1,2.5,null,true,"\n\u0001"],"b":{}}"#).expect("it is canonical");
        let forms: [&[u8]; 14] = [
            br#"{"a": 1}"#,
            br#"{"a":1}
"#,
            br#"{"b":1,"a":2}"#,
            br#"{"a":1,"a":2}"#,
            br#"{"a":1.0}"#,
            br#"{"a":1e0}"#,
            br#"{"a":-0}"#,
            br#"{"a":0.10}"#,
            br#"{"a":9007199254740993}"#,
            br#"{"a":1e300}"#,
            br#"{"a":"\u0041"}"#,
            br#"{"a":"\/"}"#,
            br#"{"a":"\u001F"}"#,
            br#"{"a":"\u000a"}"#,
        ];
        for form in forms {
            let fault = from_bytes(form).expect_err(&String::from_utf8_lossy(form));
            assert!(matches!(fault, JsonFault::Form(_)), "{fault:?}");
        }
        let broken: [&[u8]; 5] = [b"", b"{", b"{\"a\":1}x", b"{\"a\":NaN}", b"{\"a\":\"\xff\"}"];
        for bytes in broken {
            assert!(matches!(from_bytes(bytes), Err(JsonFault::Syntax(_))));
        }
    }

    #[test]
    fn nesting_past_the_limit_is_refused() {
        let nested = |depth: usize| format!("{}{}", "[".repeat(depth), "]".repeat(depth));
        from_bytes(nested(MAX_DEPTH).as_bytes()).expect("the limit itself is allowed");
        from_bytes(nested(MAX_DEPTH + 1).as_bytes()).expect_err("one over the limit");
        let deepest = if cfg!(miri) { 1_000 } else { 100_000 };
        for depth in [MAX_DEPTH + 1, 127, 128, deepest] {
            let fault = from_bytes(nested(depth).as_bytes()).expect_err("over the limit, without overflow");
            assert!(matches!(fault, JsonFault::Form(_)), "{depth}: {fault}");
        }
    }

    #[test]
    fn what_is_not_json_is_found_before_what_is_not_canonical() {
        let deep = |inner: &str| format!("{}{inner}{}", "[ ".repeat(200), "]".repeat(200));
        for inner in ["1e400", "\"\\ud800\"", "1[]", "{[]:1}", "[}", "]", "[", "\"", "\"[]", "{\"a\" 1}"] {
            let fault = from_bytes(deep(inner).as_bytes()).expect_err(inner);
            assert!(matches!(fault, JsonFault::Syntax(_)), "{inner}: {fault}");
        }
        let fault = from_bytes(deep("\"]\\\"[\"").as_bytes()).expect_err("deep");
        assert!(matches!(fault, JsonFault::Form(_)), "{fault}");
    }

    #[test]
    fn keys_are_sorted_by_utf16_units() {
        // U+10000 is D800 DC00 in UTF-16: before U+FFFF there, behind it in UTF-8.
        let text = "{\"\u{10000}\":1,\"\u{ffff}\":2}";
        from_bytes(text.as_bytes()).expect("it is sorted");
        let swapped = "{\"\u{ffff}\":2,\"\u{10000}\":1}";
        from_bytes(swapped.as_bytes()).expect_err("it is not sorted");
    }
}
