//! The administrator's page: how far participants are, and the tables so far.
//!
//! It has a port of its own, which a proxy does not pass on. The token is the password of HTTP's own scheme
//! (`Basic`): a browser keeps it in memory for this port alone and sends it in a header, so that it is in no
//! address that a history or a log keeps, and in no cookie, which the servers of other ports on this computer
//! would get too. It needs no script, and `curl --user admin:TOKEN` works as well.

mod page;
#[cfg(test)]
mod tests;

use super::answer::{response, sentence};
use super::door::{Door, pass};
use super::limits::{Held, Log, Rate, locked};
use crate::collect::{Collected, collect};
use crate::digest::{hex, sha256};
use crate::html::STYLE;
use crate::site::Site;
use crate::store::{Store, StoreError};
use crate::study::PeopleStudy;
use axum::Router;
use axum::body::Body;
use axum::extract::{Path, Request, State};
use axum::http::header::{AUTHORIZATION, CONTENT_DISPOSITION, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::http::{HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::routing::get;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use cocarry::error::words;
use std::io;
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// The largest number of connections at once.
pub(super) const MAX_CONNECTIONS: usize = 32;
/// The name that goes with the token.
const NAME: &str = "admin";
/// The number of random bytes of a token.
const TOKEN_BYTES: usize = 24;
/// The largest number of wrong tokens in a minute: no other one is then looked at until the minute is over.
const MAX_WRONG: usize = 10;

/// What the page may load: its style, and the icon in its text. It has no script.
const POLICY: &str = "default-src 'none'; style-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The administrator's page: where it is, and who may see it.
pub struct Admin {
    /// Where it listens.
    pub listener: TcpListener,
    /// The token, as [`token`] makes it.
    pub token: String,
}

/// A random token.
///
/// # Errors
/// The system has no random numbers.
pub fn token() -> io::Result<String> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(hex(&bytes))
}

struct Office {
    study: Arc<PeopleStudy>,
    /// The digest of what participants see now.
    study_sha256: String,
    /// Read by one request at a time.
    store: Mutex<Store>,
    /// The digest of the header that has the token.
    authorization_sha256: String,
    wrong: Rate,
    log: Arc<Log>,
}

impl Admin {
    /// The listener, and what it serves.
    pub(super) fn prepared(
        self,
        study: Arc<PeopleStudy>,
        site: &Site,
        log: Arc<Log>,
    ) -> io::Result<(TcpListener, Router)> {
        let port = self.listener.local_addr()?.port();
        let hosts = vec![format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        let store = Store::open(&study.database()).map_err(|error| io::Error::other(words(&error)))?;
        let header = format!("Basic {}", BASE64_STANDARD.encode(format!("{NAME}:{}", self.token)));
        let office = Arc::new(Office {
            study,
            study_sha256: site.digest.clone(),
            store: Mutex::new(store),
            authorization_sha256: sha256(header.as_bytes()),
            wrong: Rate::new(MAX_WRONG),
            log: Arc::clone(&log),
        });
        let door = Arc::new(Door { hosts, policy: POLICY, log, held: Held::default() });
        let router = Router::new()
            .route("/", get(overview))
            .route(
                "/plain.css",
                get(async || response(StatusCode::OK, "text/css; charset=utf-8", Body::from(STYLE))),
            )
            .route(
                "/tables/{name}",
                get(async |state, Path(name): Path<String>| table(state, name, false).await),
            )
            .route(
                "/tables/with-unfinished/{name}",
                get(async |state, Path(name): Path<String>| table(state, name, true).await),
            )
            .fallback(async || sentence(StatusCode::NOT_FOUND, "file", "there is no such file"))
            .layer(from_fn_with_state(Arc::clone(&office), authorized))
            .layer(from_fn_with_state(door, pass))
            .with_state(office);
        Ok((self.listener, router))
    }
}

/// Lets those pass who have the token. Wrong ones are counted, and beyond the limit none is looked at: 10 a
/// minute are no way to guess 192 bits.
async fn authorized(State(office): State<Arc<Office>>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    // a page of others could make this browser ask with the token that it knows, if not see the answer
    let site = headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
    if !matches!(site, None | Some(b"none" | b"same-origin")) {
        return sentence(StatusCode::FORBIDDEN, "origin", "open this page by its address");
    }
    let given = headers.get(AUTHORIZATION);
    let now = Instant::now();
    if given.is_some() && office.wrong.is_full(now) {
        let said = "too many wrong tokens; wait a minute";
        let mut refused = sentence(StatusCode::TOO_MANY_REQUESTS, "guessed", said);
        refused.headers_mut().insert(RETRY_AFTER, HeaderValue::from_static("60"));
        return refused;
    }
    match given {
        // how far two digests are equal tells nothing of what they are digests of
        Some(given) if sha256(given.as_bytes()) == office.authorization_sha256 => next.run(request).await,
        given => {
            let reason = if given.is_some() { "token" } else { "no-token" };
            if given.is_some() {
                office.wrong.take(now);
            }
            let said = "the name is admin, and the password the token that `cocarry study serve` printed";
            let mut asked = sentence(StatusCode::UNAUTHORIZED, reason, said);
            let scheme = HeaderValue::from_static("Basic realm=\"cocarry study\", charset=\"UTF-8\"");
            asked.headers_mut().insert(WWW_AUTHENTICATE, scheme);
            asked
        }
    }
}

async fn overview(State(office): State<Arc<Office>>) -> Response {
    office
        .read(|office, store| {
            let (progress, sessions) = (store.progress()?, store.ends_of_trials()?);
            let collected = collect(&office.study, &sessions, true);
            let html =
                page::overview(&office.study, &office.study_sha256, &progress, &collected, super::now());
            Ok(response(StatusCode::OK, "text/html; charset=utf-8", Body::from(html)))
        })
        .await
}

/// A table, with the bytes that `cocarry study collect` writes.
async fn table(State(office): State<Arc<Office>>, name: String, with_unfinished: bool) -> Response {
    office
        .read(move |office, store| {
            let sessions = store.ends_of_trials()?;
            let Collected { files, .. } = collect(&office.study, &sessions, with_unfinished);
            let Some((_, bytes)) =
                files.into_iter().find(|(file, _)| *file == name && page::is_download(file))
            else {
                return Ok(sentence(StatusCode::NOT_FOUND, "file", "there is no such table"));
            };
            let mut table = response(StatusCode::OK, "text/csv; charset=utf-8", Body::from(bytes));
            table.headers_mut().insert(CONTENT_DISPOSITION, HeaderValue::from_static("attachment"));
            Ok(table)
        })
        .await
}

impl Office {
    /// What is read of the store, by one after the other.
    async fn read(
        self: Arc<Self>,
        read: impl FnOnce(&Self, &Store) -> Result<Response, StoreError> + Send + 'static,
    ) -> Response {
        let log = Arc::clone(&self.log);
        let answered = tokio::task::spawn_blocking(move || read(&self, &locked(&self.store)));
        match answered.await {
            Ok(Ok(response)) => return response,
            Ok(Err(error)) => log.line(format_args!("error: {}", words(&error))),
            Err(_) => log.line("error: the administrator's page ended at a fault of the program"),
        }
        sentence(StatusCode::INTERNAL_SERVER_ERROR, "store", "the answers cannot be read just now")
    }
}
