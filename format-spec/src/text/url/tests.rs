use super::*;

/// Ways to hide a secret in what means to be a URL.
const SECRET: &str = "S3CR3T";
const ODD: [&str; 23] = [
    "http://u:p/S3CR3T@h/x",
    "http://h/x#S3CR3T",
    "http://h/S3CR3T",
    r"http:\\h\x?sig=S3CR3T",
    "//u:S3CR3T@h/x?sig=S3CR3T",
    r"\\u:S3CR3T@h\x",
    "plants//../http:/u:S3CR3T@h/x",
    r"plants/\\u:S3CR3T@h\x",
    "ftp:/h/x?sig=S3CR3T",
    "http%3A//u:S3CR3T@h/x",
    "HTTP%3a%2F%5Cu:S3CR3T@h/x",
    "http://u:S3CR3T%40h/x",
    "http://u s:S3CR3T@h/x",
    "http://h/x?a=b cS3CR3T",
    "http://h/x?a=\"S3CR3T",
    "http://h?S3CR3T",
    "http:x?sig=S3CR3T",
    "s3:x?sig=S3CR3T",
    "-bm 1 x+y.z://h/x?sig=S3CR3T",
    "x?sig=S3CR3T&next=http://h/x",
    "3http://[u:S3CR3T@h]/x",
    "a=//h/x?S3CR3T",
    "`//h/x?S3CR3T`",
];

#[test]
fn of_a_reference_that_means_to_be_a_url_scheme_and_host_are_shown() {
    for url in ODD {
        let shown = shown_reference(url);
        assert!(!shown.contains(SECRET) && shown.contains("..."), "{url}: {shown}");
        assert!(is_meant(url), "{url}");
    }
    for (url, expected) in [
        ("http://h/x", "http://h/..."),
        ("HTTPS://h:80/x?y", "HTTPS://h:80/..."),
        ("http://[::1]:80/x", "http://[::1]:80/..."),
        (r"s3:\bucket\key", r"s3:\bucket/..."),
        ("//h/x?y", "//h/..."),
        ("folder/http://h/x", "folder/http://h/..."),
        ("http://u@h/x", "http://..."),
        ("http://h", "http://h"),
        ("http://h/", "http://h/"),
    ] {
        assert_eq!(shown_reference(url), expected);
    }
}

#[test]
fn names_of_files_are_shown_as_they_are() {
    for name in [
        "tex.png",
        "a path?with=questions",
        "tex@2x.png",
        "#0",
        r"C:\plants\oak.glb",
        "C:/plants/oak.glb",
        "c:oak.glb",
        r"\\server\share\tex.png",
        "//server/share/tex.png",
        "a//b?c",
        "../a:b/c",
        "data:image/png;base64,AAAA",
        "http",
        "http:",
        "",
        ":",
        "é:é",
        "%3A%2F",
    ] {
        assert!(matches!(shown_reference(name), Cow::Borrowed(_)), "{name}");
        assert!(!is_meant(name), "{name}");
    }
}

#[test]
fn lines_that_a_parser_quotes_hold_no_more_of_a_url() {
    let message =
        "TOML parse error at line 2, column 8\n  |\n2 | file = http://u:p/S3CR3T@h\n  |        ^\nno string";
    assert_eq!(shown_lines(message), message.replace("u:p/S3CR3T@h", "..."));
    assert!(matches!(shown_lines("a\nb"), Cow::Borrowed(_)));
}
