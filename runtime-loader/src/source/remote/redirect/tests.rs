use http::HeaderValue;

use super::*;

const SECRETS: [(&str, &str); 6] = [
    ("authorization", "AWS4 secret"),
    ("cookie", "secret"),
    ("proxy-authorization", "secret"),
    ("referer", "https://a.example/?secret"),
    ("x-amz-security-token", "secret"),
    ("x-api-key", "secret"),
];

/// Private are the addresses of 127.0.0.2 and 10.0.0.0/8 alone, so that 127.0.0.1 is public.
fn rules() -> Rules {
    let is_private =
        |address: IpAddr| ["127.0.0.2", "10."].iter().any(|p| address.to_string().starts_with(p));
    Rules { same_origin: false, allow_private: false, is_private, secrets: Arc::default() }
}

fn first(url: &str) -> Hop {
    let mut headers = HeaderMap::new();
    for (name, value) in SECRETS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    for name in HARMLESS {
        headers.insert(name, HeaderValue::from_static("a"));
    }
    Hop::first(&url.parse().expect("a URL"), headers).expect("a URL")
}

fn answer(location: &str) -> HeaderMap {
    HeaderMap::from_iter([(LOCATION, HeaderValue::from_bytes(location.as_bytes()).expect("a header"))])
}

fn go(hop: &Hop, location: &str, from: &str, rules: &Rules) -> Result<Option<Hop>, Refused> {
    let from = Some(from.parse().expect("an address"));
    hop.next((StatusCode::FOUND, &answer(location)), from, rules, |_| false)
}

#[track_caller]
fn refused(hop: &Hop, location: &str, from: &str, rules: &Rules, says: &str) {
    let message = go(hop, location, from, rules).expect_err("refused").to_string();
    assert!(message.contains(says), "{location}: {message}");
    assert!(!message.contains("secret") && message.chars().count() < 400, "{location}: {message}");
    assert!(!message.contains(char::is_control), "{location}: {message:?}");
}

#[test]
fn nothing_secret_crosses_to_another_origin() {
    let from = first("https://a.example/x?secret");
    for to in ["https://b.example/", "https://a.example:444/", "//b.example/x", "https://8.8.8.8/"] {
        let hop = go(&from, to, "127.0.0.1", &rules()).expect("followed").expect("a redirect");
        assert_eq!(hop.headers.len(), HARMLESS.len(), "{to}");
        assert!(!format!("{hop:?}").contains("secret"), "{to}: {hop:?}");
        let back = go(&hop, "https://a.example/x", "127.0.0.1", &rules()).expect("followed").expect("one");
        assert_eq!(back.headers.len(), HARMLESS.len(), "what was left behind stays there");
    }
    let same = go(&from, "/elsewhere#part", "127.0.0.1", &rules()).expect("followed").expect("a redirect");
    assert_eq!((same.url.as_str(), same.headers.len()), ("https://a.example/elsewhere", from.headers.len()));
}

#[test]
fn credentials_stay_within_their_origin() {
    let (rules, from) = (Rules { same_origin: true, ..rules() }, first("http://s3.example/bucket/key"));
    assert!(go(&from, "/bucket/other", "127.0.0.1", &rules).is_ok());
    for to in ["http://s3.example:81/", "https://s3.example/", "http://b.s3.example/"] {
        refused(&from, to, "127.0.0.1", &rules, "expected the server of the request before, which has");
    }
}

#[test]
fn a_public_server_leads_to_no_private_address() {
    let from = first("http://a.example/x");
    for to in [
        "http://127.0.0.2/",
        "http://10.1.2.3:8080/",
        "http://0x0a.1/",
        "http://167772161/",
        "http://012.0.0.1/",
        "http://10.0.0.1./",
        "http://１０.0.0.1/",
    ] {
        refused(&from, to, "127.0.0.1", &rules(), "a private address, from a public one, expected a public");
        let unknown = from.next((StatusCode::FOUND, &answer(to)), None, &rules(), |_| false);
        assert!(unknown.is_err(), "{to}: where an answer comes from must be known to be private");
        assert!(go(&from, to, "127.0.0.2", &rules()).is_ok(), "private to private");
        assert!(go(&from, to, "127.0.0.1", &Rules { allow_private: true, ..rules() }).is_ok());
    }
    let reach = |to: &str, from_address: &str, rules: &Rules| {
        go(&from, to, from_address, rules).expect("followed").expect("a redirect").reach
    };
    assert_eq!(reach("http://b.example/", "127.0.0.1", &rules()), Reach::Public, "names are looked up");
    assert_eq!(reach("/again", "127.0.0.1", &rules()), Reach::Public, "a name may lead elsewhere by now");
    assert_eq!(reach("http://b.example/", "127.0.0.2", &rules()), Reach::Any);
    assert_eq!(reach("http://8.8.8.8/", "127.0.0.1", &rules()), Reach::Any);
}

#[test]
fn a_proxy_does_not_lead_past_the_check() {
    let from = first("http://a.example/x");
    let next = |to: &str, allow_private: bool| {
        let rules = Rules { allow_private, ..rules() };
        let proxy = Some("127.0.0.2".parse().expect("an address"));
        // The peer is the proxy, which says nothing about the server.
        let peer = proxy.filter(|_| false);
        from.next((StatusCode::FOUND, &answer(to)), peer, &rules, |_| true)
    };
    let message = next("http://b.example/", false).expect_err("refused").to_string();
    assert!(message.contains("whose address a proxy looks up"), "{message}");
    assert!(next("http://10.0.0.1/", false).is_err());
    assert!(next("http://b.example/", true).is_ok() && next("http://8.8.8.8/", false).is_ok());
    assert!(next("/again", false).is_ok(), "the user named this host");
}

#[test]
fn locations_that_cannot_be_followed_are_named() {
    let from = first("https://a.example/x");
    for (to, says) in [
        ("http://a.example/x", "expected https, as before"),
        ("file:///etc/passwd", "found the scheme \"file\", expected http or https"),
        ("ftp://b.example/x", "found the scheme \"ftp\""),
        ("javascript:alert(1)", "found the scheme \"javascript\""),
        ("s3://bucket/key", "found the scheme \"s3\""),
        ("https://user:secret@b.example/", "found a user or a password in the Location, expected none"),
        ("https://user@b.example/", "found a user or a password"),
        ("https://[::1", "expected a URL"),
        ("https://us\u{85}er:secret@[/", "expected a URL"),
    ] {
        refused(&from, to, "127.0.0.1", &rules(), says);
    }
    let long = format!("/{}", "a".repeat(64 << 10));
    refused(&from, &long, "127.0.0.1", &rules(), "found a Location of 65537 bytes, expected 8192 at most");
    let none = from.next((StatusCode::FOUND, &HeaderMap::new()), None, &rules(), |_| false);
    assert!(none.expect_err("refused").to_string().contains("found 0 headers Location, expected one"));
    let mut two = answer("/a");
    two.append(LOCATION, HeaderValue::from_static("/b"));
    let two = from.next((StatusCode::FOUND, &two), None, &rules(), |_| false);
    assert!(two.expect_err("refused").to_string().contains("found 2 headers Location, expected one"));
}

#[test]
fn other_answers_are_no_redirects_and_ten_is_the_end() {
    let from = first("http://a.example/x");
    for status in [200, 206, 300, 304, 305, 306, 404, 503] {
        let status = StatusCode::from_u16(status).expect("a status");
        let next = from.next((status, &answer("/a")), None, &rules(), |_| false);
        assert!(next.expect("no redirect").is_none(), "{status}");
    }
    let mut hop = from;
    for _ in 0..10 {
        hop = go(&hop, "/x", "127.0.0.1", &rules()).expect("followed").expect("a redirect");
    }
    refused(&hop, "/x", "127.0.0.1", &rules(), "redirect 11: found another redirect, expected the file");
}

#[test]
fn a_secret_in_a_location_is_hidden_whole_whatever_marks_of_a_url_it_holds() {
    let secrets =
        Arc::new(Secrets::of(Some("a=AbCdEf%3FGhIjKl&b=MnOpQr%23StUvWx&c=%20YzAbCd"), ["EfGh?IjKl"]));
    let (from, rules) = (first("http://a.example/x"), Rules { secrets, ..rules() });
    for secret in ["AbCdEf?GhIjKl", "abcdef?ghijkl", "MnOpQr#StUvWx", "YzAbCd", "EfGh?IjKl"] {
        for location in [
            format!("http://[{secret}"),
            format!("{secret}://h/"),
            format!("{}[{secret}", "http://").repeat(9),
        ] {
            let message = go(&from, &location, "127.0.0.1", &rules);
            let message = message.map_or_else(|error| error.to_string(), |_| String::new()).to_lowercase();
            for half in secret.to_lowercase().split(['?', '#']) {
                assert!(!message.contains(half), "{location}: {message}");
            }
        }
    }
}
