//! The server of a study: the page, and what participants send; at another port, the administrator's page.
//!
//! It listens where it is told, for browsers that name one of its hosts, and takes requests of its own pages
//! alone. What it does not know of participants it cannot store: it looks at no network address.

mod admin;
mod answer;
mod connections;
mod door;
mod limits;
#[cfg(test)]
mod tests;
mod writer;

pub use admin::{Admin, token};

use crate::site::{Site, SiteFile};
use crate::store::{Begin, Chunk, Fault, Put, Refusal, Store, Writing};
use crate::study::PeopleStudy;
use answer::{refused, response, sentence};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{Path, State};
use axum::http::{HeaderMap, Method, StatusCode, Uri};
use axum::middleware::from_fn_with_state;
use axum::response::Response;
use axum::routing::{post, put};
use door::{Door, pass};
use limits::{Held, Log, Rate};
use serde::Deserialize;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use writer::Writer;

/// The header with the participant's secret, and that with the SHA-256 of a chunk.
const KEY: &str = "x-session-key";
const SHA256: &str = "x-sha256";
/// The largest number of requests for sessions in a minute: a lecture hall may begin at once. Others are told
/// to come again, and the page does.
const MAX_BEGINS: usize = 1000;
/// The largest number of connections at once. Systems let a process have 1024 files, if nobody changes it.
const MAX_CONNECTIONS: usize = 800;
/// The interval between two looks at whether the service ends.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// What the page may load: nothing from elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What is served, and how.
pub struct Serving {
    /// The study.
    pub study: PeopleStudy,
    /// Its page.
    pub site: Site,
    /// Where answers go.
    pub store: Store,
    /// The hosts by which browsers may ask, as in `127.0.0.1:8791`.
    pub hosts: Vec<String>,
    /// The administrator's page, if there is one.
    pub admin: Option<Admin>,
}

struct App {
    files: Vec<(Cow<'static, str>, &'static str, Bytes)>,
    study_sha256: String,
    study: Arc<PeopleStudy>,
    writer: Writer,
    begins: Rate,
}

/// Serves a study to those whom `listener` accepts until `is_over`.
///
/// # Errors
/// A listener cannot be used, or the store cannot be read.
pub fn serve(listener: TcpListener, serving: Serving, is_over: impl Fn() -> bool) -> io::Result<()> {
    let Serving { study, site, store, hosts, admin } = serving;
    let (study, log) = (Arc::new(study), Arc::new(Log::new()));
    let admin = admin.map(|admin| admin.prepared(Arc::clone(&study), &site, Arc::clone(&log))).transpose()?;
    let app = App {
        study_sha256: site.digest,
        files: site.files.into_iter().map(served).collect(),
        study,
        writer: Writer::new(store, Arc::clone(&log)),
        begins: Rate::new(MAX_BEGINS),
    };
    let door = Door { hosts, policy: POLICY, log: Arc::clone(&log), held: Held::default() };
    let router = router(Arc::new(app), Arc::new(door));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let served = runtime.block_on(async {
        let over = async {
            while !is_over() {
                tokio::time::sleep(POLL_INTERVAL).await;
            }
        };
        let study = accept(listener, router, MAX_CONNECTIONS, &log);
        let admin = async {
            match admin {
                Some((listener, router)) => accept(listener, router, admin::MAX_CONNECTIONS, &log).await,
                None => std::future::pending().await,
            }
        };
        // what was acknowledged is on the disk: nothing has to be waited for
        tokio::select! {
            ended = study => ended,
            ended = admin => ended,
            () = over => Ok(()),
        }
    });
    log.say_unsaid();
    served
}

async fn accept(listener: TcpListener, router: Router, most: usize, log: &Arc<Log>) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let listener = tokio::net::TcpListener::from_std(listener)?;
    connections::accept(listener, router, most, Arc::clone(log)).await
}

fn router(app: Arc<App>, door: Arc<Door>) -> Router {
    Router::new()
        .route("/api/session", post(begin).get(chunks))
        .route("/api/chunks/{trial}/{number}", put(put_chunk))
        .route("/api/finish", post(finish))
        .fallback(file)
        .layer(from_fn_with_state(door, pass))
        .with_state(app)
}

async fn file(State(app): State<Arc<App>>, method: Method, uri: Uri) -> Response {
    if method != Method::GET && method != Method::HEAD {
        return sentence(StatusCode::METHOD_NOT_ALLOWED, "method", "only GET and HEAD");
    }
    let name = uri.path().strip_prefix('/').unwrap_or_default();
    let name = if name.is_empty() { "index.html" } else { name };
    match app.files.iter().find(|(file, ..)| file == name) {
        None => sentence(StatusCode::NOT_FOUND, "file", "there is no such file"),
        Some((_, mime, bytes)) => {
            let bytes = if method == Method::HEAD { Bytes::new() } else { bytes.clone() };
            response(StatusCode::OK, mime, Body::from(bytes))
        }
    }
}

/// A file whose bytes all answers share.
fn served(SiteFile { name, mime, bytes }: SiteFile) -> (Cow<'static, str>, &'static str, Bytes) {
    let bytes = match bytes {
        Cow::Borrowed(bytes) => Bytes::from_static(bytes),
        Cow::Owned(bytes) => Bytes::from(bytes),
    };
    (name, mime, bytes)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BeginText {
    key: String,
    platform_ids: Vec<(String, String)>,
    study: String,
}

async fn begin(State(app): State<Arc<App>>, body: Bytes) -> Response {
    let Ok(asked) = serde_json::from_slice::<BeginText>(&body) else {
        return refused(&Refusal::Form("expected key, platform_ids and study"));
    };
    if asked.study != app.study_sha256 {
        return sentence(StatusCode::CONFLICT, "study", "the study has changed; load the page again");
    }
    if !app.begins.take(Instant::now()) {
        let said = "many are beginning just now; wait a minute";
        return sentence(StatusCode::TOO_MANY_REQUESTS, "busy", said);
    }
    let participants = app.study.participants;
    stored(&app, move |writing| {
        let begin = Begin {
            key: &asked.key,
            platform_ids: &asked.platform_ids,
            study: &asked.study,
            participants,
            now: now(),
        };
        let session = writing.begin(&begin)?;
        Ok(json!({ "participant": session.participant, "place": session.place }))
    })
    .await
}

async fn chunks(State(app): State<Arc<App>>, headers: HeaderMap) -> Response {
    let key = text(&headers, KEY);
    stored(&app, move |writing| Ok(json!({ "chunks": writing.chunks(&key)? }))).await
}

async fn put_chunk(
    State(app): State<Arc<App>>,
    Path((trial, number)): Path<(u32, u32)>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let (key, sha256) = (text(&headers, KEY), text(&headers, SHA256));
    // a long body takes a while, in which others are served
    let checked = tokio::task::spawn_blocking(move || {
        let text = String::from_utf8(body.into()).map_err(|_| Refusal::Form("the body must be UTF-8"))?;
        Chunk { trial, number, sha256: &sha256, body: &text }.check()?;
        Ok::<_, Refusal>((sha256, text))
    });
    let (sha256, text) = match checked.await {
        Ok(Ok(checked)) => checked,
        Ok(Err(refusal)) => return refused(&refusal),
        Err(_) => return answer::stored(Err(writer::Unwritten::Failed)),
    };
    stored(&app, move |writing| {
        let put = writing.put(&key, &Chunk { trial, number, sha256: &sha256, body: &text }, now())?;
        Ok(json!({ "known": put == Put::Known }))
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FinishText {
    digest: String,
}

async fn finish(State(app): State<Arc<App>>, headers: HeaderMap, body: Bytes) -> Response {
    let key = text(&headers, KEY);
    let Ok(asked) = serde_json::from_slice::<FinishText>(&body) else {
        return refused(&Refusal::Form("expected digest"));
    };
    let study = Arc::clone(&app.study);
    stored(&app, move |writing| {
        let code = writing.finish(&key, &asked.digest, study.end.code.as_deref(), now())?;
        Ok(json!({ "code": code }))
    })
    .await
}

/// The answer of the store, which may wait for the disk.
async fn stored(app: &App, ask: impl FnOnce(&Writing) -> Result<Value, Fault> + Send + 'static) -> Response {
    answer::stored(app.writer.ask(ask).await)
}

/// The text of a header; empty without it, and nothing is known by an empty text.
fn text(headers: &HeaderMap, name: &str) -> String {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default().to_owned()
}

/// Seconds since 1970.
fn now() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |passed| passed.as_secs() as i64)
}
