//! What the environment says of s3, checked before anything relies on it: `object_store` takes for granted that a value
//! fits a header, a host or a URL. Variables beside those of [`VARIABLES`] are not read.
//!
//! No message repeats a value, which may be a secret that was put into the wrong variable.

use std::ffi::{OsStr, OsString};
use std::io::Read;
use std::path::Path;

use flb_files::OpenError;
use url::Url;

use super::credentials::is_word;

/// Of a file with a token.
const MAX_TOKEN_BYTES: u64 = 64 << 10;

/// A variable whose value cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("environment variable {variable}: found {found}, expected {expected}")]
pub struct EnvironmentError {
    /// Name of the variable.
    pub variable: &'static str,
    /// Fault of the value, without the value.
    pub found: String,
    /// Values that fit.
    pub expected: &'static str,
}

/// What a value must be.
#[derive(Debug, Clone, Copy)]
enum Form {
    /// Fits a header.
    Word,
    /// Any text of one line.
    Line,
    /// Fits the name of a host.
    Region,
    /// `http` or `https`, a host, perhaps a port and a path.
    Endpoint,
    /// A path from the root of a host.
    RootPath,
    Switch,
    /// A switch, or the word "requester".
    Payer,
    /// How an object is encrypted by its server.
    Encryption,
    /// 32 bytes in base64.
    Key,
}

/// Of two that mean the same the later one holds. Empty ones count as unset.
const VARIABLES: [(&str, Form); 26] = [
    ("AWS_ACCESS_KEY_ID", Form::Word),
    ("AWS_SECRET_ACCESS_KEY", Form::Line),
    ("AWS_SESSION_TOKEN", Form::Word),
    ("AWS_DEFAULT_REGION", Form::Region),
    ("AWS_REGION", Form::Region),
    ("AWS_ENDPOINT_URL", Form::Endpoint),
    ("AWS_ENDPOINT", Form::Endpoint),
    ("AWS_ENDPOINT_URL_S3", Form::Endpoint),
    ("AWS_ENDPOINT_URL_STS", Form::Endpoint),
    ("AWS_METADATA_ENDPOINT", Form::Endpoint),
    ("AWS_CONTAINER_CREDENTIALS_FULL_URI", Form::Endpoint),
    ("AWS_CONTAINER_CREDENTIALS_RELATIVE_URI", Form::RootPath),
    ("AWS_CONTAINER_AUTHORIZATION_TOKEN_FILE", Form::Line),
    ("AWS_WEB_IDENTITY_TOKEN_FILE", Form::Line),
    ("AWS_ROLE_ARN", Form::Word),
    ("AWS_ROLE_SESSION_NAME", Form::Word),
    ("AWS_ALLOW_HTTP", Form::Switch),
    ("AWS_SKIP_SIGNATURE", Form::Switch),
    ("AWS_UNSIGNED_PAYLOAD", Form::Switch),
    ("AWS_VIRTUAL_HOSTED_STYLE_REQUEST", Form::Switch),
    ("AWS_S3_EXPRESS", Form::Switch),
    ("AWS_IMDSV1_FALLBACK", Form::Switch),
    ("AWS_REQUEST_PAYER", Form::Payer),
    ("AWS_SERVER_SIDE_ENCRYPTION", Form::Encryption),
    ("AWS_SSE_CUSTOMER_KEY_BASE64", Form::Key),
    ("AWS_SSE_KMS_KEY_ID", Form::Word),
];

/// The variables that are set, with values that can be used, in the order in which they are to be set.
pub(super) fn settings(
    environment: impl IntoIterator<Item = (OsString, OsString)>,
) -> Result<Vec<(&'static str, String)>, EnvironmentError> {
    let environment: std::collections::HashMap<OsString, OsString> = environment.into_iter().collect();
    let value = |name: &str| environment.get(OsStr::new(name)).filter(|value| !value.is_empty());
    let mut settings = Vec::new();
    for (variable, form) in VARIABLES {
        let Some(value) = value(variable) else { continue };
        let refuse = |(found, expected)| EnvironmentError { variable, found, expected };
        let text = value.to_str().ok_or_else(|| refuse(("bytes that are no UTF-8".to_owned(), "text")))?;
        settings.push((variable, form.read(text).map_err(refuse)?));
    }
    for [a, b] in
        [["AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"], ["AWS_SECRET_ACCESS_KEY", "AWS_ACCESS_KEY_ID"]]
    {
        if value(a).is_some() && value(b).is_none() {
            let found = format!("nothing, beside {a}");
            return Err(EnvironmentError { variable: b, found, expected: "both or neither" });
        }
    }
    plain_http_is_allowed(&settings)?;
    token_file_is_sound(&settings)?;
    Ok(settings)
}

/// The file with a token, where the choice of `object_store` falls on it, is looked at before that reads it whole: its
/// text becomes a header or a part of a query.
fn token_file_is_sound(settings: &[(&'static str, String)]) -> Result<(), EnvironmentError> {
    const WEB: &str = "AWS_WEB_IDENTITY_TOKEN_FILE";
    const CONTAINER: &str = "AWS_CONTAINER_AUTHORIZATION_TOKEN_FILE";
    let of = |wanted: &str| settings.iter().find(|(name, _)| *name == wanted).map(|(_, value)| value);
    if of("AWS_ACCESS_KEY_ID").is_some() {
        return Ok(());
    }
    let (variable, path) = match (of(WEB), of(CONTAINER)) {
        (Some(path), _) if of("AWS_ROLE_ARN").is_some() => (WEB, path),
        _ if of("AWS_CONTAINER_CREDENTIALS_RELATIVE_URI").is_some() => return Ok(()),
        (_, Some(path)) if of("AWS_CONTAINER_CREDENTIALS_FULL_URI").is_some() => (CONTAINER, path),
        _ => return Ok(()),
    };
    let expected = match variable {
        WEB => "a file with a token, 65536 bytes of text at most",
        _ => "a file with a token of visible ASCII characters and no line end, 65536 bytes at most",
    };
    let refuse = |found: String| EnvironmentError { variable, found, expected };
    let token = token_of(Path::new(path)).map_err(refuse)?;
    if variable == CONTAINER && !is_word(&token) {
        return Err(refuse(match token.iter().position(|byte| !byte.is_ascii_graphic()) {
            Some(at) => format!("a file with {} at byte {}", kind_of(char::from(token[at])), at + 1),
            None => "an empty file".to_owned(),
        }));
    }
    match str::from_utf8(&token) {
        Ok(_) => Ok(()),
        Err(_) => Err(refuse("a file that is no UTF-8".to_owned())),
    }
}

/// What a file holds, or what was found in its place.
fn token_of(path: &Path) -> Result<Vec<u8>, String> {
    let (file, _) = flb_files::open_regular(path).map_err(|error| match error {
        OpenError::Io { source, .. } => format!("no file that can be read ({})", source.kind()),
        OpenError::NotAFile { found } => found.to_owned(),
    })?;
    let mut token = Vec::new();
    let read = file.take(MAX_TOKEN_BYTES + 1).read_to_end(&mut token);
    read.map_err(|error| format!("no file that can be read ({})", error.kind()))?;
    match token.len() as u64 > MAX_TOKEN_BYTES {
        true => Err(format!("a file of more than {MAX_TOKEN_BYTES} bytes")),
        false => Ok(token),
    }
}

/// The values that no message may hold.
pub(super) fn secrets<'a>(settings: &'a [(&'static str, String)]) -> impl Iterator<Item = &'a str> {
    const SECRET: [&str; 4] =
        ["AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN", "AWS_SSE_CUSTOMER_KEY_BASE64"];
    settings.iter().filter(|(name, _)| SECRET.contains(name)).map(|(_, value)| value.as_str())
}

/// An endpoint of plain `http` sends what it is asked in the open, so it must be allowed by name.
fn plain_http_is_allowed(settings: &[(&'static str, String)]) -> Result<(), EnvironmentError> {
    let of = |wanted: &[&str]| settings.iter().rev().find(|(name, _)| wanted.contains(name));
    let used = of(&["AWS_ENDPOINT_URL_S3"]).or(of(&["AWS_ENDPOINT_URL", "AWS_ENDPOINT"]));
    let allowed = of(&["AWS_ALLOW_HTTP"]).is_some_and(|(_, value)| value == "true");
    match used.filter(|(_, url)| !allowed && url.starts_with("http:")) {
        None => Ok(()),
        Some((variable, _)) => Err(EnvironmentError {
            variable,
            found: "plain http".to_owned(),
            expected: "https, or AWS_ALLOW_HTTP=true beside it",
        }),
    }
}

impl Form {
    /// The value as it is used, or what was found and expected.
    fn read(self, text: &str) -> Result<String, (String, &'static str)> {
        let odd = |fits: fn(char) -> bool| {
            let (at, c) = text.chars().enumerate().find(|(_, c)| !fits(*c))?;
            Some(format!("{} at character {}", kind_of(c), at + 1))
        };
        let (found, expected) = match self {
            Form::Word => (odd(|c| c.is_ascii_graphic()), "visible ASCII characters"),
            Form::Line => (odd(|c| !c.is_control()), "one line of text"),
            Form::Region => (
                odd(|c| c.is_ascii_alphanumeric() || "-_".contains(c))
                    .or_else(|| (text.len() > 63).then(|| format!("{} characters", text.len()))),
                "the name of a region, such as eu-west-1",
            ),
            Form::Endpoint => {
                return endpoint(text).map_err(|found| (found, "a URL such as https://HOST:PORT"));
            }
            Form::RootPath => (
                odd(|c| c.is_ascii_graphic() && c != '#').or_else(|| {
                    (!text.starts_with('/') || http::Uri::try_from(text).is_err())
                        .then(|| "no such path".to_owned())
                }),
                "a path of a URL, from its /",
            ),
            Form::Payer if text == "requester" => (None, ""),
            Form::Encryption => (
                (!["AES256", "aws:kms", "aws:kms:dsse", "sse-c"].contains(&text))
                    .then(|| "another word".to_owned()),
                "AES256, aws:kms, aws:kms:dsse or sse-c",
            ),
            Form::Key => (
                odd(|c| c.is_ascii_alphanumeric() || "+/=".contains(c))
                    .or_else(|| (text.len() != 44).then(|| format!("{} characters", text.len()))),
                "32 bytes in base64, 44 characters",
            ),
            Form::Switch | Form::Payer => {
                return match text.to_ascii_lowercase().as_str() {
                    "1" | "true" | "on" | "yes" | "y" => Ok("true".to_owned()),
                    "0" | "false" | "off" | "no" | "n" => Ok("false".to_owned()),
                    _ => Err(("another word".to_owned(), "true or false")),
                };
            }
        };
        match found {
            Some(found) => Err((found, expected)),
            None => Ok(text.to_owned()),
        }
    }
}

/// A URL to which a path can be added, as it is to be used; or what is wrong with it.
fn endpoint(text: &str) -> Result<String, String> {
    if !text.contains("://") {
        return Err("no scheme".to_owned());
    }
    let url = Url::parse(text).map_err(|error| format!("no URL ({error})"))?;
    if !matches!(url.scheme(), "http" | "https") {
        return Err("a scheme that is neither http nor https".to_owned());
    }
    if !url.username().is_empty() || url.password().is_some() {
        return Err("a user or a password".to_owned());
    }
    if url.query().is_some() || url.fragment().is_some() {
        return Err("a query or a fragment".to_owned());
    }
    http::Uri::try_from(url.as_str()).map_err(|error| format!("no URL of HTTP ({error})"))?;
    // The form that was checked is the one that is used.
    Ok(url.as_str().trim_end_matches('/').to_owned())
}

fn kind_of(c: char) -> &'static str {
    match c {
        '\n' | '\r' => "a line break",
        ' ' | '\t' => "a space",
        c if c.is_control() => "a control character",
        c if c.is_ascii() => "a character that does not belong there",
        _ => "a character beyond ASCII",
    }
}

#[cfg(test)]
mod tests;
