//! Text from outside made harmless: nothing steers the terminal, nothing is invisible, no secret is shown.

use std::borrow::Cow;
use std::env;
use std::sync::OnceLock;

use flb_format::text::is_hidden;

/// Variables whose values are secrets.
const SECRET_VARIABLES: [&str; 3] =
    ["AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN", "AWS_CONTAINER_AUTHORIZATION_TOKEN"];
/// Schemes of URLs that may hold a signature. Others are paths, or harmless.
const SCHEMES: [&str; 4] = ["http://", "https://", "s3://", "ftp://"];
/// In place of what is left out.
const LEFT_OUT: &str = "...";
/// Shorter ones than this are no secrets, and would be found everywhere.
const LEAST_SECRET_BYTES: usize = 4;

/// A text as it may be printed: hidden characters but line breaks as `\u{...}`, no secret, no query of a URL.
pub fn shown(text: &str) -> Cow<'_, str> {
    let mut text = without_secrets(text, secrets());
    for word in broken_words().iter().filter(|word| text.contains(word.as_str())).collect::<Vec<_>>() {
        text = Cow::Owned(text.replace(word.as_str(), &one_line(word)));
    }
    escape(text, |c| c == '\n')
}

/// Words of the command line with line breaks: names of files, mostly, which are one line each.
fn broken_words() -> &'static [String] {
    static WORDS: OnceLock<Vec<String>> = OnceLock::new();
    WORDS.get_or_init(|| words().filter(|word| word.contains('\n')).collect())
}

fn words() -> impl Iterator<Item = String> {
    env::args_os().map(|word| word.to_string_lossy().into_owned())
}

/// The same as one line.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escape(Cow::Borrowed(text), |_| false)
}

fn escape(text: Cow<'_, str>, stays: impl Fn(char) -> bool) -> Cow<'_, str> {
    let must_go = |c: char| is_hidden(c) && !stays(c);
    if !text.chars().any(must_go) {
        return text;
    }
    let mut clean = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            c if !must_go(c) => clean.push(c),
            '\n' | '\r' | '\t' => clean.extend(c.escape_default()),
            c => clean.extend(c.escape_unicode()),
        }
    }
    Cow::Owned(clean)
}

/// A JSON text with its hidden characters by number. Between its strings there are none but line breaks.
pub fn json(text: &str) -> String {
    let mut clean = String::with_capacity(text.len());
    let mut units = [0; 2];
    for c in without_secrets(text, secrets()).chars() {
        match c {
            c if c == '\n' || !is_hidden(c) => clean.push(c),
            c => c.encode_utf16(&mut units).iter().for_each(|unit| clean += &format!("\\u{unit:04x}")),
        }
    }
    clean
}

/// Secrets that this run was given: queries and passwords in words of the command line, and keys in the environment.
fn secrets() -> &'static [String] {
    static SECRETS: OnceLock<Vec<String>> = OnceLock::new();
    SECRETS.get_or_init(|| {
        let of_words = words().flat_map(|word| secrets_of(&word));
        let values = SECRET_VARIABLES.iter().filter_map(env::var_os);
        let of_variables = values.map(|value| value.to_string_lossy().into_owned());
        of_words.chain(of_variables).filter(|secret| secret.len() >= LEAST_SECRET_BYTES).collect()
    })
}

/// Query and user of each URL in a word.
fn secrets_of(word: &str) -> Vec<String> {
    let urls = SCHEMES.iter().flat_map(|scheme| word.match_indices(scheme).map(|(at, _)| at + scheme.len()));
    let of_url = |start: usize| {
        let rest = &word[start..];
        let query = rest.split_once('?').map(|(_, query)| query.to_owned());
        let host = rest.split(['/', '?', '#']).next().unwrap_or_default();
        [query, host.rsplit_once('@').map(|(user, _)| user.to_owned())]
    };
    urls.flat_map(of_url).flatten().collect()
}

/// Leaves out these texts wherever they stand, and user and query of every URL.
fn without_secrets<'t>(text: &'t str, secrets: &[String]) -> Cow<'t, str> {
    let mut known = Cow::Borrowed(text);
    for secret in secrets.iter().filter(|secret| text.contains(secret.as_str())) {
        known = Cow::Owned(known.replace(secret, LEFT_OUT));
    }
    if !SCHEMES.iter().any(|scheme| known.contains(scheme)) {
        return known;
    }
    let mut clean = String::with_capacity(known.len());
    let mut rest: &str = &known;
    while let Some(start) = next_url(rest) {
        let (before, url) = rest.split_at(start);
        let is_end = |c: char| c.is_whitespace() || is_hidden(c) || "\"<>`".contains(c);
        let (url, after) = url.split_at(url.find(is_end).unwrap_or(url.len()));
        let (address, query) =
            url.split_once('?').map_or((url, None), |(address, query)| (address, Some(query)));
        let host = address.split(['/', '#']).next().unwrap_or_default();
        clean += before;
        clean += host.rfind('@').map_or("", |_| LEFT_OUT);
        clean += &address[host.rfind('@').unwrap_or(0)..];
        if query.is_some() {
            clean.push('?');
            clean += LEFT_OUT;
        }
        rest = after;
    }
    Cow::Owned(clean + rest)
}

/// Where the next URL goes on behind its scheme.
fn next_url(text: &str) -> Option<usize> {
    SCHEMES.iter().filter_map(|scheme| text.find(scheme).map(|at| at + scheme.len())).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_and_users_of_urls_are_left_out_of_any_text() {
        for (text, expected) in [
            ("a https://h/x?sig=S: gone", "a https://h/x?... gone"),
            ("'https://h/x?sig=S'", "'https://h/x?..."),
            ("\"https://h/x?sig=S\" and http://u:p@h/y?z", "\"https://h/x?...\" and http://...@h/y?..."),
            ("s3://u:p@bucket/key", "s3://...@bucket/key"),
            ("https://h/x?... stays", "https://h/x?... stays"),
            ("http://a@http://b?c", "http://...@http://b?..."),
            ("is that so? http://h/x is plain", "is that so? http://h/x is plain"),
            ("http://", "http://"),
        ] {
            assert_eq!(without_secrets(text, &[]), expected, "{text}");
        }
    }

    #[test]
    fn secrets_of_the_command_line_are_left_out_whatever_stands_around_them() {
        let word = "--light=https://user:pass@host/x.glb?sig=it's secret&v=(2)";
        let secrets = secrets_of(word);
        assert_eq!(secrets, ["sig=it's secret&v=(2)", "user:pass"]);
        assert_eq!(
            without_secrets("no file sig=it's secret&v=(2) of user:pass", &secrets),
            "no file ... of ..."
        );
    }

    #[test]
    fn json_stays_json() {
        let value = serde_json::json!({"a\u{202e}": "b\u{9b}\u{e0041}\u{7f}\n\u{feff}"});
        let text = json(&serde_json::to_string_pretty(&value).expect("it is JSON"));
        assert!(text.chars().all(|c| c == '\n' || !is_hidden(c)), "{text}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).expect("it is JSON"), value);
    }
}
