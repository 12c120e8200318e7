//! A cache in a bucket of s3, which two builders share: `moto`, a server of s3 in memory, is the bucket.
#![cfg(feature = "remote")]

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::flb::{Folder, Run, names_in, python};
use crate::library::MANIFEST;
use crate::schema::{misfits, schema};

const CACHE: &str = "s3://plants/results";
const SIGNATURE: &str =
    "AWS4-HMAC-SHA256 Credential=test/20261128/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0";
const SECRET: &str = "c0ffee5ec2e7";

/// The server; gone when dropped.
struct Server {
    child: Child,
    address: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill(); // it may have ended
        let _ = self.child.wait();
    }
}

impl Server {
    /// With the bucket "plants". After so many requests every one must be signed by a user that the server knows, and
    /// it knows none.
    fn start(open_requests: Option<&str>) -> Server {
        let free = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address");
        let mut command = python("moto.server", &["-H", "127.0.0.1", "-p", &free.port().to_string()]);
        if let Some(count) = open_requests {
            command.env("INITIAL_NO_AUTH_ACTION_COUNT", count);
        }
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("Python");
        let server = Server { child, address: free.to_string() };
        let begin = Instant::now();
        while TcpStream::connect(&server.address).is_err() {
            assert!(begin.elapsed() < Duration::from_secs(60), "the server does not start");
            thread::sleep(Duration::from_millis(50));
        }
        assert!(server.ask("PUT", "/plants", b"").starts_with("HTTP/1.1 200"), "a bucket");
        server
    }

    /// A request with a signature that no one checks, and its answer.
    fn ask(&self, method: &str, path: &str, body: &[u8]) -> String {
        let mut stream = TcpStream::connect(&self.address).expect("it listens");
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nAuthorization: {SIGNATURE}\r\nContent-Length: {}\r\n\
             Connection: close\r\n\r\n",
            self.address,
            body.len()
        );
        stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body)).expect("it reads");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("it answers");
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn flb(&self, folder: &Folder, words: &[&str]) -> Run {
        let endpoint = format!("http://{}", self.address);
        let environment = [
            ("AWS_ACCESS_KEY_ID", "builder"),
            ("AWS_SECRET_ACCESS_KEY", SECRET),
            ("AWS_REGION", "us-east-1"),
            ("AWS_ENDPOINT", &endpoint),
            ("AWS_ALLOW_HTTP", "true"),
        ];
        let run = folder.flb_in(&environment, words);
        assert!(!run.stderr.contains(SECRET) && !run.stdout.contains(SECRET), "{}", run.stderr);
        run
    }

    fn build(&self, folder: &Folder, cache: &str) -> Run {
        self.flb(folder, &["library", "build", "--cache", cache])
    }
}

fn farm() -> Folder {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write("library.toml", MANIFEST);
    folder
}

/// The library of the manifest as a build without a bucket leaves it.
fn expected() -> Vec<u8> {
    let folder = farm();
    folder.flb(&["library", "build"]).expect_code(0);
    folder.read("library/library.flb")
}

#[test]
fn builders_share_a_bucket_and_what_is_damaged_there_is_made_again() {
    let (server, expected) = (Server::start(None), expected());
    // Two at once, each of whom finds what the other has made.
    let folders = [farm(), farm()];
    thread::scope(|scope| {
        for folder in &folders {
            scope.spawn(|| server.build(folder, CACHE).expect_code(0));
        }
    });
    for folder in &folders {
        assert!(folder.read("library/library.flb") == expected, "the same bytes as without a bucket");
        let own = names_in(&folder.path(".flb-cache"));
        assert!(own.iter().all(|name| name == "digests.json"), "what is of this machine alone: {own:?}");
    }

    // A third does nothing.
    let third = farm();
    let run = server.build(&third, CACHE).expect_code(0);
    assert!(run.stdout.contains("0 baked, 2 from the cache, 0 as they were"), "{}", run.stdout);
    assert!(third.read("library/library.flb") == expected);
    let bake =
        ["bake", "shrub.glb", "-o", "own.flb", "--quality", "draft", "--lattice", "16", "--voxels", "64"];
    let run = server.flb(&third, &[&bake[..], &["--cache", CACHE, "--json"]].concat()).expect_code(0).json();
    let solves = run["stages"].as_array().expect("a list").iter().filter_map(|one| one["solves"].as_array());
    assert!(solves.flatten().map(|one| &one["cached"]).eq([&json!(true)]), "{run}");

    // Care.
    let list = |words: &[&str]| server.flb(&third, &[&["cache"], words, &[CACHE, "--json"]].concat());
    let listed = list(&["list"]).expect_code(0).json();
    assert_eq!(misfits(&schema("cache"), &listed), [""; 0], "{listed}");
    let all = listed["list"].as_array().expect("a list").clone();
    let species: Vec<&str> = all.iter().filter_map(|one| one["species"].as_str()).collect();
    assert_eq!(species.len(), 2, "{listed}");
    assert_eq!(list(&["verify"]).expect_code(0).json()["damaged"], json!([]));

    // Two entries have other bytes than were kept: a species, and what a stage has made.
    let of = |kind: &str| {
        all.iter().find(|one| one["kind"] == kind).expect(kind)["name"].as_str().expect("a name")
    };
    let (species, stage) = (format!("{}.flb", of("species")), format!("{}.artefact", of("occupancy")));
    for name in [&species, &stage] {
        let answer = server.ask("PUT", &format!("/plants/results/{name}"), b"other bytes");
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }
    let run = list(&["verify"]);
    assert_eq!(run.expect_code(1).json()["damaged"].as_array().map(Vec::len), Some(2));
    let fourth = farm();
    let run = server.build(&fourth, CACHE).expect_code(0);
    let run = run.says(&[&format!("{CACHE}/{species}: has other bytes than were kept; made again")]);
    assert!(run.stdout.contains("1 baked, 1 from the cache"), "{}", run.stdout);
    assert!(fourth.read("library/library.flb") == expected);
    let run = list(&["verify", "--remove"]).expect_code(0).json();
    assert_eq!(run["damaged"], json!([]), "both were mended");

    let run = list(&["gc", "--older-than", "0h"]).expect_code(0).json();
    assert_eq!((&run["entries"], &list(&["stats"]).expect_code(0).json()["entries"]), (&json!(0), &json!(0)));
}

#[test]
fn tasks_of_engines_name_the_bucket() {
    let (server, expected) = (Server::start(None), expected());
    let folder = farm();
    let program = env!("CARGO_BIN_EXE_flb");
    let emit = ["farm", "emit", "--format", "commands", "-o", "work", "--program", program, "--cache", CACHE];
    server.flb(&folder, &emit).expect_code(0);
    server.flb(&folder, &["task", "run", "work/plan.json", "1"]).expect_code(0);
    std::fs::remove_dir_all(folder.path("library")).expect("it was there");
    let commands = String::from_utf8(folder.read("work/commands.txt")).expect("text");
    let finish = commands.lines().last().and_then(|line| line.rsplit('\t').next()).expect("a command");
    assert!(finish.contains(&format!("--cache {CACHE} ")), "{finish}");
    let words: Vec<&str> = finish.split(' ').skip(1).collect();
    let run = server.flb(&folder, &words).expect_code(0);
    assert!(run.stdout.contains("0 baked, 2 from the cache"), "{}", run.stdout);
    assert!(folder.read("library/library.flb") == expected);
}

#[test]
fn a_bucket_that_cannot_be_used_is_a_warning_and_the_work_goes_on() {
    let (server, expected) = (Server::start(Some("1")), expected());
    let told =
        format!("warning: {CACHE}: the cache cannot be used, and the work goes on without: cannot read");
    let folder = farm();
    let run = server.build(&folder, CACHE).expect_code(0);
    run.says(&[&told, "found the answer 403 Forbidden (InvalidAccessKeyId)"]);
    assert!(folder.read("library/library.flb") == expected);
    let run = server.flb(&folder, &["cache", "stats", CACHE]).expect_code(4);
    run.says(&[&format!("{CACHE}: cannot list the objects: found the answer 403 Forbidden")]);
    drop(server);

    let server = Server::start(None);
    let folder = farm();
    let gone = "s3://gone/results";
    let run = server.build(&folder, gone).expect_code(0);
    run.says(&["warning: s3://gone/results: the cache cannot be used", "(NoSuchBucket)"]);
    assert!(folder.read("library/library.flb") == expected);

    // No server at all, and no place.
    let mut without = server;
    without.child.kill().expect("it runs");
    without.child.wait().expect("it ends");
    let folder = farm();
    without
        .build(&folder, CACHE)
        .expect_code(0)
        .says(&["warning: s3://plants/results: the cache cannot be used"]);
    assert!(folder.read("library/library.flb") == expected);
    for (cache, told) in [
        ("https://host/results?key=c0ffee5ec2e7", "expected a folder or s3://BUCKET/PREFIX"),
        ("s3://plants", "names no object, expected s3://BUCKET/KEY"),
        ("ftp://plants/results", "found the scheme \"ftp\""),
    ] {
        without.build(&folder, cache).expect_code(2).says(&[told]);
    }
}
