//! Text from outside made harmless: nothing steers the terminal, nothing is invisible, no secret is shown.

use std::borrow::Cow;
use std::env;
use std::sync::OnceLock;

use flb_format::text::{escaped, is_hidden, url};
use percent_encoding::percent_decode_str;
use serde_json::Value;

/// Variables whose values are secrets.
const SECRET_VARIABLES: [&str; 3] =
    ["AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN", "AWS_CONTAINER_AUTHORIZATION_TOKEN"];
/// In place of what is left out.
const LEFT_OUT: &str = "...";
/// Shorter ones than this are no secrets, and would be found everywhere.
const MIN_SECRET_BYTES: usize = 4;
/// Shorter pieces of a query or a password stay where they stand alone.
const MIN_PIECE_BYTES: usize = 6;

/// A text as it may be printed: hidden characters but line breaks as `\u{...}`, no secret, no query of a URL.
pub(crate) fn shown(text: &str) -> String {
    let mut text = without_secrets(text, secrets());
    for word in broken_words() {
        text = text.replace(word.as_str(), &one_line(word));
    }
    escaped(&text, |c| c == '\n').into_owned()
}

/// Words of the command line with line breaks: names of files, mostly, which are one line each.
fn broken_words() -> &'static [String] {
    static WORDS: OnceLock<Vec<String>> = OnceLock::new();
    WORDS.get_or_init(|| words().filter(|word| word.trim().contains('\n')).collect())
}

fn words() -> impl Iterator<Item = String> {
    env::args_os().map(|word| word.to_string_lossy().into_owned())
}

/// The same as one line.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false)
}

/// A JSON text without secrets in its values, and with its hidden characters by number. Between its strings there are
/// none but line breaks; its keys and literals stay.
pub(crate) fn json(text: &str) -> String {
    json_without(text, secrets())
}

fn json_without(text: &str, secrets: &[String]) -> String {
    let mut clean = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find('"') {
        let token = &rest[start..start + string_length(&rest[start..])];
        let after = &rest[start + token.len()..];
        clean += &rest[..start];
        let is_key = after.starts_with(':');
        match serde_json::from_str::<String>(token) {
            Ok(value) if !is_key => clean += &Value::from(without_secrets(&value, secrets)).to_string(),
            _ => clean += token,
        }
        rest = after;
    }
    clean += rest;
    let mut units = [0; 2];
    let mut shown = String::with_capacity(clean.len());
    for c in clean.chars() {
        match c {
            c if c == '\n' || !is_hidden(c) => shown.push(c),
            c => c.encode_utf16(&mut units).iter().for_each(|unit| shown += &format!("\\u{unit:04x}")),
        }
    }
    shown
}

/// Bytes of the JSON string that a text begins with, its marks included.
fn string_length(text: &str) -> usize {
    let mut is_escaped = false;
    let end = text.bytes().skip(1).position(|byte| {
        let is_end = byte == b'"' && !is_escaped;
        is_escaped = byte == b'\\' && !is_escaped;
        is_end
    });
    end.map_or(text.len(), |end| end + 2)
}

/// Secrets that this run was given, the longest first: queries and passwords in words of the command line, and keys in
/// the environment; as they were given, decoded, and as messages quote them.
fn secrets() -> &'static [String] {
    static SECRETS: OnceLock<Vec<String>> = OnceLock::new();
    SECRETS.get_or_init(|| {
        let values = SECRET_VARIABLES.iter().filter_map(env::var_os);
        let of_variables = values.map(|value| value.to_string_lossy().into_owned());
        forms(words().flat_map(|word| secrets_of(&word)).chain(of_variables))
    })
}

/// Every form in which a message may hold these.
fn forms(secrets: impl Iterator<Item = String>) -> Vec<String> {
    let mut forms: Vec<String> = Vec::new();
    for secret in secrets {
        let decoded = percent_decode_str(&secret).decode_utf8_lossy().into_owned();
        for form in [secret, decoded] {
            forms.push(form.escape_debug().to_string());
            forms.push(form);
        }
    }
    forms.retain(|form| form.len() >= MIN_SECRET_BYTES);
    forms.sort_by_key(|form| std::cmp::Reverse(form.len()));
    forms.dedup();
    forms
}

/// What a word may hold that is secret, if it is a URL, or means to be one: its query and fragment, its user and
/// password, and each long piece of them.
fn secrets_of(word: &str) -> Vec<String> {
    let Some(start) = url::find(word).map(|found| found.rest).or_else(|| word.find("//")) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let rest = &word[start..];
    let query = rest.split_once(['?', '#']).map(|(_, query)| query);
    // A password may hold what ends a host.
    let user = rest.rsplit_once('@').map(|(user, _)| user.trim_start_matches('/'));
    let password = user.and_then(|user| Some(user.split_once(':')?.1));
    for secret in query.into_iter().chain(user).chain(password) {
        // A message may quote, escape or cut it; what lies between its marks stays as it is.
        let is_mark = |c: char| !(c.is_alphanumeric() || "%+-._~".contains(c));
        let values = secret.split(['&', ';', '#']).filter_map(|pair| Some(pair.split_once('=')?.1));
        let pieces = secret.split(is_mark).chain(values).filter(|piece| piece.len() >= MIN_PIECE_BYTES);
        found.extend(pieces.chain([secret]).map(str::to_owned));
    }
    found
}

/// Leaves out these texts wherever they stand, and user, query and fragment of every URL. Where a URL from a file ends
/// is not known here: who quotes one leaves the rest of it out ([`url::shown_reference`]), and this is the net below.
fn without_secrets(text: &str, secrets: &[String]) -> String {
    let mut known = text.to_owned();
    for secret in secrets.iter().filter(|secret| text.contains(secret.as_str())) {
        known = known.replace(secret, LEFT_OUT);
    }
    let mut clean = String::with_capacity(known.len());
    let mut rest: &str = &known;
    while let Some(found) = url::find(rest) {
        let (before, url) = rest.split_at(found.rest);
        let is_end = |c: char| c.is_whitespace() || is_hidden(c) || "\"<>`".contains(c);
        let length = url.find(is_end).unwrap_or(url.len());
        // What ends a sentence's part is not the URL's.
        let (url, after) = url.split_at(url[..length].trim_end_matches([':', ',', ';']).len());
        let mark = url.find(['?', '#']);
        let address = &url[..mark.unwrap_or(url.len())];
        clean += before;
        // A password may hold slashes.
        match address.rfind('@') {
            Some(at) => clean.extend([LEFT_OUT, &address[at..]]),
            None => clean += address,
        }
        if let Some(mark) = mark {
            clean.extend([&url[mark..=mark], LEFT_OUT]);
        }
        rest = after;
    }
    clean + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_and_users_of_urls_are_left_out_of_any_text() {
        for (text, expected) in [
            ("a https://h/x?sig=S: gone", "a https://h/x?...: gone"),
            ("'https://h/x?sig=S'", "'https://h/x?..."),
            ("\"HTTPS://h/x?sig=S\" and ws://u:p@h/y?z", "\"HTTPS://h/x?...\" and ws://...@h/y?..."),
            ("s3://u:p@bucket/key", "s3://...@bucket/key"),
            ("https://h/x?... stays", "https://h/x?... stays"),
            ("http://a@http://b?c", "http://...@http://b?..."),
            ("is that so? http://h/x is plain", "is that so? http://h/x is plain"),
            ("http://", "http://"),
            ("at http:/h/x?sig=S3CR3T now", "at http:/h/x?... now"),
            ("at http://u:p/S3CR3T@h/x now", "at http://...@h/x now"),
            ("at http://h/x#S3CR3T now", "at http://h/x#... now"),
            ("at http:\\\\h\\x?sig=S3CR3T now", "at http:\\\\h\\x?... now"),
            ("'//u:S3CR3T@h/x?sig=S3CR3T'", "'//...@h/x?..."),
            ("ftp:/h/x?sig=S3CR3T", "ftp:/h/x?..."),
            ("http%3A//u:S3CR3T@h/x", "http%3A//...@h/x"),
            ("C:\\a?b, /a//b?c, tex@2x.png #0", "C:\\a?b, /a//b?c, tex@2x.png #0"),
        ] {
            assert_eq!(without_secrets(text, &[]), expected, "{text}");
        }
    }

    #[test]
    fn secrets_of_the_command_line_are_left_out_in_every_form() {
        for (word, text, expected) in [
            (
                "--light=https://user:pass@host/x.glb?sig=it's secret&v=(2)",
                "no file sig=it's secret&v=(2) of user:pass",
                "no file ... of ...",
            ),
            ("HTTPS://h/x?sig=S3CR3T", "the S3CR3T of sig=S3CR3T", "the ... of ..."),
            ("http:/h/x?sig=S3CR3T", "S3CR3T", "..."),
            ("http:x?sig=S3CR3T", "S3CR3T", "..."),
            ("//h/x?sig=S3CR3T", "S3CR3T", "..."),
            ("gs://h/x?S3CR3T", "S3CR3T", "..."),
            ("gs:/h/x?sig=S3CR3T", "S3CR3T", "..."),
            ("gs:\\h\\x?sig=S3CR3T", "S3CR3T", "..."),
            ("x+y:/h/x#S3CR3T", "S3CR3T", "..."),
            ("http://user:p/S3CR3T@h", "p/S3CR3T", "..."),
            ("http://user:p#S3CR3T@h/x", "p#S3CR3T", "..."),
            ("http://h/x?sig=S3%43R3T", "S3CR3T or S3%43R3T", "... or ..."),
            ("http://h/x?sig=S3C\"R3T", "S3C\"R3T or \"S3C\\\"R3T\"", "... or \"...\""),
            ("a=http:/h/x?sig=S3CR3T,card", "of S3CR3T", "of ..."),
            ("http://u:S3CR3T,@h/x", "http://u:S3CR3T", "http://u:..."),
            ("http://u:\\S3CR3T@h/x", "u/S3CR3T", "u/..."),
            ("http:/h/x?it's\"S3CR3T", "it's\\\"S3CR3T", "it's\\\"..."),
            ("http:/h/x?a\tb'\"S3CR3T", "a\\tb'\"S3CR3T", "a\\tb'\"..."),
            ("a path?with=questions", "a path?with=questions", "a path?with=questions"),
            ("C:\\plants\\oak.glb", "C:\\plants\\oak.glb", "C:\\plants\\oak.glb"),
        ] {
            assert_eq!(without_secrets(text, &forms(secrets_of(word).into_iter())), expected, "{word}");
        }
    }

    #[test]
    fn json_stays_json_whatever_is_left_out_of_it() {
        let value = serde_json::json!({
            "a\u{202e}": "b\u{9b}\u{e0041}\u{7f}\n\u{feff}",
            "valid": true,
            "url": "https://h/x?a\"b and \\",
            "list": ["https://h/x?true", "a\\\"", "keep valid"],
        });
        let secrets = forms(["true".to_owned(), "valid".to_owned()].into_iter());
        let text = json_without(&serde_json::to_string_pretty(&value).expect("it is JSON"), &secrets);
        assert!(text.chars().all(|c| c == '\n' || !is_hidden(c)), "{text}");
        let found: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(found["a\u{202e}"], value["a\u{202e}"]);
        assert_eq!((&found["valid"], &found["url"]), (&value["valid"], &"https://h/x?...\"b and \\".into()));
        assert_eq!(found["list"], serde_json::json!(["https://h/x?...", "a\\\"", "keep ..."]));
    }
}
