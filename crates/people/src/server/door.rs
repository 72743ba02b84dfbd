//! What every request passes before it is looked at, and every answer on its way out.

use super::answer::sentence;
use super::connections::LastWhole;
use super::limits::{Held, Hold, Log};
use crate::store::MAX_CHUNK_BYTES;
use axum::body::{Body, Bytes};
use axum::extract::{Request, State};
use axum::http::header::{CONTENT_LENGTH, CONTENT_SECURITY_POLICY, HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri};
use axum::middleware::Next;
use axum::response::Response;
use http_body_util::BodyExt;
use std::sync::Arc;
use std::time::Duration;

/// How long a client may take for a body.
const BODY_TIME: Duration = Duration::from_secs(20);
/// The longest path in a printed line, characters.
const MAX_SHOWN: usize = 80;

/// What every answer says of itself, beside what its page may load: it is in no frame of others.
const HEADERS: [(&str, &str); 4] = [
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cache-control", "no-store"),
];

/// The door of a server.
pub(super) struct Door {
    /// The hosts by which browsers may ask, as in `127.0.0.1:8791`.
    pub hosts: Vec<String>,
    /// What its pages may load.
    pub policy: &'static str,
    /// Where refused requests are told.
    pub log: Arc<Log>,
    /// The bodies of all requests.
    pub held: Held,
}

/// The reason of an answer that refuses.
#[derive(Clone, Copy)]
pub(super) struct Reason(pub &'static str);

/// Refusals that people meet without doing anything wrong.
const ROUTINE: [&str; 6] = ["begun-before", "changed", "full", "no-token", "not-whole", "study"];

/// Refuses requests by other hosts' names (DNS rebinding), those of other pages, and those whose body is too
/// long or too slow; adds the headers of all answers.
pub(super) async fn pass(State(door): State<Arc<Door>>, request: Request, next: Next) -> Response {
    let (method, uri) = (request.method().clone(), request.uri().clone());
    let mut hold = door.held.hold();
    let mut response = match door.entered(request, &mut hold).await {
        Ok(request) => next.run(request).await,
        Err(refused) => refused,
    };
    door.tell(&method, &uri, &response);
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(door.policy));
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
}

impl Door {
    /// The request with its whole body, or the answer that refuses it.
    async fn entered(&self, request: Request, hold: &mut Hold<'_>) -> Result<Request, Response> {
        self.foreign(request.headers())?;
        let (parts, body) = request.into_parts();
        let bytes = match parts.method {
            Method::POST | Method::PUT => whole(&parts.headers, body, hold).await?,
            _ => Bytes::new(),
        };
        if let Some(last) = parts.extensions.get::<LastWhole>() {
            last.note();
        }
        Ok(Request::from_parts(parts, Body::from(bytes)))
    }

    /// Refuses what is not of this server's own pages.
    fn foreign(&self, headers: &HeaderMap) -> Result<(), Response> {
        let header = |name: HeaderName| {
            let mut values = headers.get_all(name).iter();
            let value = values.next().and_then(|value| value.to_str().ok());
            // of two, nobody knows which one holds
            value.filter(|_| values.next().is_none())
        };
        let host = header(HOST).filter(|host| self.hosts.iter().any(|own| own == host));
        let Some(host) = host else {
            return Err(sentence(StatusCode::FORBIDDEN, "host", "the study is not served by this name"));
        };
        let of_origin = |origin: &str| {
            let origin = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
            origin == Some(host)
        };
        match !headers.contains_key(ORIGIN) || header(ORIGIN).is_some_and(of_origin) {
            true => Ok(()),
            false => Err(sentence(StatusCode::FORBIDDEN, "origin", "only pages of this server may ask")),
        }
    }

    /// Prints a line of a request that was refused: never its query, which may identify a participant.
    fn tell(&self, method: &Method, uri: &Uri, response: &Response) {
        let status = response.status();
        let reason = response.extensions().get::<Reason>().map_or("", |reason| reason.0);
        if (status.is_client_error() || status.is_server_error()) && !ROUTINE.contains(&reason) {
            let path: String = uri.path().chars().take(MAX_SHOWN).collect();
            let method: String = method.as_str().chars().take(MAX_SHOWN).collect();
            let space = if reason.is_empty() { "" } else { " " };
            self.log.line(format_args!("refused: {}{space}{reason}: {method} {path:?}", status.as_u16()));
        }
    }
}

/// The whole body of a request, within the bounds of length, time and memory.
async fn whole(headers: &HeaderMap, body: Body, hold: &mut Hold<'_>) -> Result<Bytes, Response> {
    let too_long = || sentence(StatusCode::PAYLOAD_TOO_LARGE, "too-much", "a body has at most 1 MiB");
    let said = headers.get(CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    if said.is_some_and(|length| length > MAX_CHUNK_BYTES as u64) {
        return Err(too_long());
    }
    let read = async {
        let (mut bytes, mut body) = (Vec::new(), body);
        while let Some(frame) = body.frame().await {
            let frame = frame
                .map_err(|_| sentence(StatusCode::BAD_REQUEST, "form", "the body ended before its length"))?;
            // what is not data are headers after it
            let Ok(data) = frame.into_data() else { continue };
            if bytes.len() + data.len() > MAX_CHUNK_BYTES {
                return Err(too_long());
            }
            if !hold.add(data.len()) {
                let said = "the server has much to do just now; try again";
                return Err(sentence(StatusCode::SERVICE_UNAVAILABLE, "memory", said));
            }
            bytes.extend_from_slice(&data);
        }
        Ok(Bytes::from(bytes))
    };
    let slow = || sentence(StatusCode::REQUEST_TIMEOUT, "slow", "the body took more than 20 s");
    tokio::time::timeout(BODY_TIME, read).await.unwrap_or_else(|_| Err(slow()))
}
