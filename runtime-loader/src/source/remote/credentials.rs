//! An answer that holds credentials of s3, checked before `object_store` reads it: that puts texts of the answer into
//! headers and URLs, and panics where they do not fit.
//!
//! - A token and the name of a role, from the service that a machine in the cloud has, are plain text. One line end
//!   behind it is left out.
//! - Everything else is JSON or XML. A line end within one of its texts is refused; between them it becomes a space.

use http::{Method, Uri};

use super::address::is_private;

/// Where the service of a machine in the cloud tells which role it has.
const ROLE_PATH: &str = "/latest/meta-data/iam/security-credentials/";
const TOKEN_PATH: &str = "/latest/api/token";

/// What an answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Of the metadata service: one word, that becomes a header.
    Token,
    /// The name of a role, which becomes a part of a URL.
    Role,
    /// JSON or XML.
    Document,
}

impl Kind {
    /// By the request.
    pub(super) fn of(method: &Method, uri: &Uri) -> Kind {
        match *method {
            Method::PUT if uri.path().ends_with(TOKEN_PATH) => Kind::Token,
            Method::GET if uri.path().ends_with(ROLE_PATH) => Kind::Role,
            _ => Kind::Document,
        }
    }

    /// The answer as it may be read, or what was found.
    pub(super) fn check(self, mut bytes: Vec<u8>) -> Result<Vec<u8>, &'static str> {
        match self {
            Kind::Token => match word(&bytes) {
                token if is_word(token) => Ok(token.to_vec()),
                _ => Err("a token that is not one line of visible ASCII characters"),
            },
            Kind::Role => match word(&bytes) {
                role if !role.is_empty() && role.iter().all(is_of_a_role) => Ok(role.to_vec()),
                _ => Err("a name of a role with other characters than letters, digits and +=,.@_-"),
            },
            Kind::Document if !fits_headers(&bytes) => Err("credentials with bytes that no header can hold"),
            Kind::Document if has_broken_text(&bytes) => Err("credentials with a line end within a text"),
            Kind::Document => {
                let spaces = bytes.iter_mut().filter(|byte| byte.is_ascii_whitespace());
                spaces.for_each(|space| *space = b' ');
                Ok(bytes)
            }
        }
    }
}

/// Whether an endpoint is one of this machine or of its own network, where no proxy has a place.
pub(super) fn is_near(uri: &Uri) -> bool {
    let host = uri.host().unwrap_or_default().trim_matches(['[', ']']).to_ascii_lowercase();
    match host.parse() {
        Ok(address) => is_private(address),
        Err(_) => host == "localhost" || host.ends_with(".localhost"),
    }
}

/// Whether this fits a header, whole.
pub(super) fn is_word(bytes: &[u8]) -> bool {
    !bytes.is_empty() && bytes.iter().all(u8::is_ascii_graphic)
}

/// Without one line end behind it.
fn word(bytes: &[u8]) -> &[u8] {
    let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    bytes.strip_suffix(b"\r").unwrap_or(bytes)
}

/// By the rules of IAM.
fn is_of_a_role(byte: &u8) -> bool {
    byte.is_ascii_alphanumeric() || b"+=,.@_-".contains(byte)
}

/// Whether every text in an answer of JSON or XML may become a header, line ends aside. No token has an escape but that
/// of a slash.
fn fits_headers(bytes: &[u8]) -> bool {
    let escaped = bytes.windows(2).any(|pair| pair[0] == b'\\' && !matches!(pair[1], b'/' | b'"'));
    let plain = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    !escaped && bytes.iter().all(plain) && !bytes.windows(2).any(|pair| pair == b"&#")
}

/// Whether a line end lies within a string of JSON, or within a text of XML.
fn has_broken_text(bytes: &[u8]) -> bool {
    let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
    let mut texts: Box<dyn Iterator<Item = &[u8]>> = match bytes.trim_ascii_start().first() {
        Some(b'<') => Box::new(bytes.split(|byte| matches!(byte, b'<' | b'>')).step_by(2)),
        _ => Box::new(bytes.split(|byte| *byte == b'"').skip(1).step_by(2)),
    };
    texts.any(|text| text.iter().any(is_end) && !text.trim_ascii().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(kind: Kind, text: &str) -> Result<String, &'static str> {
        kind.check(text.as_bytes().to_vec()).map(|bytes| String::from_utf8(bytes).expect("it was ASCII"))
    }

    #[test]
    fn plain_answers_lose_one_line_end_and_nothing_else_of_them_is_mended() {
        for end in ["", "\n", "\r\n"] {
            assert_eq!(check(Kind::Token, &format!("AQAE<t>==`{end}")).as_deref(), Ok("AQAE<t>==`"));
            assert_eq!(check(Kind::Role, &format!("a+=,.@_-Z9{end}")).as_deref(), Ok("a+=,.@_-Z9"));
        }
        for odd in ["", "\n", "a\n\n", "a\nb", "\na", "a b", "a\t", "a\r\r\n", "a\u{0}", "a\u{e9}"] {
            assert!(check(Kind::Token, odd).is_err() && check(Kind::Role, odd).is_err(), "{odd:?}");
        }
        for odd in ["a<b", "a`b", "a/b", "a?b", "a%20b", "a#"] {
            assert!(check(Kind::Role, odd).is_err(), "{odd:?}");
        }
    }

    #[test]
    fn a_line_end_within_a_text_is_refused_and_between_texts_it_is_a_space() {
        for good in [
            "{\r\n  \"Token\": \"a/b\",\n\t\"Code\": \"Success\"\n}\n",
            "<?xml version=\"1.0\"?>\n<A>\n  <SessionToken>a b</SessionToken>\r\n</A>\n",
        ] {
            let spaced = good.replace(['\n', '\r', '\t'], " ");
            assert_eq!(check(Kind::Document, good), Ok(spaced), "{good:?}");
        }
        for bad in [
            "{\"Token\": \"a\n\"}",
            "{\"Token\": \"a\rb\"}",
            "<A><SessionToken>a\nb</SessionToken></A>",
            "<A><SessionToken>a\r</SessionToken></A>",
            "\n<A><AccessKeyId>\na</AccessKeyId></A>",
        ] {
            assert_eq!(
                check(Kind::Document, bad),
                Err("credentials with a line end within a text"),
                "{bad:?}"
            );
        }
        for bad in ["{\"Token\": \"a\\n\"}", "<A>a&#10;</A>", "{\"Token\": \"a\u{1}\"}", "<A>\u{e9}</A>"] {
            let no_header = "credentials with bytes that no header can hold";
            assert_eq!(check(Kind::Document, bad), Err(no_header), "{bad:?}");
        }
    }

    #[test]
    fn what_is_asked_for_says_what_kind_of_answer_comes() {
        for (method, uri, kind) in [
            (Method::PUT, "http://169.254.169.254/latest/api/token", Kind::Token),
            (Method::GET, "http://h:1/x/latest/meta-data/iam/security-credentials/", Kind::Role),
            (Method::GET, "http://h/latest/meta-data/iam/security-credentials/role", Kind::Document),
            (Method::GET, "http://169.254.170.2/v2/credentials/id", Kind::Document),
            (Method::POST, "https://sts.eu-west-1.amazonaws.com/?Action=A", Kind::Document),
        ] {
            assert_eq!(Kind::of(&method, &Uri::from_static(uri)), kind, "{uri}");
        }
    }

    #[test]
    fn endpoints_of_this_machine_and_its_network_are_near() {
        for (uri, near) in [
            ("http://169.254.169.254/latest", true),
            ("http://169.254.170.2/v2", true),
            ("http://127.0.0.1:80/", true),
            ("http://[::1]/", true),
            ("http://[fd00:ec2::254]/", true),
            ("http://10.0.0.1/", true),
            ("http://LocalHost:9/", true),
            ("https://sts.amazonaws.com/", false),
            ("https://8.8.8.8/", false),
        ] {
            assert_eq!(is_near(&Uri::from_static(uri)), near, "{uri}");
        }
    }
}
