//! Servers that lead elsewhere, keep others waiting, or send what no good one sends. 127.0.0.1 plays an address of the
//! public internet here and 127.0.0.2 a private one, or the other way round.
#![cfg(all(feature = "remote", target_os = "linux"))] // elsewhere, 127.0.0.2 has to be made first

use std::net::IpAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use flb_format::Source;
use flb_runtime::Location;
use flb_runtime::source::{RemoteSettings, RemoteSource, RemoteUrl};
use flb_testkit::server::{Reply, Request, Served, Server};

const PUBLIC: &str = "127.0.0.1";
const PRIVATE: &str = "127.0.0.2";

fn url(text: &str) -> RemoteUrl {
    match Location::parse(text) {
        Ok(Location::Remote(url)) => url,
        other => panic!("{other:?}"),
    }
}

fn settings() -> RemoteSettings {
    let seconds = Duration::from_secs;
    RemoteSettings {
        idle: seconds(5),
        limit: seconds(20),
        is_private: |address| address == PRIVATE.parse::<IpAddr>().expect("an address"),
        ..RemoteSettings::default()
    }
}

fn served() -> Served {
    Served::tagged((0..100_000u32).map(|i| i as u8).collect::<Vec<u8>>(), "\"a\"")
}

/// A server of the file at an address, and one at another that leads to it by `location`, where PORT is the other's
/// port.
fn pair(from: &str, to: &str, location: &str) -> (Server, Server) {
    let file = served();
    let second = Server::start_at(to, move |request| file.reply(request));
    let location = location.replace("PORT", &second.port().to_string());
    (Server::start_at(from, move |_| Reply::new(302, "").with("Location", location.clone())), second)
}

#[track_caller]
fn refused(server: &Server, settings: &RemoteSettings, says: &str) -> String {
    let began = Instant::now();
    let error = RemoteSource::open(&url(&server.url("/a.flb?sig=secret")), settings).err().expect("refused");
    let (shown, debugged) = (error.to_string(), format!("{error:?}"));
    assert!(shown.contains(says), "expected {says:?} in {shown:?}");
    assert!(!shown.contains("secret") && !debugged.contains("secret"), "{shown} {debugged}");
    assert!(shown.chars().count() < 700 && !shown.contains(char::is_control), "{shown:?}");
    assert!(began.elapsed() < settings.limit + Duration::from_secs(2), "{:?}", began.elapsed());
    shown
}

#[test]
fn another_origin_sees_nothing_of_the_first() {
    let (first, second) = pair(PUBLIC, PUBLIC, "http://127.0.0.1:PORT/elsewhere.flb");
    let source = RemoteSource::open(&url(&first.url("/a.flb?X-Amz-Signature=secret")), &settings());
    let source = source.expect("it is followed");
    let mut byte = [0];
    source.read_exact_at(90_000, &mut byte).expect("it is followed again");
    assert_eq!(byte, [90_000u32 as u8]);
    let requests = second.requests();
    assert_eq!((requests.len(), first.requests().len(), source.traffic().requests), (2, 2, 4));
    for request in requests {
        assert_eq!(request.path, "/elsewhere.flb");
        let words = format!("{request:?}");
        assert!(!words.contains("secret") && !words.contains(&first.port().to_string()), "{words}");
        let known = ["accept", "host", "if-match", "range", "user-agent"];
        assert!(request.headers.keys().all(|name| known.contains(&name.as_str())), "{words}");
    }
}

#[test]
fn what_a_server_sends_back_of_the_query_is_not_told() {
    for (name, value, says) in [
        ("Content-Range", "bytes secret-9/10", "found the Content-Range \"bytes ...-9/10\""),
        ("Content-Range", "bytes %73ecret-9/10", "found the Content-Range \"...\""),
        ("Location", "ftp://h/secret", "found the scheme"),
        (
            "Location",
            "http://secret.example:0x/secret",
            "found \"http://....example:0x/...\", expected a URL",
        ),
        ("Location", "http://127.0.0.2/a%2Fsecret", "found \"http://127.0.0.2/a%2F...\", a private address"),
    ] {
        let status = if name == "Location" { 302 } else { 206 };
        refused(&Server::start(move |_| Reply::new(status, "").with(name, value)), &settings(), says);
    }
    let file = served();
    let server = Server::start(move |request| {
        let tag = ["\"secret\"", "\"other-secret\""][request.number.min(1)];
        let request = Request {
            headers: [("range".to_owned(), request.headers["range"].clone())].into(),
            ..request.clone()
        };
        Served { e_tag: Some(tag.to_owned()), ..file.clone() }.reply(&request)
    });
    let source = RemoteSource::open(&url(&server.url("/a.flb?sig=secret")), &settings()).expect("whole");
    let error = source.read_exact_at(90_000, &mut [0]).expect_err("it was replaced").to_string();
    assert!(error.contains("ETag \"other-...\" of") && !error.contains("secret"), "{error}");
}

#[test]
fn no_referer_is_sent_within_an_origin_either() {
    let file = served();
    let server = Server::start(move |request| match request.path.starts_with("/a.flb") {
        true => Reply::new(307, "").with("Location", "/b.flb"),
        false => file.reply(request),
    });
    RemoteSource::open(&url(&server.url("/a.flb?secret")), &settings()).expect("it is followed");
    assert!(server.requests().iter().all(|request| !request.headers.contains_key("referer")));
    assert!(!format!("{:?}", server.requests()[1]).contains("secret"));
}

#[test]
fn a_public_server_cannot_lead_to_a_private_one() {
    for location in ["http://127.0.0.2:PORT/", "http://2130706434:PORT/", "http://[::ffff:127.0.0.2]:PORT/"] {
        let (first, second) = pair(PUBLIC, PRIVATE, location);
        let mapped = RemoteSettings {
            is_private: |address| address.to_canonical() == PRIVATE.parse::<IpAddr>().expect("an address"),
            ..settings()
        };
        let message =
            refused(&first, &mapped, "a private address, from a public one, expected a public address");
        assert!(message.contains("redirect 1: found \"http://"), "{message}");
        assert_eq!((first.requests().len(), second.requests().len()), (1, 0), "{location}");
    }
    let (first, second) = pair(PUBLIC, PRIVATE, "http://127.0.0.2:PORT/");
    let allowed = RemoteSettings { allow_private_redirects: true, ..settings() };
    RemoteSource::open(&url(&first.url("/a.flb")), &allowed).expect("it is allowed");
    assert_eq!(second.requests().len(), 1);
}

#[test]
fn a_name_that_leads_to_a_private_address_is_found_where_it_is_looked_up() {
    // "localhost" has no address that this calls public, and the server that leads to it has.
    let private =
        RemoteSettings { is_private: |address| address != PRIVATE.parse::<IpAddr>().unwrap(), ..settings() };
    let (first, second) = pair(PRIVATE, PUBLIC, "http://localhost:PORT/");
    refused(
        &first,
        &private,
        "redirect 1: found a name to which a public server leads, and it has no public address",
    );
    assert_eq!((first.requests().len(), second.requests().len()), (1, 0));
    let allowed = RemoteSettings { allow_private_redirects: true, ..private };
    RemoteSource::open(&url(&first.url("/a.flb")), &allowed).expect("it is allowed");
}

#[test]
fn private_addresses_may_be_named_and_may_lead_anywhere() {
    for (from, to) in [(PRIVATE, PRIVATE), (PRIVATE, PUBLIC), (PUBLIC, PUBLIC)] {
        let (first, second) = pair(from, to, &format!("http://{to}:PORT/"));
        RemoteSource::open(&url(&first.url("/a.flb")), &settings()).expect("it is followed");
        assert_eq!((first.requests().len(), second.requests().len()), (1, 1), "{from} to {to}");
    }
}

#[test]
fn a_server_that_asks_to_wait_is_waited_for() {
    let file = served();
    let times = Arc::new(std::sync::Mutex::new(Vec::new()));
    let seen = Arc::clone(&times);
    let server = Server::start(move |request| {
        seen.lock().expect("one thread").push(Instant::now());
        match request.number {
            0 => Reply::new(503, "").with("Retry-After", "2"),
            _ => file.reply(request),
        }
    });
    RemoteSource::open(&url(&server.url("/a.flb")), &settings()).expect("the second answer is good");
    let times = times.lock().expect("one thread");
    assert!(times.len() == 2 && times[1] - times[0] >= Duration::from_secs(2), "{times:?}");
}

#[test]
fn a_wait_beyond_the_limit_is_refused_at_once() {
    for (wait, seconds) in [("3600", "3600 s"), ("99999999999999999999", "18446744073709551615 s")] {
        let server = Server::start(move |_| Reply::new(429, "").with("Retry-After", wait));
        let began = Instant::now();
        let says = format!(
            "the answer 429 Too Many Requests that asks to wait {seconds}, expected 206 with this range within 20 s"
        );
        refused(&server, &settings(), &says);
        assert!(server.requests().len() == 1 && began.elapsed() < Duration::from_secs(1), "{wait}");
    }
}

#[test]
fn a_throttled_file_is_asked_for_more_than_a_few_times_within_the_limit() {
    let file = served();
    let server = Server::start(move |request| match request.number {
        0..6 => Reply::new([429, 503, 408, 502, 504][request.number % 5], "slow down"),
        _ => file.reply(request),
    });
    let patient = RemoteSettings { retries: 0, ..settings() };
    RemoteSource::open(&url(&server.url("/a.flb")), &patient).expect("the seventh answer is good");
    assert_eq!(server.requests().len(), 7);

    let never = Server::start(|_| Reply::new(503, "slow down"));
    let hasty = RemoteSettings { limit: Duration::from_secs(2), ..settings() };
    let message = refused(&never, &hasty, "found the answer 503 Service Unavailable to each of ");
    assert!(message.contains(&format!(" {} tries", never.requests().len())), "{message}");
}

#[test]
fn redirects_to_what_is_no_web_are_refused() {
    for (location, says) in [
        ("file:///etc/passwd", "found the scheme \"file\", expected http or https"),
        ("ftp://127.0.0.1/a", "found the scheme \"ftp\""),
        ("javascript:alert(1)", "found the scheme \"javascript\""),
        ("http://user:secret@127.0.0.1/", "found a user or a password in the Location, expected none"),
        ("http://127.0.0.1:99999/?secret", "found \"http://127.0.0.1:99999/?...\", expected a URL"),
    ] {
        let server = Server::start(move |_| Reply::new(302, "").with("Location", location));
        refused(&server, &settings(), says);
    }
    let long = Server::start(|_| Reply::new(302, "").with("Location", format!("/{}", "a".repeat(65_535))));
    refused(&long, &settings(), "found a Location of 65536 bytes, expected 8192 at most");
    let none = Server::start(|_| Reply::new(302, ""));
    refused(&none, &settings(), "found 0 headers Location, expected one");
}

#[test]
fn hostile_answers_end_soon_with_a_short_message() {
    let short = RemoteSettings { limit: Duration::from_secs(5), retries: 0, ..settings() };
    let header = |name: &'static str, value: String| {
        let file = served();
        Server::start(move |request| {
            let mut reply = file.reply(request);
            reply.headers.retain(|(other, _)| *other != name);
            reply.with(name, value.clone())
        })
    };
    let range = |found: String| header("Content-Range", found);
    refused(
        &range("bytes 0-65535/\u{202e}x\ty".to_owned()),
        &short,
        "found the Content-Range \"bytes 0-65535/",
    );
    refused(&range("9".repeat(60_000)), &short, "9\"..., expected this range");
    refused(&header("Content-Encoding", "gzip".to_owned()), &short, "found the Content-Encoding \"gzip\"");
    refused(&header("ETag", "\"".repeat(5000)), &short, "found an ETag of 5000 bytes, expected 1024 at most");
    refused(&header("Last-Modified", "x".repeat(5000)), &short, "bytes 0 to 65535: ");
    let endless = Server::start(|_| Reply { endless: true, ..Reply::new(206, "") });
    refused(&endless, &short, "bytes 0 to 65535: ");
}
