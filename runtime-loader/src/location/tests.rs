use super::*;

#[test]
fn what_has_no_scheme_is_a_path() {
    for path in ["oak.flb", "/a/b.flb", "C:\\b.flb", "c://b.flb", "a b://c", "1a://b", "://", ""] {
        assert_eq!(Location::parse(path), Ok(Location::File(path.into())), "{path}");
    }
}

#[test]
fn unknown_schemes_are_named() {
    for url in ["ftp://host/oak.flb", "gs://bucket/oak.flb", "FTP://host/x"] {
        let message = Location::parse(url).expect_err("refused").to_string();
        assert!(message.contains("expected file, http, https or s3"), "{message}");
    }
}

#[test]
fn secrets_are_not_shown() {
    for url in [
        "https://user:secret@host/a.flb?X-Signature=secret#secret",
        "https://secret@host/a.flb#secret?secret",
        "s3://secret:secret@host/a.flb",
        "ftp://user:se@cret:secret@host/a.flb?secret",
        "https:////user:secret@host/a.flb",
        "https://user:sec/ret:secret@host/a.flb",
        "https://user:secret\\secret@host/a.flb",
        "https://us\ner:secret@host/a.flb",
        "https://user:secret@[/secret@host/a.flb",
    ] {
        let text = shown(url);
        assert!(text.contains("://host/a.flb") && !text.contains("secret"), "{text}");
        if let Err(error) = Location::parse(url) {
            assert!(!error.to_string().contains("secret"), "{error}");
        }
    }
    assert_eq!(shown("https://host/a.flb?v=2"), "https://host/a.flb?...");
}

#[cfg(feature = "remote")]
mod remote {
    use super::*;

    #[track_caller]
    fn refused(url: &str, part: &str) {
        let message = Location::parse(url).expect_err("refused").to_string();
        assert!(message.contains(part), "{url}: {message}");
    }

    #[test]
    fn urls_keep_their_words_in_names() {
        for (url, name) in [
            ("https://host/a%20b.flb", "https://host/a%20b.flb"),
            ("HTTP://HOST:81/a.flb?v=2", "http://host:81/a.flb?..."),
            ("s3://bucket/folder/a.flb", "s3://bucket/folder/a.flb"),
        ] {
            let location = Location::parse(url).expect("a URL");
            assert_eq!((location.to_string().as_str(), location.file()), (name, None));
        }
    }

    #[test]
    fn users_and_passwords_are_refused() {
        refused("https://user:secret@host/a.flb", "https://host/a.flb: holds a user or a password");
        refused("http://user@host/a.flb", "holds a user or a password");
        refused("s3://key:secret@bucket/a.flb", "s3://bucket/a.flb: holds a user or a password");
    }

    #[test]
    fn urls_without_a_file_are_refused() {
        refused("s3://bucket", "names no object");
        refused("s3://bucket/", "names no object");
        refused("s3:///a.flb", "names no bucket");
        refused("s3://bucket/a.flb?versionId=1", "expected s3://BUCKET/KEY alone");
        refused("s3://bucket:9000/a.flb", "expected s3://BUCKET/KEY alone");
        refused("http://", "host");
        refused("file://elsewhere/a.flb", "expected a path on this machine");
        refused(&format!("http://host/{}", "a".repeat(70_000)), "too long");
    }

    #[cfg(unix)]
    #[test]
    fn file_urls_are_paths() {
        assert_eq!(Location::parse("file:///a%20b/c.flb"), Ok(Location::File("/a b/c.flb".into())));
        assert_eq!(Location::parse("file://localhost/c.flb"), Ok(Location::File("/c.flb".into())));
    }
}
