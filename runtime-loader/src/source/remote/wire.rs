//! What carries one request and one answer: HTTP clients that follow nothing and say nothing of where a request comes
//! from. Redirects are followed above, where it is decided what goes along.

use std::fmt;
use std::net::{IpAddr, SocketAddr};
use std::sync::OnceLock;
use std::time::Duration;

use async_trait::async_trait;
use http::Uri;
use hyper_util::client::legacy::connect::HttpInfo;
use hyper_util::client::proxy::matcher::Matcher;
use object_store::client::{HttpError, HttpErrorKind, HttpRequest, HttpResponse, HttpService};
use reqwest::ClientBuilder;
use reqwest::dns::{Addrs, Name, Resolve, Resolving};

use super::RemoteSettings;
use super::redirect::Reach;

/// To connect to what gives credentials near by: machines outside of a cloud have none there.
const NEAR_CONNECT: Duration = Duration::from_secs(1);

/// Carries requests. The second implementation replays answers (`replay.rs`).
#[async_trait]
pub(super) trait Wire: fmt::Debug + Send + Sync + 'static {
    /// One request and its answer, with the address that gave it, where that is known.
    async fn send(
        &self,
        request: HttpRequest,
        reach: Reach,
    ) -> Result<(HttpResponse, Option<IpAddr>), HttpError>;

    /// Whether a proxy fetches this for us.
    fn is_proxied(&self, uri: &Uri) -> bool;
}

/// What a client is made for.
#[derive(Debug, Clone)]
pub(super) struct WireSettings {
    pub settings: RemoteSettings,
    /// Whether plain `http` may be spoken.
    pub allow_http: bool,
    /// Whether to go on without certificates where the system has none.
    pub plain: bool,
}

/// Clients of `reqwest`, which share no connections.
pub(super) struct Clients {
    made_for: WireSettings,
    any: reqwest::Client,
    /// Connects to public addresses only, without a proxy. Few ever need it.
    public: OnceLock<reqwest::Client>,
    /// Without a proxy, for what gives credentials near by.
    near: OnceLock<reqwest::Client>,
    proxies: Matcher,
}

impl Clients {
    pub(super) fn new(made_for: WireSettings) -> reqwest::Result<Clients> {
        // Fails only if the program has chosen a provider already, which then serves.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let any = client(&made_for, |builder| builder)?;
        let [public, near] = [OnceLock::new(), OnceLock::new()];
        Ok(Clients { made_for, any, public, near, proxies: Matcher::from_system() })
    }

    fn client(&self, reach: Reach) -> Result<&reqwest::Client, HttpError> {
        let Clients { made_for, any, public, near, .. } = self;
        let made = match reach {
            Reach::Any => return Ok(any),
            Reach::Public => public,
            Reach::Near => near,
        };
        if let Some(client) = made.get() {
            return Ok(client);
        }
        let connect = made_for.settings.connect.min(NEAR_CONNECT);
        let is_private = made_for.settings.is_private;
        let client = client(made_for, |builder| match reach {
            Reach::Near => builder.no_proxy().connect_timeout(connect),
            _ => builder.no_proxy().dns_resolver(PublicOnly { is_private }),
        });
        let client = client.map_err(|error| HttpError::new(HttpErrorKind::Unknown, error))?;
        Ok(made.get_or_init(|| client))
    }
}

impl fmt::Debug for Clients {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Proxies may have passwords.
        f.debug_struct("Clients").field("made_for", &self.made_for).finish_non_exhaustive()
    }
}

/// A client of the system's certificates.
fn client(
    made_for: &WireSettings,
    further: impl Fn(ClientBuilder) -> ClientBuilder,
) -> reqwest::Result<reqwest::Client> {
    let WireSettings { settings, allow_http, plain } = made_for;
    let builder = || {
        let builder = reqwest::Client::builder()
            .redirect(reqwest::redirect::Policy::none())
            .referer(false)
            .retry(reqwest::retry::never())
            .user_agent(concat!("flb/", env!("CARGO_PKG_VERSION")))
            .https_only(!allow_http)
            .connect_timeout(settings.connect)
            .read_timeout(settings.idle)
            .timeout(settings.limit);
        further(builder)
    };
    match builder().build() {
        Err(_) if *plain => builder().tls_certs_only([]).build(),
        outcome => outcome,
    }
}

#[async_trait]
impl Wire for Clients {
    async fn send(
        &self,
        request: HttpRequest,
        reach: Reach,
    ) -> Result<(HttpResponse, Option<IpAddr>), HttpError> {
        let proxied = reach == Reach::Any && self.is_proxied(request.uri());
        let response = self.client(reach)?.call(request).await?;
        let peer = response.extensions().get::<HttpInfo>().map(|info| info.remote_addr().ip());
        Ok((response, peer.filter(|_| !proxied)))
    }

    fn is_proxied(&self, uri: &Uri) -> bool {
        self.proxies.intercept(uri).is_some()
    }
}

/// A name that leads to private addresses alone, where a public one was needed.
#[derive(Debug, thiserror::Error)]
#[error("it has no public address")]
pub(super) struct PrivateName;

/// Looks names up, and leaves private addresses out. What it gives is what is connected to.
struct PublicOnly {
    is_private: fn(IpAddr) -> bool,
}

impl Resolve for PublicOnly {
    fn resolve(&self, name: Name) -> Resolving {
        let is_private = self.is_private;
        Box::pin(async move {
            let found: Vec<SocketAddr> = tokio::net::lookup_host((name.as_str(), 0)).await?.collect();
            let public: Vec<SocketAddr> =
                found.into_iter().filter(|address| !is_private(address.ip())).collect();
            if public.is_empty() {
                return Err(PrivateName.into());
            }
            Ok(Box::new(public.into_iter()) as Addrs)
        })
    }
}
