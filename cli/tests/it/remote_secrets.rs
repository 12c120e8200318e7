//! What the environment holds for s3 goes to the endpoint that it names and nowhere else, and a variable that cannot be
//! used is named without its value. Each case is a program of its own, because the environment is.
#![cfg(feature = "remote")]

use std::sync::LazyLock;

use flb_testkit::server::{Reply, Served, Server};
use proptest::prelude::*;

use crate::flb::{Folder, Run};

const SECRET: &str = "c0ffee5ec2e7";

/// Straight to the server, whatever proxy this machine uses, with credentials for `endpoint`, and `more` over them.
fn flb_in(folder: &Folder, endpoint: &str, more: &[(&str, &str)], words: &[&str]) -> Run {
    let mut environment = vec![
        ("NO_PROXY", "127.0.0.1"),
        ("no_proxy", "127.0.0.1"),
        ("AWS_ENDPOINT", endpoint),
        ("AWS_ALLOW_HTTP", "true"),
        ("AWS_ACCESS_KEY_ID", "key"),
        ("AWS_SECRET_ACCESS_KEY", SECRET),
        ("AWS_SESSION_TOKEN", SECRET),
    ];
    environment.retain(|(name, _)| more.iter().all(|(other, _)| other != name));
    environment.extend(more);
    folder.flb_in(&environment, words)
}

#[track_caller]
fn keeps_secrets(run: &Run) {
    let said = format!("{}{}", run.stdout, run.stderr);
    assert!(!said.contains(SECRET) && !said.contains("panicked"), "{said}");
}

#[test]
fn s3_gives_its_token_to_its_own_origin_alone() {
    let folder = Folder::with_card();
    let served = Served::tagged(folder.read("card.flb"), "\"a\"");
    let other = {
        let served = served.clone();
        Server::start(move |request| served.reply(request))
    };
    let location = other.url("/elsewhere.flb");
    let first = Server::start(move |request| match request.path.as_str() {
        "/bucket/away.flb" => Reply::new(307, "").with("Location", location.clone()),
        "/bucket/near.flb" => Reply::new(307, "").with("Location", "/bucket/here.flb"),
        _ => served.reply(request),
    });
    let run = flb_in(&folder, &first.url(""), &[], &["info", "s3://bucket/away.flb"]).expect_code(4);
    keeps_secrets(&run);
    run.says(&[
        "redirect 1: found \"http://127.0.0.1:",
        "expected the server of the request before, which has",
    ]);
    assert!(other.requests().is_empty(), "{:?}", other.requests());
    let token = |number: usize| first.requests()[number].headers.get("x-amz-security-token").cloned();
    assert_eq!(token(0).as_deref(), Some(SECRET));
    flb_in(&folder, &first.url(""), &[], &["info", "s3://bucket/near.flb"]).expect_code(0);
    assert_eq!((first.requests().len(), token(2).as_deref()), (3, Some(SECRET)));
    assert!(first.requests().iter().all(|request| !request.headers.contains_key("referer")));
}

#[test]
fn a_signed_url_is_told_to_no_other_host() {
    let folder = Folder::with_card();
    let served = Served::tagged(folder.read("card.flb"), "\"a\"");
    let other = Server::start(move |request| served.reply(request));
    let location = other.url("/elsewhere.flb");
    let first = Server::start(move |_| Reply::new(302, "").with("Location", location.clone()));
    let url = format!("{}?X-Amz-Signature={SECRET}", first.url("/a.flb"));
    for command in ["info", "validate"] {
        for words in [&[command, &url][..], &[command, &url, "--json", "--allow-private-redirects"]] {
            keeps_secrets(&flb_in(&folder, "https://nowhere", &[], words).expect_code(0));
        }
    }
    assert_eq!(other.requests().len(), 4);
    for request in other.requests() {
        let words = format!("{request:?}");
        assert!(!words.contains(SECRET) && !words.contains("referer") && !words.contains("amz"), "{words}");
    }
}

#[test]
fn a_proxy_is_not_led_to_names_whose_address_cannot_be_checked() {
    let folder = Folder::with_card();
    let served = Served::tagged(folder.read("card.flb"), "\"a\"");
    let proxy = Server::start(move |request| match request.path.as_str() {
        "http://first.invalid/a.flb" => Reply::new(302, "").with("Location", "http://second.invalid/b.flb"),
        "http://first.invalid/near.flb" => Reply::new(302, "").with("Location", "/b.flb"),
        "http://first.invalid/here.flb" => Reply::new(302, "").with("Location", "http://127.0.0.1:1/b.flb"),
        _ => served.reply(request),
    });
    let address = proxy.url("");
    let through = [("HTTP_PROXY", address.as_str()), ("NO_PROXY", ""), ("no_proxy", "")];
    let info = |url: &str, flags: &[&str]| {
        flb_in(&folder, "https://nowhere", &through, &[&["info", url][..], flags].concat())
    };
    for (url, says) in [
        (
            "http://first.invalid/a.flb",
            "http://second.invalid/b.flb\", whose address a proxy looks up, expected",
        ),
        ("http://first.invalid/here.flb", "http://127.0.0.1:1/b.flb\", a private address, from a public one"),
    ] {
        let before = proxy.requests().len();
        info(url, &[]).expect_code(4).says(&[says, "(or allow-private-redirects)"]);
        assert_eq!(proxy.requests().len(), before + 1, "{url}");
        info(url, &["--allow-private-redirects"]).expect_code(0);
    }
    info("http://first.invalid/near.flb", &[]).expect_code(0);
}

#[test]
fn a_variable_that_cannot_be_used_is_a_usage_error_by_name() {
    let folder = Folder::with_card();
    let token = format!("{SECRET}\nmore");
    let host = format!("https://user:{SECRET}@127.0.0.1:1");
    for (name, value, says) in [
        ("AWS_SESSION_TOKEN", token.as_str(), "found a line break at character 13, expected visible ASCII"),
        ("AWS_ACCESS_KEY_ID", &token, "found a line break at character 13, expected visible ASCII"),
        ("AWS_ENDPOINT", "127.0.0.1:9000", "found no scheme, expected a URL such as https://HOST:PORT"),
        ("AWS_ENDPOINT", &host, "found a user or a password, expected a URL such as https://HOST:PORT"),
        ("AWS_ALLOW_HTTP", SECRET, "found another word, expected true or false"),
        ("AWS_SECRET_ACCESS_KEY", "", "found nothing, beside AWS_ACCESS_KEY_ID, expected both or neither"),
    ] {
        for words in [&["info", "s3://bucket/a.flb"][..], &["validate", "s3://bucket/a.flb", "--json"]] {
            let run = flb_in(&folder, "http://127.0.0.1:1", &[(name, value)], words).expect_code(2);
            keeps_secrets(&run);
            run.says(&["s3://bucket/a.flb: environment variable ", name, says]);
        }
    }
}

/// Without keys of its own, by the service of a machine in the cloud, unless `more` says otherwise.
fn flb_by_service(folder: &Folder, server: &Server, more: &[(&str, &str)]) -> Run {
    let here = server.url("");
    let service = [
        ("AWS_ACCESS_KEY_ID", ""),
        ("AWS_SECRET_ACCESS_KEY", ""),
        ("AWS_SESSION_TOKEN", ""),
        ("AWS_METADATA_ENDPOINT", &here),
    ];
    flb_in(folder, &here, &[&service[..], more].concat(), &["info", "s3://bucket/card.flb"])
}

/// A file, and what gives credentials for it: the token, the role and the name of the key as given.
fn service(file: Vec<u8>, token: &str, role: &str, key: &str) -> Server {
    const ROLES: &str = "/latest/meta-data/iam/security-credentials/";
    let served = Served::tagged(file, "\"a\"");
    let [token, role] = [token, role].map(str::to_owned);
    let document = format!(
        "{{\r\n \"AccessKeyId\": \"{key}\",\n \"SecretAccessKey\": \"{SECRET}\",\n \"Token\": \"{SECRET}\",\n \
         \"Expiration\": \"2099-01-01T00:00:00Z\"\n}}\n"
    );
    Server::start(move |request| match request.path.as_str() {
        "/latest/api/token" => Reply::new(200, token.clone()),
        ROLES => Reply::new(200, role.clone()),
        path if path.starts_with(ROLES) || path == "/creds" => Reply::new(200, document.clone()),
        _ => served.reply(request),
    })
}

#[test]
fn credentials_of_a_service_may_end_in_a_line_end_and_odd_ones_are_refused_without_a_panic() {
    let folder = Folder::with_card();
    let file = folder.read("card.flb");
    for end in ["", "\n", "\r\n"] {
        let server = service(file.clone(), &format!("token{end}"), &format!("role{end}"), "key");
        let run = flb_by_service(&folder, &server, &[]).expect_code(0);
        keeps_secrets(&run);
        assert_eq!(server.requests()[2].headers["x-aws-ec2-metadata-token"], "token");
    }
    for (token, role, key, says) in [
        ("to\nken", "role", "key", "found a token that is not one line of visible ASCII characters"),
        ("token", "a role", "key", "found a name of a role with other characters than letters"),
        ("token", "a<b", "key", "found a name of a role with other characters than letters"),
        ("token", "a`b", "key", "found a name of a role with other characters than letters"),
        ("token", "role", "k\ney", "found credentials with a line end within a text"),
        ("token", "role", "k\\ney", "found credentials with bytes that no header can hold"),
    ] {
        let run = flb_by_service(&folder, &service(file.clone(), token, role, key), &[]).expect_code(4);
        keeps_secrets(&run);
        run.says(&[says]);
    }
}

#[test]
fn a_file_with_a_token_is_checked_before_it_is_used() {
    let folder = Folder::with_card();
    let server = service(folder.read("card.flb"), "token", "role", "key");
    let creds = server.url("/creds");
    let path = |name: &str| folder.path(name).display().to_string();
    let container = |file: &str| {
        let names = [("AWS_CONTAINER_CREDENTIALS_FULL_URI", creds.as_str())];
        let more = [("AWS_CONTAINER_AUTHORIZATION_TOKEN_FILE", file)];
        flb_by_service(&folder, &server, &[&names[..], &more].concat())
    };
    std::fs::write(folder.path("sound"), SECRET).expect("a folder");
    keeps_secrets(&container(&path("sound")).expect_code(0));
    assert_eq!(server.requests()[0].headers["authorization"], SECRET);

    std::fs::write(folder.path("echoed"), format!("{SECRET}\n")).expect("a folder");
    std::fs::write(folder.path("long"), SECRET.repeat(10_000)).expect("a folder");
    std::fs::write(folder.path("none"), "").expect("a folder");
    for (file, says) in [
        (
            path("echoed"),
            "found a file with a line break at byte 13, expected a file with a token of visible",
        ),
        (path("long"), "found a file of more than 65536 bytes"),
        (path("none"), "found an empty file"),
        (path("missing"), "found no file that can be read"),
        ("/dev/zero".to_owned(), "found a pipe, device or socket"),
    ] {
        let run = container(&file).expect_code(2);
        keeps_secrets(&run);
        run.says(&["environment variable AWS_CONTAINER_AUTHORIZATION_TOKEN_FILE: ", says]);
    }
    for (file, says) in [("/dev/zero".to_owned(), "found a pipe, device or socket"), (path("long"), "65536")]
    {
        let web = [("AWS_WEB_IDENTITY_TOKEN_FILE", file.as_str()), ("AWS_ROLE_ARN", "arn:aws:iam::1:role/a")];
        let run = flb_by_service(&folder, &server, &web).expect_code(2);
        run.says(&["environment variable AWS_WEB_IDENTITY_TOKEN_FILE: ", says]);
        flb_by_service(&folder, &server, &web[..1]).expect_code(0); // without a role nothing reads it
    }
}

#[test]
fn no_proxy_sees_what_a_service_near_by_is_asked() {
    let folder = Folder::with_card();
    let server = service(folder.read("card.flb"), "token", "role", "key");
    let served = Served::tagged(folder.read("card.flb"), "\"a\"");
    let proxy = Server::start(move |request| served.reply(request));
    std::fs::write(folder.path("token"), "container-token").expect("a folder");
    let (address, creds, file) =
        (proxy.url(""), server.url("/creds"), folder.path("token").display().to_string());
    let through = [("HTTP_PROXY", address.as_str()), ("NO_PROXY", ""), ("no_proxy", "")];
    let container = [
        ("AWS_CONTAINER_CREDENTIALS_FULL_URI", creds.as_str()),
        ("AWS_CONTAINER_AUTHORIZATION_TOKEN_FILE", &file),
    ];
    for more in [&through[..], &[&through[..], &container].concat()] {
        flb_by_service(&folder, &server, more).expect_code(0);
    }
    assert_eq!(server.requests().len(), 3 + 1);
    assert_eq!(proxy.requests().len(), 2, "the file");
    for request in proxy.requests() {
        assert!(request.path.ends_with("/bucket/card.flb"), "{request:?}");
    }
}

/// Has no file.
static NOT_HERE: LazyLock<Server> = LazyLock::new(|| Server::start(|_| Reply::new(404, SECRET)));

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(30) })]

    #[test]
    fn no_environment_and_no_url_makes_the_program_panic_or_tell(
        name in prop::sample::select(vec![
            "AWS_SESSION_TOKEN", "AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_ENDPOINT", "AWS_ENDPOINT_URL_S3",
            "AWS_REGION", "AWS_ALLOW_HTTP", "AWS_VIRTUAL_HOSTED_STYLE_REQUEST", "AWS_S3_EXPRESS", "HTTP_PROXY",
        ]),
        value in "[ -~\n\t\u{e9}]{0,12}",
        user in "[a-z:@]{0,6}",
        scheme in prop::sample::select(vec!["s3", "http", "https", "ftp", "HTTP"]),
    ) {
        let folder = Folder::new();
        let here = &NOT_HERE.url("")["http://".len()..];
        let value = format!("{value}{SECRET}");
        for url in [
            "s3://bucket/a.flb".to_owned(),
            format!("{scheme}://{user}{SECRET}@{here}/a.flb?{SECRET}"),
            format!("{scheme}://{here}/a.flb?{SECRET}#{SECRET}"),
        ] {
            let run = flb_in(&folder, &NOT_HERE.url(""), &[(name, &value)], &["validate", &url, "--json"]);
            prop_assert!([2, 4].contains(&run.code), "{}: {}", run.code, run.stderr);
            let said = format!("{}{}", run.stdout, run.stderr);
            prop_assert!(!said.contains(SECRET) && !said.contains("panicked"), "{}", said);
        }
    }
}
