//! A small HTTP server on this machine, whose answers a test chooses. One thread per connection, one request each.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// What was asked.
#[derive(Debug, Clone)]
pub struct Request {
    /// How many came before it.
    pub number: usize,
    /// GET or another.
    pub method: String,
    /// With the query.
    pub path: String,
    /// Names in lower case.
    pub headers: BTreeMap<String, String>,
}

/// What is answered.
#[derive(Debug, Clone)]
pub struct Reply {
    /// As in HTTP.
    pub status: u16,
    /// Besides the length.
    pub headers: Vec<(&'static str, String)>,
    /// Behind the headers.
    pub body: Vec<u8>,
    /// What Content-Length says; that of the body where nothing is set.
    pub length: Option<u64>,
    /// Before the first byte.
    pub delay: Duration,
    /// Whether more headers follow for as long as the client takes them.
    pub endless: bool,
}

/// Runs until the test ends.
pub struct Server {
    address: SocketAddr,
    log: Arc<Mutex<Vec<Request>>>,
}

/// A file as a good server serves it.
#[derive(Debug, Clone, Default)]
pub struct Served {
    /// Its content.
    pub bytes: Vec<u8>,
    /// With its quotes.
    pub e_tag: Option<String>,
    /// As in HTTP.
    pub modified: Option<String>,
}

impl Request {
    /// First and last byte that are asked for.
    pub fn range(&self) -> Option<(u64, u64)> {
        let (first, last) = self.headers.get("range")?.strip_prefix("bytes=")?.split_once('-')?;
        Some((first.parse().ok()?, last.parse().ok()?))
    }
}

impl Reply {
    /// At once, with its length.
    pub fn new(status: u16, body: impl Into<Vec<u8>>) -> Reply {
        Reply {
            status,
            headers: Vec::new(),
            body: body.into(),
            length: None,
            delay: Duration::ZERO,
            endless: false,
        }
    }

    /// With another header.
    pub fn with(mut self, name: &'static str, value: impl Into<String>) -> Reply {
        self.headers.push((name, value.into()));
        self
    }

    /// The same, later.
    pub fn after(self, delay: Duration) -> Reply {
        Reply { delay, ..self }
    }
}

impl Served {
    /// With a tag and no date.
    pub fn tagged(bytes: impl Into<Vec<u8>>, e_tag: &str) -> Served {
        Served { bytes: bytes.into(), e_tag: Some(e_tag.to_owned()), modified: None }
    }

    /// RFC 9110: ranges, If-Match, If-Unmodified-Since (by equality, which is what a file with one date needs).
    pub fn reply(&self, request: &Request) -> Reply {
        let describe = |mut reply: Reply| {
            reply.headers.extend(self.e_tag.clone().map(|tag| ("ETag", tag)));
            reply.headers.extend(self.modified.clone().map(|date| ("Last-Modified", date)));
            reply
        };
        let matches = match request.headers.get("if-match") {
            Some(wanted) => self.e_tag.as_ref().is_some_and(|tag| wanted == tag && !tag.starts_with("W/")),
            None => request
                .headers
                .get("if-unmodified-since")
                .is_none_or(|date| Some(date) == self.modified.as_ref()),
        };
        let length = self.bytes.len() as u64;
        match request.range() {
            _ if !matches => describe(Reply::new(412, "it is another")),
            None => describe(Reply::new(200, self.bytes.clone())),
            Some((first, _)) if first >= length => {
                describe(Reply::new(416, "")).with("Content-Range", format!("bytes */{length}"))
            }
            Some((first, last)) => {
                let last = last.min(length - 1);
                let bytes = &self.bytes[first as usize..=last as usize];
                describe(Reply::new(206, bytes))
                    .with("Content-Range", format!("bytes {first}-{last}/{length}"))
            }
        }
    }
}

impl Server {
    /// Answers every request by `answer`.
    pub fn start(answer: impl Fn(&Request) -> Reply + Send + Sync + 'static) -> Server {
        Server::start_at("127.0.0.1", answer)
    }

    /// The same at another address of this machine.
    pub fn start_at(host: &str, answer: impl Fn(&Request) -> Reply + Send + Sync + 'static) -> Server {
        let listener = TcpListener::bind((host, 0)).expect("a port");
        let address = listener.local_addr().expect("an address");
        let log = Arc::new(Mutex::new(Vec::new()));
        let (answer, seen) = (Arc::new(answer), Arc::clone(&log));
        std::thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                let (answer, seen) = (Arc::clone(&answer), Arc::clone(&seen));
                std::thread::spawn(move || serve(stream, &*answer, &seen));
            }
        });
        Server { address, log }
    }

    /// Serves one file well.
    pub fn of(file: Served) -> Server {
        Server::start(move |request| file.reply(request))
    }

    /// Where it listens.
    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// Of a path on it.
    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    /// What was asked up to here.
    pub fn requests(&self) -> Vec<Request> {
        self.log.lock().expect("no thread panics while it holds it").clone()
    }

    /// First and last byte of every range that was asked for.
    pub fn ranges(&self) -> Vec<(u64, u64)> {
        self.requests().iter().filter_map(Request::range).collect()
    }
}

/// Reads one request, writes its answer. A client that goes away meanwhile is no fault of the server.
fn serve(
    stream: TcpStream,
    answer: &(impl Fn(&Request) -> Reply + ?Sized),
    log: &Mutex<Vec<Request>>,
) -> Option<()> {
    let mut lines = BufReader::new(stream.try_clone().ok()?).lines().map_while(Result::ok);
    let first = lines.next()?;
    let mut words = first.split(' ');
    let (method, path) = (words.next()?.to_owned(), words.next()?.to_owned());
    let header = |line: String| {
        let (name, value) = line.split_once(':')?;
        Some((name.to_ascii_lowercase(), value.trim().to_owned()))
    };
    let headers = lines.take_while(|line| !line.is_empty()).filter_map(header).collect();
    let request = {
        let mut log = log.lock().expect("no thread panics while it holds it");
        let request = Request { number: log.len(), method, path, headers };
        log.push(request.clone());
        request
    };
    let reply = answer(&request);
    std::thread::sleep(reply.delay);
    let length = reply.length.unwrap_or(reply.body.len() as u64);
    let mut head =
        format!("HTTP/1.1 {} Word\r\nConnection: close\r\nContent-Length: {length}\r\n", reply.status);
    for (name, value) in &reply.headers {
        head += &format!("{name}: {value}\r\n");
    }
    let mut stream = stream;
    if reply.endless {
        stream.write_all(head.as_bytes()).ok()?;
        let more = "X-Word: and another, and another, and another\r\n".repeat(20);
        loop {
            stream.write_all(more.as_bytes()).ok()?;
        }
    }
    stream.write_all((head + "\r\n").as_bytes()).ok()?;
    stream.write_all(&reply.body).ok()?;
    stream.flush().ok()
}
