//! The server of a study: the page, and what participants send.
//!
//! It listens where it is told, for browsers that name one of its hosts, and takes requests of its own pages
//! alone. What it does not know of participants it cannot store: it looks at no network address.

use crate::site::Site;
use crate::store::{Begin, Chunk, MAX_CHUNK_BYTES, Put, Refusal, Store, StoreError};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Path, Request, State};
use axum::http::header::{CONTENT_TYPE, HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::routing::{post, put};
use cocarry::error::words;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::io;
use std::net::TcpListener;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// The header with the participant's secret, and that with the SHA-256 of a chunk.
const KEY: &str = "x-session-key";
const SHA256: &str = "x-sha256";
/// The largest number of requests for sessions in an interval. Others are told to come again.
const MAX_BEGINS: usize = 120;
const BEGIN_INTERVAL: Duration = Duration::from_secs(60);
/// The interval between two looks at whether the service ends.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// What every answer says of itself: a page loads nothing from elsewhere, and is in no frame of others.
const HEADERS: [(&str, &str); 5] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cache-control", "no-store"),
];

/// What is served, and how.
pub struct Serving {
    /// The page.
    pub site: Site,
    /// Where answers go.
    pub store: Store,
    /// The largest number of participants.
    pub participants: u64,
    /// The completion code; without it each participant gets one of their own.
    pub code: Option<String>,
    /// The hosts by which browsers may ask, as in `127.0.0.1:8791`.
    pub hosts: Vec<String>,
}

struct App {
    site: Site,
    store: Mutex<Store>,
    participants: u64,
    code: Option<String>,
    hosts: Vec<String>,
    begins: Mutex<VecDeque<Instant>>,
}

/// Serves a study to those whom `listener` accepts until `is_over`.
///
/// # Errors
/// The listener cannot be used.
pub fn serve(listener: TcpListener, serving: Serving, is_over: impl Fn() -> bool) -> io::Result<()> {
    let Serving { site, store, participants, code, hosts } = serving;
    let (store, begins) = (Mutex::new(store), Mutex::new(VecDeque::new()));
    let app = Arc::new(App { site, store, participants, code, hosts, begins });
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(async {
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let over = async {
            while !is_over() {
                tokio::time::sleep(POLL_INTERVAL).await;
            }
        };
        // what was acknowledged is on the disk: nothing has to be waited for
        tokio::select! {
            ended = async { axum::serve(listener, router(app)).await } => ended,
            () = over => Ok(()),
        }
    })
}

fn router(app: Arc<App>) -> Router {
    Router::new()
        .route("/api/session", post(begin).get(chunks))
        .route("/api/chunks/{trial}/{number}", put(put_chunk))
        .route("/api/finish", post(finish))
        .fallback(file)
        .layer(DefaultBodyLimit::max(MAX_CHUNK_BYTES))
        .layer(from_fn_with_state(app.clone(), guard))
        .with_state(app)
}

/// Refuses requests by other hosts' names (DNS rebinding) and those of other pages, and adds the headers of
/// all answers.
async fn guard(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let mut response = match foreign(&app, request.headers()) {
        Some(refused) => refused,
        None => next.run(request).await,
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
}

/// The answer to a request that is not of this server's own pages.
fn foreign(app: &App, headers: &HeaderMap) -> Option<Response> {
    let header = |name: HeaderName| {
        let mut values = headers.get_all(name).iter();
        let value = values.next().and_then(|value| value.to_str().ok());
        // of two, nobody knows which one holds
        value.filter(|_| values.next().is_none())
    };
    let host = header(HOST).filter(|host| app.hosts.iter().any(|own| own == host));
    let Some(host) = host else {
        return Some(sentence(StatusCode::FORBIDDEN, "host", "the study is not served by this name"));
    };
    let of_origin = |origin: &str| {
        let origin = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        origin == Some(host)
    };
    let is_own = !headers.contains_key(ORIGIN) || header(ORIGIN).is_some_and(of_origin);
    (!is_own).then(|| sentence(StatusCode::FORBIDDEN, "origin", "only pages of this server may ask"))
}

async fn file(State(app): State<Arc<App>>, method: Method, uri: Uri) -> Response {
    if method != Method::GET && method != Method::HEAD {
        return sentence(StatusCode::METHOD_NOT_ALLOWED, "method", "only GET and HEAD");
    }
    match app.site.get(uri.path()) {
        None => sentence(StatusCode::NOT_FOUND, "file", "there is no such file"),
        Some(file) => {
            let bytes = if method == Method::HEAD { Vec::new() } else { file.bytes.to_vec() };
            response(StatusCode::OK, file.mime, Body::from(bytes))
        }
    }
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
    if asked.study != app.site.digest {
        return sentence(StatusCode::CONFLICT, "study", "the study has changed; load the page again");
    }
    {
        let (mut begins, now) = (locked(&app.begins), Instant::now());
        while begins.front().is_some_and(|first| now.duration_since(*first) > BEGIN_INTERVAL) {
            begins.pop_front();
        }
        if begins.len() >= MAX_BEGINS {
            return sentence(
                StatusCode::TOO_MANY_REQUESTS,
                "busy",
                "many are beginning just now; wait a minute",
            );
        }
        begins.push_back(now);
    }
    stored(app, move |app, store| {
        let begin = Begin {
            key: &asked.key,
            platform_ids: &asked.platform_ids,
            study: &app.site.digest,
            participants: app.participants,
            now: now(),
        };
        let session = store.begin(&begin)?;
        Ok(json!({ "participant": session.participant, "place": session.place }))
    })
    .await
}

async fn chunks(State(app): State<Arc<App>>, headers: HeaderMap) -> Response {
    let key = text(&headers, KEY);
    stored(app, move |_, store| Ok(json!({ "chunks": store.chunks(&key)? }))).await
}

async fn put_chunk(
    State(app): State<Arc<App>>,
    Path((trial, number)): Path<(u32, u32)>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let (key, sha256) = (text(&headers, KEY), text(&headers, SHA256));
    stored(app, move |_, store| {
        let body = std::str::from_utf8(&body).map_err(|_| Refusal::Form("the body must be UTF-8"))?;
        let put = store.put(&key, &Chunk { trial, number, sha256: &sha256, body }, now())?;
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
    stored(app, move |app, store| {
        let code = store.finish(&key, &asked.digest, app.code.as_deref(), now())?;
        Ok(json!({ "code": code }))
    })
    .await
}

/// The answer of the store, which may wait for the disk.
async fn stored(
    app: Arc<App>,
    ask: impl FnOnce(&App, &mut Store) -> Result<Value, StoreError> + Send + 'static,
) -> Response {
    let asked = tokio::task::spawn_blocking(move || {
        let mut store = locked(&app.store);
        ask(&app, &mut store)
    });
    match asked.await {
        Ok(Ok(value)) => response(StatusCode::OK, "application/json", Body::from(value.to_string())),
        Ok(Err(StoreError::Refused(refusal))) => refused(&refusal),
        Ok(Err(error)) => {
            eprintln!("error: {}", words(&error));
            sentence(StatusCode::INTERNAL_SERVER_ERROR, "store", "the server cannot store anything just now")
        }
        Err(_) => sentence(StatusCode::INTERNAL_SERVER_ERROR, "server", "the server stopped at a fault"),
    }
}

fn refused(refusal: &Refusal) -> Response {
    let (status, reason) = match refusal {
        Refusal::Form(_) => (StatusCode::BAD_REQUEST, "form"),
        Refusal::Unknown => (StatusCode::FORBIDDEN, "unknown"),
        Refusal::Damaged => (StatusCode::UNPROCESSABLE_ENTITY, "damaged"),
        Refusal::OtherChunk => (StatusCode::CONFLICT, "other-chunk"),
        Refusal::Finished => (StatusCode::CONFLICT, "finished"),
        Refusal::TooMuch => (StatusCode::PAYLOAD_TOO_LARGE, "too-much"),
        Refusal::Full => (StatusCode::GONE, "full"),
        Refusal::Changed => (StatusCode::CONFLICT, "changed"),
        Refusal::BegunBefore => (StatusCode::CONFLICT, "begun-before"),
        Refusal::NotWhole => (StatusCode::CONFLICT, "not-whole"),
    };
    sentence(status, reason, &refusal.to_string())
}

fn sentence(status: StatusCode, reason: &str, sentence: &str) -> Response {
    let body = json!({ "reason": reason, "error": sentence }).to_string();
    response(status, "application/json", Body::from(body))
}

fn response(status: StatusCode, mime: &'static str, body: Body) -> Response {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(mime));
    response
}

/// The text of a header; empty without it, and nothing is known by an empty text.
fn text(headers: &HeaderMap, name: &str) -> String {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default().to_owned()
}

fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Seconds since 1970.
fn now() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |passed| passed.as_secs() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::digest::sha256;
    use crate::site::Sink;
    use crate::study::{Study, TEMPLATE};
    use std::io::{Read, Write};
    use std::net::{Ipv4Addr, SocketAddr, TcpStream};
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread::JoinHandle;

    /// A server of the template's study, and a folder with its store.
    struct Running {
        folder: tempfile::TempDir,
        address: SocketAddr,
        study: String,
        is_over: Arc<AtomicBool>,
        thread: Option<JoinHandle<()>>,
    }

    impl Running {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("study.toml");
            std::fs::write(&file, TEMPLATE).unwrap();
            let study = Study::read(&file).unwrap();
            let site = Site::new(&study, Sink::Server, None).unwrap();
            let store = Store::open(&study.database()).unwrap();
            let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
            let address = listener.local_addr().unwrap();
            let (digest, hosts) = (site.digest.clone(), vec![address.to_string()]);
            let serving = Serving { site, store, participants: 2, code: Some("DONE".to_owned()), hosts };
            let is_over = Arc::new(AtomicBool::new(false));
            let flag = is_over.clone();
            let thread =
                std::thread::spawn(move || serve(listener, serving, || flag.load(Ordering::SeqCst)).unwrap());
            Self { folder, address, study: digest, is_over, thread: Some(thread) }
        }

        /// The answer to a request whose head lines and body are given, HOST standing for the server's.
        fn ask(&self, head: &str, body: &str) -> String {
            let mut stream = TcpStream::connect(self.address).unwrap();
            let head = head.replace("HOST", &self.address.to_string());
            let length = body.len();
            // a body that is refused may not be read to its end
            let _ = write!(stream, "{head}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}");
            let mut answer = Vec::new();
            let _ = stream.read_to_end(&mut answer);
            String::from_utf8_lossy(&answer).into_owned()
        }

        fn begin(&self, key: &str) -> String {
            let body = json!({ "key": key, "platform_ids": [], "study": self.study }).to_string();
            self.ask("POST /api/session HTTP/1.1\r\nHost: HOST\r\nOrigin: http://HOST", &body)
        }

        fn put(&self, key: &str, place: &str, body: &str) -> String {
            let sha256 = sha256(body.as_bytes());
            let head = format!(
                "PUT /api/chunks/{place} HTTP/1.1\r\nHost: HOST\r\nx-session-key: {key}\r\nx-sha256: {sha256}"
            );
            self.ask(&head, body)
        }
    }

    impl Drop for Running {
        fn drop(&mut self) {
            self.is_over.store(true, Ordering::SeqCst);
            let _ = self.thread.take().unwrap().join();
        }
    }

    fn status(answer: &str) -> &str {
        answer.split(' ').nth(1).unwrap_or(answer)
    }

    #[test]
    fn a_session_goes_from_its_beginning_to_its_code() {
        let server = Running::new();
        let key = sha256(b"a key");
        let begun = server.begin(&key);
        assert!(begun.starts_with("HTTP/1.1 200") && begun.contains(r#""place":0"#), "{begun}");
        assert_eq!(server.begin(&key).lines().last(), begun.lines().last());
        let body = r#"[{"kind":"done"}]"#;
        assert!(server.put(&key, "0/0", body).ends_with(r#"{"known":false}"#));
        assert!(server.put(&key, "0/0", body).ends_with(r#"{"known":true}"#));
        let other = server.put(&key, "0/0", "[]");
        assert!(status(&other) == "409" && other.contains("other-chunk"), "{other}");
        let finish = |digest: &str| {
            let head = format!("POST /api/finish HTTP/1.1\r\nHost: HOST\r\nx-session-key: {key}");
            server.ask(&head, &json!({ "digest": digest }).to_string())
        };
        assert!(finish(&sha256(b"")).contains("not-whole"));
        let whole = sha256(format!("0 0 {}\n", sha256(body.as_bytes())).as_bytes());
        assert!(finish(&whole).ends_with(r#"{"code":"DONE"}"#));
        assert!(server.put(&key, "1/0", "[]").contains("finished"));
        let listed =
            server.ask(&format!("GET /api/session HTTP/1.1\r\nHost: HOST\r\nx-session-key: {key}"), "");
        assert!(listed.contains(&format!(r#"[0,0,"{}"]"#, sha256(body.as_bytes()))), "{listed}");
        // the second participant is the last one
        assert_eq!(status(&server.begin(&sha256(b"b"))), "200");
        assert!(server.begin(&sha256(b"c")).contains("full"));
    }

    #[test]
    fn nothing_that_is_secret_and_nothing_else_has_an_address() {
        let server = Running::new();
        let get = |path: &str| server.ask(&format!("GET {path} HTTP/1.1\r\nHost: HOST"), "");
        let page = get("/");
        assert!(page.starts_with("HTTP/1.1 200") && page.contains("study.js"), "{page}");
        assert!(page.contains("frame-ancestors 'none'") && page.contains("nosniff"), "{page}");
        assert!(get("/study.js").contains("text/javascript") && get("/maps/1.svg").contains("<svg"));
        let study = get("/study.json");
        assert!(study.contains(&server.study) && !study.contains("DONE") && !study.contains("risk"));
        for path in [
            "/study.sqlite",
            "/study.toml",
            "/../study.toml",
            "/%2e%2e/study.toml",
            "//",
            "/maps",
            "/maps/9.svg",
            "/api",
        ] {
            assert_eq!(status(&get(path)), "404", "{path}");
        }
        assert!(server.folder.path().join("study.sqlite").is_file());
    }

    #[test]
    fn hostile_requests_are_refused_and_change_nothing() {
        let server = Running::new();
        let key = sha256(b"a key");
        server.begin(&key);
        let body = json!({ "key": sha256(b"x"), "platform_ids": [], "study": server.study }).to_string();
        for (head, expected) in [
            ("POST /api/session HTTP/1.1\r\nHost: HOST\r\nOrigin: http://evil.example", "403"),
            ("POST /api/session HTTP/1.1\r\nHost: HOST\r\nOrigin: null", "403"),
            ("POST /api/session HTTP/1.1\r\nHost: evil.example", "403"),
            ("POST /api/session HTTP/1.0", "403"),
            ("POST /study.json HTTP/1.1\r\nHost: HOST", "405"),
            ("DELETE /api/session HTTP/1.1\r\nHost: HOST", "405"),
        ] {
            let answer = server.ask(head, &body);
            assert_eq!(status(&answer), expected, "{head}: {answer}");
        }
        assert_eq!(status(&server.ask("POST /api/session HTTP/1.1\r\nHost: HOST", "{")), "400");
        assert!(server.begin("<script>").contains("hexadecimal"));
        assert_eq!(status(&server.put(&sha256(b"guessed"), "0/0", "[]")), "403");
        assert_eq!(status(&server.put("", "0/0", "[]")), "403");
        for place in ["-1/0", "0/x", "99999999999/0", "0/0/0"] {
            assert!(["400", "405"].contains(&status(&server.put(&key, place, "[]"))), "{place}");
        }
        let long = server.put(&key, "0/0", &format!("[{}]", " ".repeat(MAX_CHUNK_BYTES)));
        // who is still sending may not hear the answer
        assert!(["413", ""].contains(&status(&long)), "{long}");
        assert_eq!(server.put(&key, "0/0", "[]").lines().last(), Some(r#"{"known":false}"#));
    }

    #[test]
    fn many_beginnings_at_once_are_bounded() {
        let server = Running::new();
        let key = sha256(b"a key");
        let refused =
            (0..=MAX_BEGINS).map(|_| server.begin(&key)).filter(|answer| status(answer) == "429").count();
        assert_eq!(refused, 1);
    }
}
