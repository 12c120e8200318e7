use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::Mutex;

use async_trait::async_trait;
use http::header::{CONTENT_LENGTH, IF_NONE_MATCH};
use http::{Method, Response, Uri};
use http_body_util::BodyExt;
use object_store::client::{HttpError, HttpErrorKind, HttpRequest, HttpResponse};

use super::super::redirect::Reach;
use super::*;

const SECRET: &str = "c0ffee5ec2e7";

/// A server of s3 in memory, for names below "bucket/results".
#[derive(Debug, Default)]
struct Server {
    objects: Mutex<BTreeMap<String, Vec<u8>>>,
    /// Answers the next request has in place of its own: status and body.
    next: Mutex<Vec<(u16, String)>>,
    asked: Mutex<Vec<String>>,
}

fn answer(status: StatusCode, body: Vec<u8>) -> Result<(HttpResponse, Option<IpAddr>), HttpError> {
    let response = Response::builder()
        .status(status)
        .header(CONTENT_LENGTH, body.len())
        .header("last-modified", "Sat, 28 Nov 2026 12:00:00 GMT")
        .header("etag", "\"a\"")
        .body(body.into());
    Ok((response.expect("a response"), None))
}

#[async_trait]
impl Wire for Server {
    async fn send(
        &self,
        request: HttpRequest,
        _: Reach,
    ) -> Result<(HttpResponse, Option<IpAddr>), HttpError> {
        let (method, uri) = (request.method().clone(), request.uri().clone());
        assert!(request.headers().contains_key("authorization"), "{method} {uri} is not signed");
        self.asked.lock().expect("no panic").push(format!("{method} {}", uri.path()));
        if let Some((status, body)) = self.next.lock().expect("no panic").pop() {
            if status == 0 {
                return Err(HttpError::new(HttpErrorKind::Unknown, std::io::Error::other("the cable")));
            }
            return answer(StatusCode::from_u16(status).expect("a status"), body.into_bytes());
        }
        let name = uri.path().rsplit('/').next().unwrap_or_default().to_owned();
        let is_conditional = request.headers().contains_key(IF_NONE_MATCH);
        let body = request.into_body().collect().await?.to_bytes().to_vec();
        let mut objects = self.objects.lock().expect("no panic");
        let missing = || answer(StatusCode::NOT_FOUND, b"<Error><Code>NoSuchKey</Code></Error>".to_vec());
        match method {
            Method::PUT if is_conditional && objects.contains_key(&name) => {
                answer(StatusCode::PRECONDITION_FAILED, Vec::new())
            }
            Method::PUT => {
                objects.insert(name, body);
                answer(StatusCode::OK, Vec::new())
            }
            Method::GET if uri.query().is_some() => {
                let entry = |(name, bytes): (&String, &Vec<u8>)| {
                    format!(
                        "<Contents><Key>results/{name}</Key><LastModified>2026-11-28T12:00:00.000Z</LastModified>\
                         <ETag>\"a\"</ETag><Size>{}</Size></Contents>",
                        bytes.len()
                    )
                };
                let all: String = objects.iter().map(entry).collect();
                let body = format!("<ListBucketResult><Name>bucket</Name>{all}</ListBucketResult>");
                answer(StatusCode::OK, body.into_bytes())
            }
            Method::GET | Method::HEAD => match objects.get(&name) {
                Some(bytes) => answer(StatusCode::OK, bytes.clone()),
                None if method == Method::HEAD => answer(StatusCode::NOT_FOUND, Vec::new()),
                None => missing(),
            },
            // Several are removed at once: "POST /bucket?delete".
            _ => {
                let asked = String::from_utf8_lossy(&body).into_owned();
                let key = asked.split_once("<Key>").and_then(|(_, rest)| rest.split_once("</Key>"));
                let key = key.expect("a name").0;
                objects.remove(key.strip_prefix("results/").expect("the prefix"));
                let body = format!("<DeleteResult><Deleted><Key>{key}</Key></Deleted></DeleteResult>");
                answer(StatusCode::OK, body.into_bytes())
            }
        }
    }

    fn is_proxied(&self, _: &Uri) -> bool {
        false
    }
}

fn bucket() -> (Bucket, Arc<Server>) {
    let server = Arc::new(Server::default());
    let url = RemoteUrl::parse("s3://bucket/results").expect("a URL");
    let environment = [
        ("AWS_ACCESS_KEY_ID", "key-of-tests"),
        ("AWS_SECRET_ACCESS_KEY", SECRET),
        ("AWS_REGION", "eu-west-1"),
    ];
    let environment = environment.map(|(name, value)| (name.into(), value.into()));
    let wire: Arc<dyn Wire> = Arc::<Server>::clone(&server);
    (Bucket::open_by(&url, environment, Some(wire)).expect("a bucket"), server)
}

#[test]
fn what_is_put_is_got_and_the_first_of_two_stays() {
    let (bucket, server) = bucket();
    assert_eq!(bucket.get("solve-1.artefact"), Ok(None));
    assert_eq!(bucket.has("solve-1.artefact"), Ok(false));
    bucket.create("solve-1.artefact", b"first").expect("room");
    bucket.create("solve-1.artefact", b"second").expect("it is there");
    assert_eq!(bucket.get("solve-1.artefact"), Ok(Some(b"first".to_vec())));
    bucket.replace("solve-1.artefact", b"third").expect("room");
    assert_eq!(bucket.get("solve-1.artefact"), Ok(Some(b"third".to_vec())));
    bucket.create("medium-1.artefact", b"").expect("room");
    assert_eq!(bucket.get("medium-1.artefact"), Ok(Some(Vec::new())));
    assert_eq!(bucket.has("medium-1.artefact"), Ok(true));
    let listed = bucket.list().expect("a list");
    let listed: Vec<(&str, u64)> = listed.iter().map(|one| (one.name.as_str(), one.bytes)).collect();
    assert_eq!(listed, [("medium-1.artefact", 0), ("solve-1.artefact", 5)]);
    bucket.remove("solve-1.artefact").expect("it was there");
    assert_eq!(bucket.has("solve-1.artefact"), Ok(false));
    assert_eq!(bucket.traffic(), [13, 10, 16]);
    assert!(server.asked.lock().expect("no panic").iter().all(|asked| asked.contains("/bucket")));
}

#[test]
fn a_server_without_the_condition_is_written_to() {
    let (bucket, server) = bucket();
    server.next.lock().expect("no panic").push((501, "<Code>NotImplemented</Code>".to_owned()));
    bucket.create("solve-1.artefact", b"first").expect("room");
    assert_eq!(bucket.get("solve-1.artefact"), Ok(Some(b"first".to_vec())));
}

#[test]
fn failures_are_told_by_status_and_code_and_no_more() {
    let (bucket, server) = bucket();
    let cases = [
        (403, "<Code>AccessDenied</Code>", "found the answer 403 Forbidden (AccessDenied)"),
        (404, "<Code>NoSuchBucket</Code>", "found the answer 404 Not Found (NoSuchBucket)"),
        (301, "<Code>PermanentRedirect</Code>", "found the answer 301: the bucket is of another region"),
        (400, "<Code>c0ffee 5ec2e7</Code> c0ffee5ec2e7", "found the answer 400 Bad Request"),
        (0, "", "the cable"),
    ];
    for (status, body, expected) in cases {
        server.next.lock().expect("no panic").push((status, body.to_owned()));
        let told = bucket.get("solve-1.artefact").expect_err(body).to_string();
        assert!(told.starts_with("cannot read solve-1.artefact: ") && told.contains(expected), "{told}");
        assert!(!told.contains("ffee"), "{told}");
        server.next.lock().expect("no panic").push((status, body.to_owned()));
        let told = bucket.create("solve-1.artefact", b"").expect_err(body).to_string();
        assert!(told.starts_with("cannot write solve-1.artefact: ") && told.contains(expected), "{told}");
    }
    let endless = "<Code>".repeat(MAX_ANSWER / 4);
    server.next.lock().expect("no panic").push((403, endless));
    let told = bucket.list().expect_err("too long").to_string();
    assert!(told.contains("more than 65536 bytes of an answer"), "{told}");
}

/// Of an answer that is no success.
const MAX_ANSWER: usize = 64 << 10;

#[test]
fn failures_that_pass_are_tried_again() {
    let (bucket, server) = bucket();
    server.objects.lock().expect("no panic").insert("solve-1.artefact".to_owned(), b"first".to_vec());
    server.next.lock().expect("no panic").extend([(503, String::new()), (500, String::new())]);
    assert_eq!(bucket.get("solve-1.artefact"), Ok(Some(b"first".to_vec())));
}

#[test]
fn only_buckets_are_buckets() {
    let url = RemoteUrl::parse("https://a.example/results?key=c0ffee5ec2e7").expect("a URL");
    let told = Bucket::open(&url).err().expect("no bucket").to_string();
    assert!(told.contains("expected s3://BUCKET/PREFIX") && !told.contains(SECRET), "{told}");
}
