use proptest::prelude::*;

use super::*;

fn read(variables: &[(&str, &str)]) -> Result<Vec<(&'static str, String)>, EnvironmentError> {
    settings(variables.iter().map(|(name, value)| ((*name).into(), (*value).into())))
}

#[track_caller]
fn refused(variables: &[(&str, &str)], says: &str) {
    assert_eq!(read(variables).expect_err(says).to_string(), says);
}

#[test]
fn values_that_object_store_would_fail_on_are_named_by_their_variable() {
    for (variable, value, found, expected) in [
        ("AWS_SESSION_TOKEN", "se\ncret", "a line break at character 3", "visible ASCII characters"),
        ("AWS_SESSION_TOKEN", "secret ", "a space at character 7", "visible ASCII characters"),
        (
            "AWS_SESSION_TOKEN",
            "secr\u{e9}t",
            "a character beyond ASCII at character 5",
            "visible ASCII characters",
        ),
        ("AWS_ACCESS_KEY_ID", "\0", "a control character at character 1", "visible ASCII characters"),
        ("AWS_SECRET_ACCESS_KEY", "secret\n", "a line break at character 7", "one line of text"),
        ("AWS_ENDPOINT", "127.0.0.1:9000", "no scheme", "a URL such as https://HOST:PORT"),
        ("AWS_ENDPOINT_URL", "localhost:9000", "no scheme", "a URL such as https://HOST:PORT"),
        ("AWS_ENDPOINT", "https://", "no URL (empty host)", "a URL such as https://HOST:PORT"),
        ("AWS_ENDPOINT", "https://a:b:c", "no URL (invalid port number)", "a URL such as https://HOST:PORT"),
        (
            "AWS_ENDPOINT",
            "ftp://host",
            "a scheme that is neither http nor https",
            "a URL such as https://HOST:PORT",
        ),
        ("AWS_ENDPOINT", "https://u:secret@h", "a user or a password", "a URL such as https://HOST:PORT"),
        (
            "AWS_ENDPOINT_URL_S3",
            "https://h/?secret",
            "a query or a fragment",
            "a URL such as https://HOST:PORT",
        ),
        ("AWS_REGION", "eu west", "a space at character 3", "the name of a region, such as eu-west-1"),
        (
            "AWS_REGION",
            "a/b",
            "a character that does not belong there at character 2",
            "the name of a region, such as eu-west-1",
        ),
        ("AWS_ALLOW_HTTP", "secret", "another word", "true or false"),
        ("AWS_CONTAINER_CREDENTIALS_RELATIVE_URI", "@secret", "no such path", "a path of a URL, from its /"),
        ("AWS_ENDPOINT", "http://host", "plain http", "https, or AWS_ALLOW_HTTP=true beside it"),
    ] {
        refused(
            &[(variable, value)],
            &format!("environment variable {variable}: found {found}, expected {expected}"),
        );
    }
    refused(
        &[("AWS_ACCESS_KEY_ID", "key")],
        "environment variable AWS_SECRET_ACCESS_KEY: found nothing, beside AWS_ACCESS_KEY_ID, expected both or neither",
    );
}

#[test]
fn good_values_are_taken_empty_and_unknown_ones_are_not() {
    let found = read(&[
        ("AWS_ENDPOINT", "http://127.0.0.1:9000/"),
        ("AWS_ENDPOINT_URL", "https://other"),
        ("AWS_ALLOW_HTTP", "Yes"),
        ("AWS_SESSION_TOKEN", ""),
        ("AWS_PROXY_URL", "http://proxy"),
        ("AWS_ALLOW_INVALID_CERTIFICATES", "true"),
        ("PATH", "/bin"),
    ]);
    let expected = [
        ("AWS_ENDPOINT_URL", "https://other"),
        ("AWS_ENDPOINT", "http://127.0.0.1:9000"),
        ("AWS_ALLOW_HTTP", "true"),
    ];
    assert_eq!(found, Ok(expected.map(|(name, value)| (name, value.to_owned())).to_vec()));
    assert_eq!(read(&[]), Ok(vec![]));
}

#[test]
fn every_variable_is_one_that_object_store_knows() {
    for (name, _) in VARIABLES {
        assert!(name.to_ascii_lowercase().parse::<object_store::aws::AmazonS3ConfigKey>().is_ok(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn bytes_that_are_no_text_are_named() {
    use std::os::unix::ffi::OsStringExt;
    let token = [("AWS_SESSION_TOKEN".into(), OsString::from_vec(vec![b's', 0xff]))];
    let message = settings(token).expect_err("refused").to_string();
    assert!(
        message.ends_with("AWS_SESSION_TOKEN: found bytes that are no UTF-8, expected text"),
        "{message}"
    );
}

/// Names of variables that are read, and values of every kind around a secret.
fn environment() -> impl Strategy<Value = Vec<(&'static str, String)>> {
    let name = proptest::sample::select(VARIABLES.map(|(name, ..)| name).to_vec());
    let value = prop_oneof![
        Just(String::new()),
        Just("true".to_owned()),
        "[ -~]{0,30}".prop_map(|text| format!("c0ffee{text}")),
        "(http|https|ftp|)(://|:|)([a-z0-9.]{0,9}|\\[::1\\])(:[0-9]{0,6})?(/[a-z@?#%]{0,9})?"
            .prop_map(|text| text + "c0ffee"),
        any::<String>().prop_map(|text| text.replace('\0', "") + "c0ffee"),
    ];
    proptest::collection::vec((name, value), 0..8)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_environment_panics_and_no_message_repeats_a_value(variables in environment(), key in ".{0,40}") {
        use super::super::replay::open_in;
        let variables = variables.iter().map(|(name, value)| ((*name).into(), value.into()));
        for url in [
            "s3://bucket/a.flb".to_owned(),
            format!("s3://bucket/{key}?c0ffee"),
            format!("http://{key}?c0ffee"),
        ] {
            let said = open_in(&url, variables.clone());
            prop_assert!(!said.contains("c0ffee"), "{}", said);
        }
    }
}
