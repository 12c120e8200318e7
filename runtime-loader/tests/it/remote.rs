//! Files behind URLs, against a server in the test: what is asked for, and what every bad answer gives.
#![cfg(feature = "remote")]

use std::sync::{Arc, Mutex};
use std::time::Duration;

use flb_format::Source;
use flb_runtime::source::{RemoteSettings, RemoteSource, RemoteUrl, is_replaced, retry_replaced};
use flb_runtime::{Library, Location, RuntimeError};
use flb_testkit::server::{Reply, Request, Served, Server};

use crate::forest::{BASES, field, forest};

const HEAD: u64 = 65_536;

fn url(server: &Server, path: &str) -> RemoteUrl {
    match Location::parse(server.url(path)) {
        Ok(Location::Remote(url)) => url,
        other => panic!("{other:?}"),
    }
}

/// Quick to give up; the server is on this machine.
fn settings() -> RemoteSettings {
    RemoteSettings {
        idle: Duration::from_secs(5),
        limit: Duration::from_secs(20),
        ..RemoteSettings::default()
    }
}

fn open(server: &Server) -> Result<RemoteSource, RuntimeError> {
    RemoteSource::open(&url(server, "/oak.flb"), &settings())
}

#[track_caller]
fn refused(server: &Server) -> String {
    open(server).err().expect("refused").to_string()
}

fn bytes(length: u32) -> Vec<u8> {
    (0..length).map(|i| (i % 251) as u8 ^ (i >> 9) as u8).collect()
}

fn read(source: &RemoteSource, at: u64, length: usize) -> std::io::Result<Vec<u8>> {
    let mut buffer = vec![0; length];
    source.read_exact_at(at, &mut buffer)?;
    Ok(buffer)
}

/// Every read at `at` of `length` bytes is what the file holds.
#[track_caller]
fn same(source: &RemoteSource, file: &[u8], at: u64, length: usize) {
    let found = read(source, at, length).expect("the server is good");
    assert!(found == file[at as usize..at as usize + length], "{length} bytes at {at}");
}

#[test]
fn a_small_file_takes_one_request() {
    for length in [1, 100, HEAD as u32 - 1, HEAD as u32] {
        let file = bytes(length);
        let server = Server::of(Served::tagged(file.clone(), "\"a\""));
        let source = open(&server).expect("the server is good");
        assert_eq!(source.len_bytes().expect("known"), u64::from(length));
        same(&source, &file, 0, length as usize);
        same(&source, &file, u64::from(length), 0);
        assert_eq!(server.ranges(), [(0, HEAD - 1)]);
        assert_eq!((source.traffic().requests, source.traffic().bytes), (1, u64::from(length)));
    }
}

#[test]
fn any_read_gives_the_bytes_of_the_file() {
    let file = bytes(9_000_000);
    let server = Server::of(Served::tagged(file.clone(), "\"a\""));
    let source = open(&server).expect("the server is good");
    let mut random = 1u64;
    for _ in 0..60 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let at = (random >> 20) % 9_000_000;
        let length = ((random >> 50) * 37).min(9_000_000 - at);
        same(&source, &file, at, length as usize);
    }
    same(&source, &file, 0, 9_000_000);
    for (at, length) in [(8_999_999, 2), (9_000_000, 1), (u64::MAX, 1), (u64::MAX - 1, 9)] {
        assert!(read(&source, at, length).is_err(), "{length} at {at}");
    }
}

#[test]
fn neighbours_are_fetched_together_and_lone_bytes_alone() {
    let file = bytes(6_000_000);
    let server = Server::of(Served::tagged(file.clone(), "\"a\""));
    let source = open(&server).expect("the server is good");
    (65_536..1_000_000).step_by(1000).for_each(|at| same(&source, &file, at, 1000));
    let sizes: Vec<u64> = server.ranges()[1..].iter().map(|(first, last)| (last - first + 1) >> 10).collect();
    assert_eq!(sizes, [64, 128, 256, 512]);
    same(&source, &file, 5_000_000, 10);
    assert_eq!(server.ranges()[5..], [(5_000_000, 5_004_095)]);
    let requests = source.traffic().requests;
    same(&source, &file, 500_000, 1000);
    assert_eq!((source.traffic().requests, requests), (6, 6), "it is kept");
}

#[test]
fn a_library_of_several_megabytes_opens_with_its_tables_alone() {
    let file = forest(&["oak", "pine"], 64, 1);
    assert!(file.len() > 6_000_000);
    let server = Server::of(Served::tagged(file, "\"a\""));
    let library = Library::open_remote(&url(&server, "/oak.flb"), &settings()).expect("a good file");
    assert_eq!(library.find_species("pine"), Some(1));
    let traffic = library.traffic().expect("it is remote");
    assert_eq!((traffic.requests, traffic.bytes), (1, HEAD));

    let found = library.container().read_field(library.source(), 1, BASES[1]).expect("a good file");
    assert_eq!(found, field(64, BASES[1], 2));
    let traffic = library.traffic().expect("it is remote");
    let base = 64u64.pow(3) * 4;
    assert!(traffic.bytes < HEAD + base + (1 << 20) && traffic.requests < 8, "{traffic:?}");
}

#[test]
fn later_requests_ask_for_the_file_that_was_opened() {
    let date = "Sun, 22 Nov 2026 05:00:00 GMT";
    let file = bytes(200_000);
    let tagged = Served::tagged(file.clone(), "\"a\"");
    let dated = Served { bytes: file.clone(), e_tag: None, modified: Some(date.to_owned()) };
    let weak = Served { e_tag: Some("W/\"a\"".to_owned()), ..dated.clone() };
    let nameless = Served { bytes: file.clone(), ..Served::default() };
    for (served, header, value) in [
        (tagged, "if-match", Some("\"a\"")),
        (dated, "if-unmodified-since", Some(date)),
        (weak, "if-unmodified-since", Some(date)),
        (nameless, "if-match", None),
    ] {
        let server = Server::of(served);
        let source = open(&server).expect("the server is good");
        same(&source, &file, 150_000, 1000);
        let requests = server.requests();
        assert_eq!(requests[0].headers.get(header), None, "nothing is known yet");
        assert_eq!(requests[1].headers.get(header).map(String::as_str), value);
    }
}

/// Answers with the first file until `switch` requests have come, with the second from then on.
fn switching(before: Served, after: Served, switch: usize, conditions: bool) -> Server {
    Server::start(move |request| {
        let file = if request.number < switch { &before } else { &after };
        let mut request = request.clone();
        if !conditions {
            request.headers.retain(|name, _| !name.starts_with("if-"));
        }
        file.reply(&request)
    })
}

#[test]
fn a_file_replaced_between_requests_is_found() {
    let old = bytes(200_000);
    let tagged = |bytes: &[u8], tag| Served::tagged(bytes, tag);
    let dated = |bytes: &[u8], second: u8| Served {
        bytes: bytes.to_vec(),
        e_tag: None,
        modified: Some(format!("Sun, 22 Nov 2026 05:00:0{second} GMT")),
    };
    let same_length = vec![7; old.len()];
    for (before, after, expected, found) in [
        (
            tagged(&old, "\"a\""),
            tagged(&same_length, "\"b\""),
            "ETag \"a\" of 200000 bytes",
            "ETag \"b\" of 200000 bytes",
        ),
        (tagged(&old, "\"a\""), tagged(&old[..180_000], "\"a\""), "of 200000 bytes", "of 180000 bytes"),
        (tagged(&old, "W/\"a\""), tagged(&same_length, "W/\"b\""), "ETag W/\"a\"", "ETag W/\"b\""),
        (tagged(&old, "\"a\""), dated(&same_length, 2), "ETag \"a\"", "changed at 2026-11-22 05:00:02 UTC"),
        (dated(&old, 1), dated(&same_length, 2), "changed at 2026-11-22 05:00:01 UTC", "05:00:02 UTC"),
    ] {
        for conditions in [true, false] {
            let server = switching(before.clone(), after.clone(), 1, conditions);
            let source = open(&server).expect("the first answer is whole");
            let error = read(&source, 150_000, 100).expect_err("it was replaced");
            let message = error.to_string();
            assert!(is_replaced(&error), "{message}");
            assert!(message.starts_with("replaced while it was read: found "), "{message}");
            assert!(message.contains(expected), "{message}");
            assert!(message.contains(found) || message.contains("another file (answer 412)"), "{message}");
            assert!(
                !conditions
                    || message.contains("412")
                    || before.e_tag == after.e_tag
                    || before.e_tag.as_ref().is_some_and(|tag| tag.starts_with('W')),
                "{message}"
            );
        }
    }
    let server = switching(tagged(&old, "\"a\""), tagged(&old[..100_000], "\"a\""), 1, true);
    let error = read(&open(&server).expect("whole"), 150_000, 100).expect_err("it was replaced");
    assert!(is_replaced(&error) && error.to_string().contains("a shorter file (answer 416)"), "{error}");
}

#[test]
fn an_operation_on_a_replaced_file_starts_again_with_the_new_one() {
    let [old, new] = [1, 2].map(|seed| forest(&["oak"], 64, seed));
    for (switch, tries) in [(1, 2), (2, 2), (9, 1)] {
        let server = switching(
            Served::tagged(old.clone(), "\"a\""),
            Served::tagged(new.clone(), "\"b\""),
            switch,
            true,
        );
        let url = url(&server, "/oak.flb");
        let told = Mutex::new(0);
        let found = retry_replaced(
            || -> Result<_, RuntimeError> {
                let library = Library::open_remote(&url, &settings())?;
                let field = library.container().read_field(library.source(), 0, 7);
                field.map_err(|error| RuntimeError::Format {
                    path: library.path().into(),
                    source: Box::new(error),
                })
            },
            |error| is_replaced(error),
            |_| *told.lock().expect("one thread") += 1,
        );
        let seed = if tries == 2 { 2 } else { 1 };
        assert_eq!(found.expect("the second try is whole"), field(64, 7, seed), "{switch}");
        assert_eq!(*told.lock().expect("one thread"), tries - 1);
    }
}

#[test]
fn a_server_without_ranges_is_refused_before_its_body_is_read() {
    // The body never comes, so a reader that waits for it fails by the limit instead.
    let endless = Server::start(|_| {
        Reply { length: Some(1 << 40), ..Reply::new(200, bytes(5000)) }.with("ETag", "\"a\"")
    });
    let message = refused(&endless);
    assert!(
        message.contains(
            "/oak.flb: cannot read: bytes 0 to 65535: found the answer 200 with the whole file, expected 206"
        ),
        "{message}"
    );
    assert_eq!(endless.requests().len(), 1);
}

#[test]
fn bodies_of_the_wrong_length_are_refused() {
    let file = bytes(200_000);
    let with_length = |taken: usize, length: u64, tag: bool| {
        let file = file.clone();
        Server::start(move |request| {
            let reply = Served {
                e_tag: tag.then(|| "\"a\"".to_owned()),
                ..Served { bytes: file.clone(), ..Served::default() }
            }
            .reply(request);
            let mut body = reply.body.clone();
            body.resize(taken, 0);
            Reply { body, length: Some(length), ..reply }
        })
    };
    let ended = refused(&with_length(1000, 1000, true));
    assert!(ended.ends_with("bytes 0 to 65535: found 1000 bytes, expected 65536"), "{ended}");
    let cut = refused(&with_length(1000, HEAD, false));
    assert!(cut.contains("bytes 0 to 65535: found 1000 bytes, expected 65536 ("), "{cut}");
    assert!(cut.matches("body error").count() <= 1, "{cut}");
    let more = refused(&with_length(70_000, 70_000, true));
    assert!(more.contains("found 65537 bytes, expected 65536"), "{more}");
}

#[test]
fn a_body_that_was_cut_is_read_on_from_where_it_ended() {
    let file = bytes(200_000);
    let served = Served::tagged(file.clone(), "\"a\"");
    let server = Server::start(move |request| {
        let reply = served.reply(request);
        match request.number {
            0 => Reply { body: reply.body[..1000].to_vec(), length: Some(HEAD), ..reply },
            _ => reply,
        }
    });
    let source = open(&server).expect("the second answer has the rest");
    same(&source, &file, 0, 60_000);
    assert_eq!(server.ranges(), [(0, HEAD - 1), (1000, HEAD - 1)]);
    assert_eq!((source.traffic().requests, source.traffic().bytes), (2, HEAD));
}

#[test]
fn answers_that_are_no_ranges_are_named() {
    let status = |status: u16| Server::start(move |_| Reply::new(status, "<html>a page of words</html>"));
    for (code, words) in
        [(404, "404 Not Found"), (403, "403 Forbidden"), (401, "401 Unauthorized"), (400, "400 Bad Request")]
    {
        let server = status(code);
        let message = refused(&server);
        assert!(
            message.ends_with(&format!(
                "bytes 0 to 65535: found the answer {words}, expected 206 with this range"
            )),
            "{message}"
        );
        assert_eq!(server.requests().len(), 1, "{words}: no second try");
    }
    let empty = Server::of(Served::tagged("", "\"a\""));
    assert!(matches!(open(&empty), Err(RuntimeError::Empty { .. })));
    let range =
        |text: &'static str| Server::start(move |_| Reply::new(206, vec![0; 10]).with("Content-Range", text));
    for bad in ["bytes 0-18446744073709551615/18446744073709551615", "bytes 0-9/*", "", "bytes 9-0/10"] {
        let message = refused(&range(bad));
        assert!(
            message.ends_with(&format!("found the Content-Range {bad:?}, expected this range")),
            "{message}"
        );
    }
    let other = refused(&range("bytes 10-19/30"));
    assert!(
        other.contains("bytes 0 to 65535: found the Content-Range \"bytes 10-19/30\", expected"),
        "{other}"
    );
}

#[test]
fn the_answer_416_is_a_verdict_only_with_a_length_that_fits_it() {
    let file = bytes(200_000);
    let answer = |number: usize, content_range: Option<&'static str>| {
        let served = Served::tagged(file.clone(), "\"a\"");
        Server::start(move |request| match (request.number == number, content_range) {
            (true, Some(content_range)) => Reply::new(416, "").with("Content-Range", content_range),
            (true, None) => Reply::new(416, ""),
            (false, _) => served.reply(request),
        })
    };
    for (content_range, says) in [
        (Some("bytes */200000"), "for a file of 200000 bytes"),
        (Some("bytes */+0"), "without the file's length"),
        (None, "without the file's length"),
    ] {
        let says =
            format!(" found the answer 416 Range Not Satisfiable {says}, expected 206 with this range");
        let message = refused(&answer(0, content_range));
        assert!(message.contains("bytes 0 to 65535:") && message.ends_with(&says), "{message}");
        let error = read(&open(&answer(1, content_range)).expect("whole"), 150_000, 9).expect_err("refused");
        assert!(!is_replaced(&error) && error.to_string().ends_with(&says), "{error}");
    }
    assert!(matches!(open(&answer(0, Some("bytes */0"))), Err(RuntimeError::Empty { .. })));
    let error = read(&open(&answer(1, Some("bytes */9"))).expect("whole"), 150_000, 9).expect_err("refused");
    assert!(is_replaced(&error), "{error}");
}

#[test]
fn a_refused_rest_of_a_body_is_named_by_its_own_range() {
    let served = Served::tagged(bytes(200_000), "\"a\"");
    let server = Server::start(move |request| match request.number {
        0 => {
            let reply = served.reply(request);
            Reply { body: reply.body[..1000].to_vec(), length: Some(HEAD), ..reply }
        }
        _ => Reply::new(403, ""),
    });
    let message = refused(&server);
    assert!(
        message
            .ends_with(" bytes 1000 to 65535: found the answer 403 Forbidden, expected 206 with this range")
    );
}

#[test]
fn a_header_beyond_ascii_is_named() {
    for (name, says) in
        [("ETag", "found the ETag \"\\\"é\\\"\""), ("Last-Modified", "found the Last-Modified")]
    {
        let served = Served { bytes: bytes(100), ..Served::default() };
        let message = refused(&Server::start(move |request| served.reply(request).with(name, "\"é\"")));
        assert!(message.contains(says) && message.ends_with(", expected visible ASCII"), "{message}");
    }
}

#[test]
fn an_error_body_without_end_is_not_read() {
    let server = Server::start(|_| Reply { length: Some(1 << 40), ..Reply::new(404, bytes(5000)) });
    assert!(refused(&server).contains("404 Not Found"));
}

#[test]
fn passing_failures_are_tried_again() {
    let file = bytes(200_000);
    for status in [500, 503, 429, 408] {
        let served = Served::tagged(file.clone(), "\"a\"");
        let server = Server::start(move |request| match request.number {
            0 | 2 => Reply::new(status, "not now"),
            _ => served.reply(request),
        });
        let source = open(&server).expect("the second answer is good");
        same(&source, &file, 150_000, 10);
        assert_eq!((server.requests().len(), source.traffic().requests), (4, 4), "{status}");
    }
}

#[test]
fn lasting_failures_end() {
    let server = Server::start(|_| Reply::new(500, "not now"));
    let few = RemoteSettings { retries: 2, ..settings() };
    let error = RemoteSource::open(&url(&server, "/oak.flb"), &few).err().expect("refused").to_string();
    assert!(error.contains("found the answer 500 Internal Server Error, expected 206"), "{error}");
    assert_eq!(server.requests().len(), 3);

    let port =
        std::net::TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address").port();
    let Ok(Location::Remote(nobody)) = Location::parse(format!("http://127.0.0.1:{port}/oak.flb")) else {
        panic!()
    };
    let error = RemoteSource::open(&nobody, &few).err().expect("refused").to_string();
    assert!(
        error.contains("/oak.flb: cannot read: bytes 0 to 65535: ") && error.contains("refused"),
        "{error}"
    );
}

#[test]
fn a_slow_server_is_asked_again_and_given_up_within_the_limit() {
    let served = Served::tagged(bytes(100), "\"a\"");
    let sometimes = |slow: fn(&Request) -> bool| {
        let served = served.clone();
        Server::start(move |request| {
            let delay = if slow(request) { Duration::from_secs(30) } else { Duration::ZERO };
            served.reply(request).after(delay)
        })
    };
    let hasty = RemoteSettings { idle: Duration::from_secs(1), limit: Duration::from_secs(4), ..settings() };
    let once = sometimes(|request| request.number == 0);
    RemoteSource::open(&url(&once, "/oak.flb"), &hasty).expect("the second answer is quick");
    assert_eq!(once.requests().len(), 2);

    let always = sometimes(|_| true);
    let error =
        RemoteSource::open(&url(&always, "/oak.flb"), &RemoteSettings { retries: 100, ..hasty.clone() });
    let error = error.err().expect("refused").to_string();
    assert!(error.ends_with("bytes 0 to 65535: found no whole answer after 4 s"), "{error}");
    let error = RemoteSource::open(&url(&always, "/oak.flb"), &RemoteSettings { retries: 0, ..hasty });
    let error = error.err().expect("refused").to_string();
    assert!(error.contains("timed out"), "{error}");
}

#[test]
fn redirects_are_followed_and_loops_are_not() {
    let file = bytes(200_000);
    let served = Served::tagged(file.clone(), "\"a\"");
    let server = Server::start(move |request| match request.path.as_str() {
        "/oak.flb" => Reply::new(302, "").with("Location", "/elsewhere/oak.flb"),
        "/loop.flb" => Reply::new(302, "").with("Location", "/loop.flb"),
        _ => served.reply(request),
    });
    let source = open(&server).expect("the server is good");
    same(&source, &file, 150_000, 10);
    assert_eq!(server.requests().len(), 4);
    assert_eq!(server.requests()[3].headers.get("if-match").map(String::as_str), Some("\"a\""));
    let error =
        RemoteSource::open(&url(&server, "/loop.flb"), &settings()).err().expect("refused").to_string();
    assert!(error.contains("redirect 11: found another redirect, expected the file after 10"), "{error}");
}

#[test]
fn queries_are_sent_and_never_shown() {
    let server = Server::start(|_| Reply::new(403, "secret"));
    let url = url(&server, "/a%20b.flb?X-Amz-Signature=secret&x=1");
    let error = RemoteSource::open(&url, &settings()).err().expect("refused").to_string();
    assert!(error.contains("/a%20b.flb?...: ") && !error.contains("secret"), "{error}");
    assert_eq!(server.requests()[0].path, "/a%20b.flb?X-Amz-Signature=secret&x=1");
}

#[test]
fn threads_and_asynchronous_programs_may_share_a_source() {
    let file = Arc::new(bytes(3_000_000));
    let server = Server::of(Served::tagged(file.to_vec(), "\"a\""));
    let source = Arc::new(open(&server).expect("the server is good"));
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let (source, file) = (&source, &file);
            scope.spawn(move || {
                (0..30).for_each(|i| same(source, file, (i * 97_001 + thread * 31) % 2_900_000, 70_000))
            });
        }
    });
    let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
    runtime.block_on(async {
        let source = open(&server).expect("the server is good");
        same(&source, &file, 2_000_000, 1000);
    });
}
