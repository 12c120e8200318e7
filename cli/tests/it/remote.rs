//! Commands on files behind URLs, served by a thread of the test.
#![cfg(feature = "remote")]

use std::path::Path;

use flb_testkit::server::{Reply, Served, Server};
use serde_json::{Value, json};

use crate::flb::{Folder, PAPER, Run, SMALL};
use crate::schema::{misfits, schema};

/// Straight to the server, whatever proxy this machine uses; no credentials but a test's own.
const HERE: [(&str, &str); 2] = [("NO_PROXY", "127.0.0.1"), ("no_proxy", "127.0.0.1")];

fn flb(folder: &Folder, words: &[&str]) -> Run {
    folder.flb_in(&HERE, words)
}

fn serve(file: Vec<u8>) -> Server {
    Server::of(Served::tagged(file, "\"a\""))
}

fn bytes_served(server: &Server) -> u64 {
    server.ranges().iter().map(|(first, last)| last - first + 1).sum()
}

/// A library of two species of plain floats, `forest.flb`, several megabytes long; with it `shrub.glb`.
fn forest() -> Folder {
    let folder = Folder::with_plants(&["shrub"]);
    for name in ["shrub", "other"] {
        let (flb, fields) = (format!("{name}-coded.flb"), format!("{name}.flb"));
        let bake = ["bake", "shrub.glb", "--name", name, "-o", &flb, "--keep-fields", &fields];
        folder.flb_with(&bake, &[&SMALL[..], &PAPER].concat()).expect_code(0);
    }
    folder.flb(&["pack", "shrub.flb", "other.flb", "-o", "forest.flb"]).expect_code(0);
    folder
}

#[test]
fn a_library_behind_a_url_is_read_like_a_file_and_no_more_than_needed() {
    let folder = forest();
    let file = folder.read("forest.flb");
    assert!(file.len() > 5_000_000, "{}", file.len());
    let server = || serve(file.clone());

    let info = server();
    let (url, local) =
        (info.url("/forest.flb"), folder.flb(&["info", "forest.flb", "--json"]).expect_code(0).json());
    let run = flb(&folder, &["info", &url, "--json"]).expect_code(0);
    let mut found = run.json();
    assert_eq!(misfits(&schema("info"), &found), [""; 0]);
    assert_eq!((&found["file"], &found["remote"]), (&json!(url), &json!({"requests": 1, "bytes": 65536})));
    assert_eq!((info.requests().len(), bytes_served(&info)), (1, 65536));
    assert!(run.stderr.contains(&format!("{url}: read 65536 bytes in 1 request\n")), "{}", run.stderr);
    (found["file"], found["remote"]) = (json!("forest.flb"), Value::Null);
    assert_eq!(found, local);

    let validate = server();
    let url = validate.url("/forest.flb");
    let run = flb(&folder, &["validate", &url, "--json"]).expect_code(0).json();
    assert_eq!((&run["valid"], &run["files"][0]["file"]), (&json!(true), &json!(url)));
    assert_eq!(bytes_served(&validate), file.len() as u64, "every byte once");
    flb(&folder, &["validate", &url, "--level", "tables"]).expect_code(0);
    assert_eq!(bytes_served(&validate), file.len() as u64 + 65536);

    let extract = server();
    let words = ["--species", "other", "--base", "4", "--format", "npy", "-o"];
    folder.flb_with(&["extract", "forest.flb"], &[&words[..], &["local.npy"]].concat()).expect_code(0);
    let url = extract.url("/forest.flb");
    flb(&folder, &[&["extract", &url][..], &words, &["remote.npy"]].concat()).expect_code(0);
    assert_eq!(folder.read("remote.npy"), folder.read("local.npy"));
    assert!(bytes_served(&extract) < 65536 + folder.read("local.npy").len() as u64 + (1 << 20));

    let url = server().url("/forest.flb");
    flb(&folder, &["diff", &url, "forest.flb"]).expect_code(0);
    flb(&folder, &["diff", "shrub.flb", &url]).expect_code(1);

    folder.flb(&["pack", "forest.flb", "--codec", "raw-f16", "-o", "local.flb"]).expect_code(0);
    flb(&folder, &["pack", &url, "--codec", "raw-f16", "-o", "remote.flb"]).expect_code(0);
    assert!(folder.read("remote.flb") == folder.read("local.flb"));

    let words = ["--mesh", "shrub.glb", "--sun", "90,30", "--size", "16x16", "-o"];
    folder.flb_with(&["render", "forest.flb"], &[&words[..], &["local.png"]].concat()).expect_code(0);
    flb(&folder, &[&["render", &url][..], &words, &["remote.png"]].concat()).expect_code(0);
    assert!(folder.read("remote.png") == folder.read("local.png"));
}

#[test]
fn a_file_that_is_replaced_is_read_again_from_the_start() {
    let folder = Folder::with_plants(&["leaf-card"]);
    for (name, flags) in [("old", "64"), ("new", "128")] {
        let (flb, fields) = (format!("{name}-coded.flb"), format!("{name}.flb"));
        let bake = [
            "bake",
            "leaf-card.glb",
            "-o",
            &flb,
            "--keep-fields",
            &fields,
            "--lattice",
            "32",
            "--voxels",
            flags,
        ];
        folder.flb_with(&bake, &PAPER).expect_code(0);
    }
    let (old, new) = (folder.read("old.flb"), folder.read("new.flb"));
    assert!(old != new && old.len() > 200_000);
    let what = ["--base", "18", "--format", "npy", "-o"];
    folder.flb_with(&["extract", "new.flb"], &[&what[..], &["new.npy"]].concat()).expect_code(0);

    let switching = |every: bool| {
        let files = [Served::tagged(old.clone(), "\"old\""), Served::tagged(new.clone(), "\"new\"")];
        Server::start(move |request| {
            files[if every { request.number % 2 } else { request.number.min(1) }].reply(request)
        })
    };
    let once = switching(false);
    let url = once.url("/a.flb");
    let says = format!("{url}: FLB-1000 ");
    let run = flb(&folder, &[&["extract", &url][..], &what, &["found.npy"]].concat()).expect_code(0);
    run.says(&[
        &says,
        "replaced while it was read: found another file (answer 412), expected ETag \"old\"",
        "reading it again",
    ]);
    assert_eq!(folder.read("found.npy"), folder.read("new.npy"));
    let once = switching(false);
    flb(&folder, &["validate", &once.url("/a.flb")])
        .expect_code(0)
        .says(&["replaced while it was read", "reading it again"]);

    // A file that is another with every request: three times, then the error stands.
    let always = switching(true);
    let url = always.url("/a.flb");
    let before = folder.names();
    let run = flb(&folder, &[&["extract", &url][..], &what, &["never.npy"]].concat()).expect_code(4);
    assert_eq!(run.stderr.matches("replaced while it was read").count(), 3, "{}", run.stderr);
    assert_eq!(run.stderr.matches("reading it again").count(), 2, "{}", run.stderr);
    assert_eq!(folder.names(), before);
    let run = flb(&folder, &["validate", &url, "--json"]).expect_code(4).json();
    let error = run["files"][0]["error"].as_str().expect("a reason");
    assert!(error.starts_with("FLB-1000 ") && error.contains("replaced while it was read"), "{run}");

    // The tables come, and then nothing does: that is no verdict either.
    let ends = Server::start(move |request| match request.number {
        0 => Served::tagged(old.clone(), "\"old\"").reply(request),
        _ => Reply::new(404, ""),
    });
    let run = flb(&folder, &["validate", &ends.url("/a.flb"), "--json"]).expect_code(4).json();
    assert_eq!((&run["valid"], &run["issues"]), (&Value::Null, &json!([])), "{run}");
    assert!(run["files"][0]["error"].as_str().is_some_and(|error| error.contains("404 Not Found")), "{run}");
}

#[test]
fn failures_are_input_output_and_name_url_range_and_both_sides() {
    let folder = Folder::with_card();
    let card = folder.read("card.flb");
    let missing = Server::start(|_| Reply::new(404, "a page of words"));
    let whole = Server::start(move |_| Reply::new(200, vec![0; 100]));
    for command in ["info", "validate"] {
        for (server, says) in [
            (&missing, "found the answer 404 Not Found, expected 206 with this range"),
            (&whole, "found the answer 200 with the whole file, expected 206 with this range"),
        ] {
            let url = server.url("/oak.flb");
            flb(&folder, &[command, &url]).expect_code(4).says(&[&url, "bytes 0 to 65535: ", says]);
        }
    }
    let empty = serve(Vec::new()).url("/oak.flb");
    flb(&folder, &["info", &empty]).expect_code(1).says(&["the file has 0 bytes"]);
    let run = flb(&folder, &["validate", &empty]).expect_code(1);
    assert!(run.stdout.contains("FLB-1001"), "{}", run.stdout);
    let cut = serve(card[..card.len() - 1].to_vec()).url("/card.flb");
    for command in ["info", "validate"] {
        let run = flb(&folder, &[command, &cut]).expect_code(1);
        assert!((run.stdout + &run.stderr).contains("FLB-1"));
    }
    let busy = Server::start(move |request| match request.number {
        0 => Reply::new(500, "not now"),
        _ => Served::tagged(card.clone(), "\"a\"").reply(request),
    });
    flb(&folder, &["info", &busy.url("/card.flb")]).expect_code(0).says(&["in 2 requests"]);
}

#[test]
fn urls_that_name_no_file_are_usage_errors_and_secrets_are_never_printed() {
    let folder = Folder::with_card();
    for url in [
        "ftp://host/a.flb",
        "s3://bucket",
        "http://user:secret@127.0.0.1:1/a.flb",
        "https://secret@host/a.flb",
    ] {
        for words in
            [&["info", url][..], &["validate", url], &["diff", url, url], &["pack", url, "-o", "x.flb"]]
        {
            let run = flb(&folder, words).expect_code(2);
            assert!(!(run.stdout + &run.stderr).contains("secret"), "{url}");
        }
    }
    let server = serve(folder.read("card.flb"));
    let (url, name) = (server.url("/card.flb?X-Amz-Signature=secret"), server.url("/card.flb?..."));
    let what = ["--format", "npy", "-o", "x.npy"];
    for (words, code) in [
        (&["info", &url, "--json"][..], 0),
        (&["info", &url], 0),
        (&["validate", &url], 0),
        (&["validate", &url, "--json"], 0),
        (&["diff", &url, &url, "--json"], 0),
        (&[&["extract", &url, "--species", "nobody", "--base", "1"][..], &what].concat(), 2),
        (&[&["extract", &url, "--base", "30"][..], &what].concat(), 2),
        (&["pack", &url, &url, "-o", "x.flb"], 2),
        (&["render", &url, "--mesh", "leaf-card.glb", "--sun", "1,1", "--path-traced", "-o", "x.png"], 2),
    ] {
        let run = flb(&folder, words).expect_code(code);
        let said = run.stdout + &run.stderr;
        assert!(!said.contains("secret"), "{words:?}: {said}");
        assert!(code == 0 || words[0] == "pack" || said.contains(&name), "{words:?}: {said}");
    }
    assert!(server.requests().iter().all(|request| request.path == "/card.flb?X-Amz-Signature=secret"));
}

#[test]
fn s3_is_read_with_the_credentials_of_the_environment() {
    let folder = Folder::with_card();
    let served = Served::tagged(folder.read("card.flb"), "\"a\"");
    let server = Server::start(move |request| match request.path.as_str() {
        "/bucket/a%20folder/card.flb" => served.reply(request),
        _ => Reply::new(404, "<Error><Code>NoSuchKey</Code></Error>"),
    });
    let endpoint = server.url("");
    let environment = [
        HERE[0],
        HERE[1],
        ("AWS_ENDPOINT", endpoint.as_str()),
        ("AWS_ALLOW_HTTP", "true"),
        ("AWS_REGION", "eu-west-1"),
        ("AWS_ACCESS_KEY_ID", "the-key"),
        ("AWS_SECRET_ACCESS_KEY", "the-secret"),
    ];
    let info =
        folder.flb_in(&environment, &["info", "s3://bucket/a folder/card.flb", "--json"]).expect_code(0);
    assert_eq!(
        info.json()["remote"],
        json!({"requests": 1, "bytes": folder.read("card.flb").len().min(65536)})
    );
    folder.flb_in(&environment, &["validate", "s3://bucket/a%20folder/card.flb"]).expect_code(0);
    for request in server.requests() {
        let signature = &request.headers["authorization"];
        assert!(
            signature.starts_with("AWS4-HMAC-SHA256 Credential=the-key/")
                && signature.contains("/eu-west-1/s3/")
        );
        assert!(request.range().is_some(), "{request:?}");
    }
    let run = folder.flb_in(&environment, &["info", "s3://bucket/other.flb"]).expect_code(4);
    assert!(!run.stderr.contains("the-"), "{}", run.stderr);
    run.says(&["s3://bucket/other.flb: cannot read: bytes 0 to 65535: found the answer 404 Not Found"]);
}

#[test]
fn a_file_that_could_not_be_fetched_has_no_verdict() {
    let folder = Folder::with_card();
    folder.write("bad.flb", "this is no container");
    let missing = Server::start(|_| Reply::new(404, ""));
    for (url, says) in [
        (missing.url("/a.flb"), "found the answer 404 Not Found"),
        (folder.path("none.flb").display().to_string(), "cannot open"),
        (folder.path("").display().to_string(), "expected a regular file"),
        ("http://127.0.0.1:1/a.flb".to_owned(), "refused"),
    ] {
        let run = flb(&folder, &["validate", &url]).expect_code(4);
        assert!(
            run.stdout.contains(&format!("{url}: not read: ")) && run.stdout.contains(says),
            "{}",
            run.stdout
        );
        assert!(!run.stdout.contains("INVALID"), "{}", run.stdout);
        let run = flb(&folder, &["validate", &url, "card.flb", "--json"]).expect_code(4).json();
        assert_eq!(misfits(&schema("validate"), &run), [""; 0]);
        assert_eq!((&run["valid"], &run["issues"]), (&Value::Null, &json!([])), "{run}");
        assert_eq!((&run["files"][0]["valid"], &run["files"][1]["valid"]), (&Value::Null, &json!(true)));
        assert!(run["files"][0]["error"].as_str().is_some_and(|error| error.contains(says)), "{run}");
        let run = flb(&folder, &["validate", &url, "bad.flb", "--json"]).expect_code(4).json();
        assert_eq!((&run["valid"], &run["files"][1]["error"]), (&json!(false), &Value::Null), "{run}");
    }
}

#[test]
fn file_urls_are_files() {
    let folder = Folder::with_card();
    let url = format!("file://{}", folder.path("card.flb").display());
    let [by_url, by_name] = [&url, "card.flb"].map(|file| folder.flb(&["info", file]).expect_code(0).stdout);
    assert_eq!(by_url, by_name);
    let run = folder.flb(&["pack", &url, "-o", "card.flb", "--force"]).expect_code(2);
    run.says(&["input"]);
    folder
        .flb(&["info", "file:///no/such/card.flb"])
        .expect_code(4)
        .says(&["/no/such/card.flb: cannot open"]);
}

#[test]
fn plain_http_needs_no_certificates() {
    let folder = Folder::with_card();
    let server = serve(folder.read("card.flb"));
    let nowhere = folder.path("nowhere");
    let nowhere = Path::new(&nowhere).to_str().expect("a plain name");
    let environment = [HERE[0], HERE[1], ("SSL_CERT_FILE", nowhere), ("SSL_CERT_DIR", nowhere)];
    folder.flb_in(&environment, &["info", &server.url("/card.flb")]).expect_code(0);
    let https = server.url("/card.flb").replace("http:", "https:");
    folder.flb_in(&environment, &["info", &https]).expect_code(4).says(&["certificates"]);
}
