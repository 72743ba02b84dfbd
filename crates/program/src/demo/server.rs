//! A server of a page's files for browsers on this computer: HTTP/1.1, one request a connection.
//!
//! It listens at the loopback address alone, and answers only requests that name this computer as their host:
//! a foreign web page cannot read it through a host name that resolves to this computer (DNS rebinding).

use super::files::Pages;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The largest head of a request, bytes, and the longest time to wait for it and to send an answer.
const MAX_HEAD_BYTES: usize = 16 << 10;
const PATIENCE: Duration = Duration::from_secs(5);
/// The largest number of connections at a time; the oldest makes room for another.
const MAX_CONNECTIONS: usize = 64;
/// The time to wait where the system has no more descriptors.
const BETWEEN_TRIES: Duration = Duration::from_millis(50);
/// What a page may load: only what is served here. A module of WebAssembly counts as a script that is compiled.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; \
    img-src 'self' data: blob:; connect-src 'self' data: blob:; worker-src 'self' blob:; object-src 'none'; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

/// A running server; it ends when this is dropped.
pub(super) struct Server {
    address: SocketAddr,
    is_open: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// The connections that are open, in the order in which they came.
#[derive(Default)]
struct Connections {
    next: u64,
    open: BTreeMap<u64, TcpStream>,
}

impl Connections {
    /// Notes a connection. Where there are many, the oldest is closed, so that nobody can keep others out by
    /// sending or reading nothing.
    fn enter(&mut self, stream: &TcpStream) -> io::Result<u64> {
        let stream = stream.try_clone()?;
        if self.open.len() >= MAX_CONNECTIONS
            && let Some((_, oldest)) = self.open.pop_first()
        {
            let _ = oldest.shutdown(Shutdown::Both);
        }
        let id = self.next;
        self.next += 1;
        self.open.insert(id, stream);
        Ok(id)
    }
}

fn held(connections: &Mutex<Connections>) -> MutexGuard<'_, Connections> {
    connections.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Server {
    /// Serves `pages` to those whom `listener` accepts.
    pub fn start(listener: TcpListener, pages: Pages) -> io::Result<Self> {
        let address = listener.local_addr()?;
        let is_open = Arc::new(AtomicBool::new(true));
        let (of_thread, pages) = (is_open.clone(), Arc::new(pages));
        let connections = Arc::new(Mutex::new(Connections::default()));
        let thread = std::thread::Builder::new().spawn(move || {
            for stream in listener.incoming() {
                if !of_thread.load(Ordering::SeqCst) {
                    break;
                }
                let entered = stream.and_then(|stream| Ok((held(&connections).enter(&stream)?, stream)));
                let Ok((id, stream)) = entered else {
                    std::thread::sleep(BETWEEN_TRIES);
                    continue;
                };
                let (pages, of_connection) = (pages.clone(), connections.clone());
                // a connection that breaks, or finds no thread, concerns its browser only
                let served = std::thread::Builder::new().spawn(move || {
                    let _ = serve(stream, &pages, address.port());
                    held(&of_connection).open.remove(&id);
                });
                if served.is_err() {
                    held(&connections).open.remove(&id);
                }
            }
        })?;
        Ok(Self { address, is_open, thread: Some(thread) })
    }

    /// Its address.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.is_open.store(false, Ordering::SeqCst);
        // wakes the thread that waits for connections
        let woken = TcpStream::connect_timeout(&self.address, Duration::from_millis(500));
        if let (Ok(_), Some(thread)) = (woken, self.thread.take()) {
            let _ = thread.join();
        }
    }
}

/// The parts of a request that matter here.
#[derive(Debug, PartialEq)]
struct Request<'a> {
    method: &'a str,
    path: &'a str,
    host: Option<&'a str>,
}

fn serve(mut stream: TcpStream, pages: &Pages, port: u16) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let head = head(&mut stream)?;
    let request = std::str::from_utf8(&head).ok().and_then(parsed);
    let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let refused = |status, sentence: &str| answer(status, "text/plain; charset=utf-8", sentence.len(), "");
    let (start, body): (String, Vec<u8>) = match request {
        None => (refused("400 Bad Request", "not a request\n"), b"not a request\n".to_vec()),
        Some(Request { host, .. }) if !hosts.iter().any(|own| host == Some(own)) => {
            let sentence = "this page is for this computer alone\n";
            (refused("403 Forbidden", sentence), sentence.into())
        }
        Some(Request { method, .. }) if !["GET", "HEAD"].contains(&method) => {
            let sentence = "only GET and HEAD\n";
            (
                answer("405 Method Not Allowed", "text/plain", sentence.len(), "Allow: GET, HEAD\r\n"),
                sentence.into(),
            )
        }
        Some(Request { method, path, .. }) => match pages.get(path) {
            None => {
                (refused("404 Not Found", "there is no such file\n"), b"there is no such file\n".to_vec())
            }
            Some(served) => {
                let start = answer("200 OK", served.mime, served.bytes.len(), "");
                (start, if method == "HEAD" { Vec::new() } else { served.bytes.into_owned() })
            }
        },
    };
    stream.write_all(start.as_bytes())?;
    stream.write_all(&body)?;
    stream.shutdown(Shutdown::Write)?;
    // what the browser still sends is read, so that it does not lose the answer
    stream.set_read_timeout(Some(Duration::from_millis(200)))?;
    let _ = stream.take(MAX_HEAD_BYTES as u64).read_to_end(&mut Vec::new());
    Ok(())
}

/// The head of an answer.
fn answer(status: &str, mime: &str, length: usize, more: &str) -> String {
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: {mime}\r\nContent-Length: {length}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nContent-Security-Policy: {POLICY}\r\nReferrer-Policy: no-referrer\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\n{more}Connection: close\r\n\r\n"
    )
}

fn parsed(head: &str) -> Option<Request<'_>> {
    let mut lines = head.split("\r\n");
    let mut words = lines.next()?.split(' ');
    let (method, path, version) = (words.next()?, words.next()?, words.next()?);
    if !version.starts_with("HTTP/1.") || words.next().is_some() {
        return None;
    }
    let headers = lines.filter_map(|line| line.split_once(':'));
    let mut hosts =
        headers.filter(|(name, _)| name.eq_ignore_ascii_case("host")).map(|(_, host)| host.trim());
    let host = hosts.next();
    // of two, nobody knows which one holds
    hosts.next().is_none().then_some(Request { method, path, host })
}

/// The request up to the end of its head.
fn head(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let until = Instant::now() + PATIENCE;
    let (mut head, mut part) = (Vec::new(), [0; 1024]);
    loop {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() || head.len() > MAX_HEAD_BYTES {
            return Err(ErrorKind::InvalidData.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut part)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            read => head.extend_from_slice(&part[..read]),
        }
        if let Some(end) = head.windows(4).position(|end| end == b"\r\n\r\n") {
            head.truncate(end);
            return Ok(head);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    /// The answer of a server with one page to a request, in which PORT stands for its port.
    fn asked(request: &str) -> String {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let server = Server::start(listener, Pages::Built(&[("index.html", b"the page")])).unwrap();
        let mut stream = TcpStream::connect(server.address()).unwrap();
        let port = server.address().port().to_string();
        stream.write_all(request.replace("PORT", &port).as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    #[test]
    fn a_browser_of_this_computer_gets_the_page() {
        for host in ["127.0.0.1:PORT", "localhost:PORT"] {
            let answer = asked(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"));
            assert!(answer.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/html"), "{answer}");
            assert!(
                answer.contains("Content-Length: 8\r\n") && answer.ends_with("\r\n\r\nthe page"),
                "{answer}"
            );
            assert!(answer.contains("Cache-Control: no-store\r\n"), "{answer}");
        }
        let answer = asked("HEAD / HTTP/1.1\r\nhost: localhost:PORT\r\n\r\n");
        assert!(answer.contains("Content-Length: 8\r\n") && answer.ends_with("\r\n\r\n"), "{answer}");
    }

    /// Connections that send nothing, or do not read their answers.
    #[test]
    fn nobody_keeps_a_browser_out() {
        static LARGE: [u8; 8 << 20] = [0; 8 << 20];
        static FILES: &[(&str, &[u8])] = &[("index.html", b"the page"), ("large", &LARGE)];
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let server = Server::start(listener, Pages::Built(FILES)).unwrap();
        let connect = || TcpStream::connect(server.address()).unwrap();
        let ask = |stream: &mut TcpStream, path: &str| {
            // the oldest may be closed already
            let _ = write!(stream, "GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", server.address());
        };
        let mut others: Vec<_> = (0..200).map(|_| connect()).collect();
        others.iter_mut().step_by(2).for_each(|stream| ask(stream, "/large"));
        let (mut stream, mut answer) = (connect(), String::new());
        ask(&mut stream, "/");
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.ends_with("the page"), "{answer}");
    }

    #[test]
    fn others_do_not() {
        for (request, status) in [
            ("GET / HTTP/1.1\r\nHost: evil.example:PORT\r\n\r\n", "403"),
            ("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", "403"),
            ("GET / HTTP/1.1\r\n\r\n", "403"),
            ("GET / HTTP/1.1\r\nHost: localhost:PORT\r\nHost: evil.example\r\n\r\n", "400"),
            ("POST / HTTP/1.1\r\nHost: localhost:PORT\r\n\r\n", "405"),
            ("GET /../Cargo.toml HTTP/1.1\r\nHost: localhost:PORT\r\n\r\n", "404"),
            ("GET\r\n\r\n", "400"),
            ("\u{1}\u{2} / HTTP/2\r\n\r\n", "400"),
        ] {
            let answer = asked(request);
            assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{request:?}: {answer}");
            assert!(!answer.contains("the page"), "{request:?}: {answer}");
        }
    }
}
