//! Where a redirect may lead, and what the next request may carry: nothing here is sent or received.
//!
//! - A request to another origin (scheme, host, port) carries only headers that say what is asked for ([`HARMLESS`]),
//!   and no request says where it comes from (no Referer): the URL before may have been a signature.
//! - Requests with credentials of s3 stay within their origin: their headers and signature are for it alone.
//! - A server of the public internet may not lead to a private address, where it could not reach itself. An address in
//!   the URL is looked at here; a name is looked up by a client that connects to public addresses only ([`Reach`]), so
//!   that the address that was checked is the one that is used.
//! - A proxy looks names up itself, and what it finds cannot be seen from here: a name behind one is refused.

use std::net::IpAddr;
use std::sync::Arc;

use http::header::{
    ACCEPT, ACCEPT_ENCODING, HeaderMap, HeaderName, IF_MATCH, IF_UNMODIFIED_SINCE, LOCATION, RANGE,
    USER_AGENT,
};
use http::{StatusCode, Uri};
use url::{Host, Url};

use super::answer::{Refused, quoted, quoted_url};
use super::secrets::Secrets;

/// What a request may carry to another origin.
const HARMLESS: [HeaderName; 6] = [ACCEPT, ACCEPT_ENCODING, IF_MATCH, IF_UNMODIFIED_SINCE, RANGE, USER_AGENT];
/// Redirects of one request.
const MAX_HOPS: usize = 10;
/// Of a Location.
const MAX_LOCATION_BYTES: usize = 8 << 10;

/// What a user allows.
#[derive(Debug, Clone)]
pub(super) struct Rules {
    /// Requests carry credentials, so that no other origin may see them.
    pub same_origin: bool,
    /// Redirects may lead from public to private addresses.
    pub allow_private: bool,
    /// Test of whether an address is private.
    pub is_private: fn(IpAddr) -> bool,
    /// Secrets that no message may hold.
    pub secrets: Arc<Secrets>,
}

/// Which addresses a request may connect to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reach {
    Any,
    /// What a name leads to must be public.
    Public,
    /// Of this machine's own network: without a proxy, and soon there or not at all.
    Near,
}

/// The next request.
#[derive(Debug)]
pub(super) struct Hop {
    pub url: Url,
    pub uri: Uri,
    pub headers: HeaderMap,
    pub reach: Reach,
    /// Redirects before it.
    pub hops: usize,
}

impl Hop {
    /// The first request, which a user has asked for.
    pub(super) fn first(uri: &Uri, headers: HeaderMap) -> Result<Hop, Refused> {
        let url = Url::parse(&uri.to_string())
            .map_err(|error| Refused::Redirect(format!("cannot read the URL: {error}")))?;
        Ok(Hop { url, uri: uri.clone(), headers, reach: Reach::Any, hops: 0 })
    }

    /// The request that an answer leads to; `None` where the answer is no redirect. `peer` is the address that gave the
    /// answer, where that is known, and `proxied` whether a proxy would fetch a URL.
    pub(super) fn next(
        &self,
        (status, answer): (StatusCode, &HeaderMap),
        peer: Option<IpAddr>,
        rules: &Rules,
        proxied: impl Fn(&Uri) -> bool,
    ) -> Result<Option<Hop>, Refused> {
        if !matches!(status.as_u16(), 301 | 302 | 303 | 307 | 308) {
            return Ok(None);
        }
        let hops = self.hops + 1;
        let refuse = |found: String, expected: &str| {
            Refused::Redirect(format!("redirect {hops}: found {found}, expected {expected}"))
        };
        if hops > MAX_HOPS {
            return Err(refuse("another redirect".to_owned(), "the file after 10 redirects at most"));
        }
        let secrets = &rules.secrets;
        let url = self.target(answer, secrets).map_err(|(found, expected)| refuse(found, expected))?;
        let to = || quoted_url(url.as_str(), secrets);
        let same_origin = url.origin() == self.url.origin();
        if !same_origin && rules.same_origin {
            return Err(refuse(to(), "the server of the request before, which has credentials"));
        }
        let uri = Uri::try_from(url.as_str())
            .map_err(|error| refuse(to(), &format!("a URL that HTTP can carry ({error})")))?;
        let from_public = peer.is_none_or(|peer| !(rules.is_private)(peer));
        let reach = match from_public && !rules.allow_private {
            true => self.reach_of(&url, rules, proxied(&uri)).map_err(|(found, expected)| {
                refuse(format!("{}, {found}", to()), &format!("{expected} (or allow-private-redirects)"))
            })?,
            false => Reach::Any,
        };
        let mut headers = self.headers.clone();
        if !same_origin {
            headers =
                HARMLESS.iter().filter_map(|name| Some((name.clone(), headers.get(name)?.clone()))).collect();
        }
        Ok(Some(Hop { url, uri, headers, reach, hops }))
    }

    /// What the Location says, if it can be followed at all; otherwise what was found and expected.
    fn target(&self, answer: &HeaderMap, secrets: &Secrets) -> Result<Url, (String, &'static str)> {
        let mut found = answer.get_all(LOCATION).iter();
        let (Some(location), None) = (found.next(), found.next()) else {
            let count = answer.get_all(LOCATION).iter().count();
            return Err((format!("{count} headers Location"), "one"));
        };
        let location = location.as_bytes();
        if location.len() > MAX_LOCATION_BYTES {
            return Err((format!("a Location of {} bytes", location.len()), "8192 at most"));
        }
        let text = str::from_utf8(location).map_err(|_| (quoted(location, secrets), "UTF-8"))?;
        let shown_text = || quoted_url(text, secrets);
        let mut url = self.url.join(text).map_err(|_| (shown_text(), "a URL"))?;
        if !matches!(url.scheme(), "http" | "https") {
            return Err((
                format!("the scheme {}", quoted(url.scheme().as_bytes(), secrets)),
                "http or https",
            ));
        }
        if self.url.scheme() == "https" && url.scheme() == "http" {
            return Err((quoted_url(url.as_str(), secrets), "https, as before"));
        }
        if !url.username().is_empty() || url.password().is_some() {
            return Err(("a user or a password in the Location".to_owned(), "none"));
        }
        url.set_fragment(None);
        Ok(url)
    }

    /// How a server of the public internet may have this fetched.
    fn reach_of(
        &self,
        url: &Url,
        rules: &Rules,
        proxied: bool,
    ) -> Result<Reach, (&'static str, &'static str)> {
        let address = match url.host() {
            Some(Host::Ipv4(address)) => IpAddr::from(address),
            Some(Host::Ipv6(address)) => IpAddr::from(address),
            Some(Host::Domain(_)) if proxied && url.origin() == self.url.origin() => return Ok(Reach::Any),
            Some(Host::Domain(_)) if proxied => {
                return Err(("whose address a proxy looks up", "an address that can be checked"));
            }
            _ => return Ok(Reach::Public),
        };
        match (rules.is_private)(address) {
            true => Err(("a private address, from a public one", "a public address")),
            false => Ok(Reach::Any), // nothing is looked up
        }
    }
}

#[cfg(test)]
mod tests;
