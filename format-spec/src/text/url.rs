//! URLs in texts, however they are written: a message shows no more of one than scheme and host, for user, path, query
//! and fragment may each be a secret.

use std::borrow::Cow;

/// Schemes that make a URL of what follows even where no slash does.
const KNOWN: [&str; 5] = ["http", "https", "s3", "gs", "ftp"];
/// What stands in place of what is left out.
const LEFT_OUT: &str = "...";

/// Span of a URL in a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UrlSpan {
    /// Index of the URL's first byte.
    pub start: usize,
    /// Index of the first byte behind the scheme and the slashes: that of the user or host.
    pub rest: usize,
    /// Whether the URL names a scheme; if not, it begins with two slashes.
    pub has_scheme: bool,
}

/// Finds the first URL of a text: a scheme of two letters or more (one is a drive of Windows), a colon and slashes of
/// either kind, each perhaps percent-encoded; a known scheme and a colon; or two slashes at the beginning of a word.
pub fn find(text: &str) -> Option<UrlSpan> {
    let bytes = text.as_bytes();
    (0..bytes.len()).find_map(|at| with_scheme(text, at).or_else(|| without_scheme(text, at)))
}

/// The URL whose colon is at `at`.
fn with_scheme(text: &str, at: usize) -> Option<UrlSpan> {
    let bytes = text.as_bytes();
    let behind = at + length_of(&bytes[at..], b':', b"%3a")?;
    let is_of_scheme = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-.".contains(byte);
    let length = bytes[..at].iter().rev().take_while(|byte| is_of_scheme(byte)).count();
    let scheme = &text[at - length..at];
    let scheme = scheme.trim_start_matches(|c: char| !c.is_ascii_alphabetic());
    let rest = behind_slashes(bytes, behind);
    let is_known = KNOWN.iter().any(|known| scheme.eq_ignore_ascii_case(known));
    let is_url =
        scheme.len() > 1 && rest > behind || is_known && !bytes[rest..].first()?.is_ascii_whitespace();
    is_url.then_some(UrlSpan { start: at - scheme.len(), rest, has_scheme: true })
}

/// The URL whose two slashes begin at `at`.
fn without_scheme(text: &str, at: usize) -> Option<UrlSpan> {
    let bytes = text.as_bytes();
    if !matches!(bytes[at..], [b'/', b'/', ..] | [b'\\', b'\\', ..]) {
        return None;
    }
    let begins = match at.checked_sub(1).map(|before| bytes[before]) {
        None => true,
        // Behind the folder that a path starts in.
        Some(b'/') => bytes[at] == b'\\',
        Some(before) => !(before.is_ascii_alphanumeric() || before >= 0x80 || b"/\\:._-~".contains(&before)),
    };
    begins.then(|| UrlSpan { start: at, rest: behind_slashes(bytes, at), has_scheme: false })
}

/// Bytes of a sign, written plainly or percent-encoded, that a text begins with.
fn length_of(text: &[u8], plain: u8, encoded: &[u8]) -> Option<usize> {
    match text {
        [first, ..] if *first == plain => Some(1),
        _ => text.get(..encoded.len())?.eq_ignore_ascii_case(encoded).then_some(encoded.len()),
    }
}

fn behind_slashes(text: &[u8], mut at: usize) -> usize {
    let slash = |at: usize| {
        let text = &text[at..];
        length_of(text, b'/', b"%2f").or_else(|| length_of(text, b'\\', b"%5c"))
    };
    while let Some(length) = slash(at) {
        at += length;
    }
    at
}

/// Whether a reference to a file means to be a URL. A path that begins with two slashes does where it holds what may be
/// a user, a query or a fragment; without, it may be a share of Windows.
pub fn is_meant(reference: &str) -> bool {
    find(reference).is_some_and(|found| is_meant_at(reference, found))
}

fn is_meant_at(reference: &str, found: UrlSpan) -> bool {
    found.has_scheme || reference[found.rest..].contains(MARKS)
}

/// What sets users, queries and fragments off.
const MARKS: [char; 3] = ['@', '?', '#'];

/// A reference to a file as a message shows it: a URL as scheme and host, everything else as it is. It is for those who
/// know where the reference ends: a URL may hold blanks, quotes and all that ends one in a sentence.
pub fn shown_reference(reference: &str) -> Cow<'_, str> {
    let Some(found) = find(reference).filter(|found| is_meant_at(reference, *found)) else {
        return Cow::Borrowed(reference);
    };
    let rest = &reference[found.rest..];
    let host = host_of(rest);
    if host.is_some_and(|host| rest.len() == host.len() || rest[host.len()..] == *"/") {
        return Cow::Borrowed(reference);
    }
    let before = Some(&reference[..found.start]).filter(|before| !before.contains(MARKS)).unwrap_or(LEFT_OUT);
    let scheme = &reference[found.start..found.rest];
    Cow::Owned(match host {
        Some(host) => format!("{before}{scheme}{host}/{LEFT_OUT}"),
        None => format!("{before}{scheme}{LEFT_OUT}"),
    })
}

/// The lines of a message of a parser, which quotes lines of what it has read, each as [`shown_reference`].
pub fn shown_lines(message: &str) -> Cow<'_, str> {
    if message.split('\n').all(|line| matches!(shown_reference(line), Cow::Borrowed(_))) {
        return Cow::Borrowed(message);
    }
    Cow::Owned(message.split('\n').map(shown_reference).collect::<Vec<_>>().join("\n"))
}

/// The host and port that the rest of a URL begins with, if it is sure that they are: where an `@` follows anywhere,
/// all before it may be a password.
fn host_of(rest: &str) -> Option<&str> {
    let is_of_host = |c: char| c.is_ascii_alphanumeric() || ".-_[]:".contains(c);
    let host = &rest[..rest.find(|c| !is_of_host(c)).unwrap_or(rest.len())];
    let ends = rest[host.len()..].starts_with(['/', '\\', '?', '#']) || host.len() == rest.len();
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        Some(_) if !host.starts_with('[') => return None,
        _ => host,
    };
    let is_name = !name.is_empty() && (name.starts_with('[') || !name.contains(':'));
    (ends && is_name && !rest.contains('@')).then_some(host)
}

#[cfg(test)]
mod tests;
