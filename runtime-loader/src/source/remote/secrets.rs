//! What no message may hold: values of a URL's query, tokens, keys and signatures. A server knows what it was sent, and
//! may send it back in any header that a message quotes.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Mutex, PoisonError};

use http::HeaderMap;
use http::header::AUTHORIZATION;

/// Shorter ones are in any text.
const MIN_BYTES: usize = 4;
/// Of those that were learned from requests; the oldest goes first.
const MAX_LEARNED: usize = 256;
/// What stands in place of one.
const HIDDEN: &[u8] = b"...";
/// Headers of requests whose values are secrets.
const HEADERS: [&str; 2] = ["x-amz-security-token", "x-amz-server-side-encryption-customer-key"];

/// Texts to be hidden, in lower case: hosts are written so, whatever was sent.
#[derive(Default)]
pub(super) struct Secrets {
    known: Vec<Vec<u8>>,
    /// From requests.
    learned: Mutex<VecDeque<Vec<u8>>>,
}

impl Secrets {
    /// Of a URL's query and of values beside it.
    pub(super) fn of<'a>(query: Option<&str>, values: impl IntoIterator<Item = &'a str>) -> Secrets {
        let known = values.into_iter().flat_map(forms_of).chain(values_of(query)).collect();
        Secrets { known, learned: Mutex::default() }
    }

    /// What a request tells its server.
    pub(super) fn learn(&self, query: Option<&str>, headers: &HeaderMap) {
        let text = |name: &str| headers.get(name).and_then(|value| value.to_str().ok());
        let signed = text(AUTHORIZATION.as_str());
        let signature = signed.and_then(|value| Some(value.rsplit_once("Signature=")?.1));
        let of_headers = HEADERS.into_iter().filter_map(text).chain(signature).chain(signed.and_then(key_id));
        let mut learned = self.learned.lock().unwrap_or_else(PoisonError::into_inner);
        for value in of_headers.flat_map(forms_of).chain(values_of(query)) {
            if !self.known.contains(&value) && !learned.contains(&value) {
                learned.push_back(value);
            }
        }
        let over = learned.len().saturating_sub(MAX_LEARNED);
        learned.drain(..over);
    }

    /// The first `most` bytes of a server's text without them, written plainly or percent-encoded. One that goes on
    /// behind them is left out, too.
    pub(super) fn hide(&self, text: &[u8], most: usize) -> Vec<u8> {
        let learned = self.learned.lock().unwrap_or_else(PoisonError::into_inner);
        let all = || self.known.iter().chain(learned.iter());
        let longest = all().map(Vec::len).max().unwrap_or(0);
        // One that is percent-encoded is three times as long.
        let text = &text[..text.len().min(most.saturating_add(3 * longest))];
        let hidden = covered(text, all());
        let without = |end: usize| {
            let mut shown = Vec::new();
            for (i, byte) in text[..end].iter().enumerate() {
                match hidden[i] {
                    false => shown.push(*byte),
                    true if i == 0 || !hidden[i - 1] => shown.extend(HIDDEN),
                    true => {}
                }
            }
            shown
        };
        match covered(&decoded(&without(text.len())), all()).contains(&true) {
            true => HIDDEN.to_vec(),
            // What comes behind may be the beginning of one that goes on further than was looked.
            false => without(text.len().min(most)),
        }
    }
}

/// Never what they are.
impl fmt::Debug for Secrets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secrets(..)")
    }
}

/// Which bytes of a text belong to one of them.
fn covered<'a>(text: &[u8], secrets: impl Iterator<Item = &'a Vec<u8>>) -> Vec<bool> {
    let text = text.to_ascii_lowercase();
    let mut covered = vec![false; text.len()];
    for secret in secrets {
        for (at, _) in text.windows(secret.len()).enumerate().filter(|(_, window)| window == secret) {
            covered[at..at + secret.len()].fill(true);
        }
    }
    covered
}

/// The id of the key that signed a request, which a service may have given:
/// `Credential=ID/date/region/service/aws4_request,`.
fn key_id(authorization: &str) -> Option<&str> {
    let (_, credential) = authorization.split_once("Credential=")?;
    credential.split(", ").next()?.rsplitn(5, '/').nth(4)
}

/// A value as it is compared: in lower case, and also without the blanks around it, which a header loses.
fn forms_of(value: &str) -> impl Iterator<Item = Vec<u8>> {
    compared(value.as_bytes()).into_iter()
}

fn compared(value: &[u8]) -> Vec<Vec<u8>> {
    let mut forms = vec![value.to_ascii_lowercase(), value.trim_ascii().to_ascii_lowercase()];
    forms.dedup();
    forms.retain(|form| form.len() >= MIN_BYTES);
    forms
}

/// The values of a query, as they are written and as they are meant; of a part without a name all of it.
fn values_of(query: Option<&str>) -> impl Iterator<Item = Vec<u8>> {
    let parts = query.unwrap_or_default().split('&');
    let values = parts.map(|part| part.split_once('=').map_or(part, |(_, value)| value));
    let forms = values.flat_map(|value| {
        let raw = value.as_bytes().to_ascii_lowercase();
        let plus: Vec<u8> = raw.iter().map(|byte| if *byte == b'+' { b' ' } else { *byte }).collect();
        [decoded(&raw), decoded(&plus), raw]
    });
    forms.flat_map(|form| compared(&form))
}

/// Without percent-encoding (RFC 3986, section 2.1).
fn decoded(text: &[u8]) -> Vec<u8> {
    let digit = |byte: Option<&u8>| byte.and_then(|byte| char::from(*byte).to_digit(16));
    let (mut plain, mut at) = (Vec::with_capacity(text.len()), 0);
    while let Some(byte) = text.get(at) {
        match (byte, digit(text.get(at + 1)), digit(text.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                plain.push((high * 16 + low) as u8);
                at += 3;
            }
            _ => {
                plain.push(*byte);
                at += 1;
            }
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use http::HeaderValue;

    use super::*;

    fn hide(secrets: &Secrets, text: &str) -> String {
        String::from_utf8(secrets.hide(text.as_bytes(), 1000)).expect("it was text")
    }

    #[test]
    fn values_of_a_query_are_hidden_as_written_as_meant_and_in_any_coding() {
        let secrets =
            Secrets::of(Some("a=abc&sig=c0ff%2Fee%3D&x=one+two&bare&b=%20blank+&c=abc+"), ["AKIAKEY"]);
        for (text, shown) in [
            ("bytes 0-9/10", "bytes 0-9/10"),
            ("abc", "abc"),
            ("xc0ff/ee=y", "x...y"),
            ("xc0ff%2Fee%3Dy", "x...y"),
            ("xc0ff%2fee%3dy", "x...y"),
            ("C0FF/EE=C0FF/EE=", "..."),
            ("one two, one+two, bare", "..., ..., ..."),
            ("akiakey", "..."),
            ("/%63%30ff/ee=/", "..."),
            ("(blank)(a blank)(abc )", "(...)(a ...)(...)"),
        ] {
            assert_eq!(hide(&secrets, text), shown, "{text}");
        }
        assert_eq!(hide(&Secrets::of(None, [""]), "a%41"), "a%41");
    }

    #[test]
    fn tokens_and_signatures_of_requests_are_hidden_too_and_the_oldest_forgotten() {
        let secrets = Secrets::of(None, []);
        let request = |token: String| {
            let mut headers = HeaderMap::new();
            let sign = format!("AWS4-HMAC-SHA256 Credential=k/2026, Signature={token}5160");
            headers.insert(AUTHORIZATION, HeaderValue::from_str(&sign).expect("a header"));
            headers.insert(HEADERS[0], HeaderValue::from_str(&token).expect("a header"));
            secrets.learn(Some("v=query"), &headers);
        };
        request("token".to_owned());
        assert_eq!(hide(&secrets, "a token5160 b Token c QUERY"), "a ... b ... c ...");
        let mut headers = HeaderMap::new();
        let sign =
            "AWS4-HMAC-SHA256 Credential=AKIA/IO/20260101/eu/s3/aws4_request, SignedHeaders=a, Signature=f";
        headers.insert(AUTHORIZATION, HeaderValue::from_static(sign));
        secrets.learn(None, &headers);
        assert_eq!(hide(&secrets, "of akia/io, eu"), "of ..., eu", "a service may have given it");
        (0..MAX_LEARNED).for_each(|i| request(format!("other{i}")));
        assert_eq!(secrets.learned.lock().expect("no panic").len(), MAX_LEARNED);
        assert_eq!(hide(&secrets, &format!("other{}.", MAX_LEARNED - 1)), "....");
        assert!(!format!("{secrets:?}").contains("other"));
    }

    #[test]
    fn one_at_the_edge_of_what_is_shown_is_hidden_whole() {
        let secrets = Secrets::of(Some("s=c0ffee5ec2e7"), []);
        let text = format!("{}c0ffee5ec2e7 and more of it", "x".repeat(99));
        assert!(!String::from_utf8(secrets.hide(text.as_bytes(), 100)).expect("text").contains("c0f"));
        // What is hidden before makes room for what comes behind.
        for count in 0..100 {
            let text = "c0ffee5ec2e7, ".repeat(count) + "c0ffee5ec2e7";
            let shown = String::from_utf8(secrets.hide(text.as_bytes(), 100)).expect("text");
            assert!(!shown.contains("c0f") && shown.len() <= 100, "{shown}");
        }
    }
}
