use http::Uri;
use object_store::client::{HttpError, HttpRequest, HttpResponse};

use super::super::RemoteSource;
use super::super::redirect::Reach;
use super::*;

#[derive(Debug)]
struct Broken;

#[async_trait::async_trait]
impl Wire for Broken {
    async fn send(
        &self,
        _: HttpRequest,
        _: Reach,
    ) -> Result<(HttpResponse, Option<std::net::IpAddr>), HttpError> {
        panic!("planted")
    }

    fn is_proxied(&self, _: &Uri) -> bool {
        false
    }
}

#[test]
fn a_panic_of_a_request_is_an_internal_fault_and_the_next_request_is_served() {
    let url = RemoteUrl::parse("http://a.example/a.flb").expect("a URL");
    for _ in 0..2 {
        let opened = RemoteSource::open_by(&url, &RemoteSettings::default(), [], Some(Arc::new(Broken)));
        let error = opened.err().expect("it panics").to_string();
        assert!(error.contains("bytes 0 to 65535: internal fault: "), "{error}");
    }
}
