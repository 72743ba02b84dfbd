//! The connections of a server: bounded in number, and in how long a request may take to arrive.

use super::limits::{Log, locked};
use axum::Router;
use axum::body::Body;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::HashMap;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tower_service::Service;

/// How long a client may take for the head of a request; as long a connection without one stays open.
const HEAD_TIME: Duration = Duration::from_secs(10);
/// The longest head, bytes.
const MAX_HEAD: usize = 16 << 10;
/// The pause after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(10);

/// The time at which a whole request came over a connection: milliseconds since the server began, 0 before it.
#[derive(Clone)]
pub(super) struct LastWhole {
    began: Instant,
    ms: Arc<AtomicU64>,
}

impl LastWhole {
    /// Notes that a request has come as a whole.
    pub fn note(&self) {
        let ms = self.began.elapsed().as_millis().max(1);
        self.ms.store(u64::try_from(ms).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
}

struct Connection {
    last: LastWhole,
    task: AbortHandle,
}

/// The open connections, by their number.
#[derive(Default)]
struct Connections {
    open: Mutex<HashMap<u64, Connection>>,
}

impl Connections {
    /// Closes the connection whose last whole request is the longest ago, or that never had one: the oldest of
    /// these. What the server has acknowledged is stored; a page whose connection is closed asks again.
    fn make_room(&self) -> bool {
        let mut open = locked(&self.open);
        let oldest = open
            .iter()
            .min_by_key(|(number, c)| (c.last.ms.load(Ordering::Relaxed), **number))
            .map(|(n, _)| *n);
        let closed = oldest.and_then(|number| open.remove(&number));
        if let Some(connection) = &closed {
            connection.task.abort();
        }
        closed.is_some()
    }
}

/// Serves whoever connects, `most` at once: another one then takes the place of the connection that has been
/// without a whole request for longest.
pub(super) async fn accept(
    listener: TcpListener,
    router: Router,
    most: usize,
    log: Arc<Log>,
) -> io::Result<()> {
    let (connections, began) = (Arc::new(Connections::default()), Instant::now());
    let mut number = 0;
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            // as when the system lets the process have no more files
            Err(error) => {
                let made = if connections.make_room() { "; another one is closed" } else { "" };
                log.line(format_args!("a connection is not accepted: {error}{made}"));
                tokio::time::sleep(PAUSE).await;
                continue;
            }
        };
        if locked(&connections.open).len() >= most && connections.make_room() {
            log.line(format_args!("{most} connections are open: the longest idle one is closed"));
        }
        number += 1;
        let last = LastWhole { began, ms: Arc::default() };
        let (own, served) =
            (Arc::clone(&connections), serve(stream, router.clone(), last.clone(), Arc::clone(&log)));
        // the task waits until it is in the list, from which it removes itself
        let mut open = locked(&connections.open);
        let task = tokio::spawn(async move {
            served.await;
            locked(&own.open).remove(&number);
        });
        open.insert(number, Connection { last, task: task.abort_handle() });
    }
}

async fn serve(stream: TcpStream, router: Router, last: LastWhole, log: Arc<Log>) {
    // answers are short, and each is awaited
    let _ = stream.set_nodelay(true);
    let service = service_fn(move |request: hyper::Request<hyper::body::Incoming>| {
        let mut request = request.map(Body::new);
        request.extensions_mut().insert(last.clone());
        router.clone().call(request)
    });
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIME)
        .max_buf_size(MAX_HEAD)
        .serve_connection(TokioIo::new(stream), service)
        .await;
    if let Err(error) = served
        && error.is_parse()
    {
        log.line(format_args!("refused: not a request of HTTP: {error}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::routing::get;
    use std::io::{Read, Write};
    use std::net::{Ipv4Addr, SocketAddr, TcpStream as Stream};

    const MOST: usize = 4;

    /// A server that notes whole requests, as the door does, until the process ends.
    fn running() -> SocketAddr {
        let (sender, address) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
                sender.send(listener.local_addr().unwrap()).unwrap();
                let note = async |request: axum::extract::Request| {
                    request.extensions().get::<LastWhole>().unwrap().note();
                    "here"
                };
                accept(listener, Router::new().route("/", get(note)), MOST, Arc::new(Log::new())).await
            })
        });
        address.recv().unwrap()
    }

    fn ask(mut stream: &Stream) -> bool {
        write!(stream, "GET / HTTP/1.1\r\nHost: x\r\n\r\n").unwrap();
        let mut answer = [0; 12];
        stream.read_exact(&mut answer).is_ok() && answer == *b"HTTP/1.1 200"
    }

    fn is_closed(mut stream: &Stream) -> bool {
        !matches!(stream.read(&mut [0; 1]), Ok(1..))
    }

    #[test]
    fn who_asks_takes_the_place_of_who_never_did_and_then_of_who_did_not_for_longest() {
        let address = running();
        let open = || Stream::connect(address).unwrap();
        let first = open();
        assert!(ask(&first));
        let slow: Vec<Stream> = (1..MOST).map(|_| open()).collect();
        slow.iter().for_each(|mut stream| stream.write_all(b"GET / HT").unwrap());
        // each takes the place of a slow one
        let others: Vec<Stream> = (1..MOST).map(|_| open()).collect();
        assert!(others.iter().all(ask));
        assert!(slow.iter().all(is_closed));
        let mut last = open();
        assert!(ask(&last));
        assert!(is_closed_after_answer(&first));
        assert!(others.iter().all(ask_again));
        last.write_all(b"GET / HT").unwrap();
    }

    /// Reads the rest of the first answer, then the end.
    fn is_closed_after_answer(mut stream: &Stream) -> bool {
        stream.read_to_end(&mut Vec::new()).is_ok()
    }

    fn ask_again(mut stream: &Stream) -> bool {
        let mut rest = [0; 512];
        write!(stream, "GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").unwrap();
        let mut all = Vec::new();
        while let Ok(count @ 1..) = stream.read(&mut rest) {
            all.extend_from_slice(&rest[..count]);
        }
        String::from_utf8_lossy(&all).contains("HTTP/1.1 200")
    }
}
