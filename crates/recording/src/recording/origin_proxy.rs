//! The proxy in front of the live server, which refuses web pages from origins that are not allowed.
//!
//! Foxglove's server does not look at the origin of a connection (RFC 6454). It listens at an address of the
//! loopback network known to nobody else, and the proxy passes on the connections that it accepts.

use std::collections::BTreeMap;
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The largest head of a request, bytes, and the longest time to wait for it.
const MAX_HEAD_BYTES: usize = 16 << 10;
const HEAD_PATIENCE: Duration = Duration::from_secs(5);
/// The largest number of viewers at a time.
const MAX_VIEWERS: usize = 64;
/// The largest number of connections that have not sent their request yet; the oldest makes room for another.
const MAX_HALF_OPEN: usize = 64;
/// The time to wait where the system has no more descriptors.
const BETWEEN_TRIES: Duration = Duration::from_millis(50);
/// Viewers that are always allowed, besides pages from this computer: Foxglove in a browser, and desktop
/// programs.
const VIEWERS: [&str; 2] = ["https://app.foxglove.dev", "file://"];

/// The open proxy; it closes, with all connections, when this is dropped.
pub(super) struct OriginProxy {
    address: SocketAddr,
    state: Arc<ProxyState>,
}

struct ProxyState {
    server: SocketAddr,
    /// Allowed origins, besides those that always are; `*` allows all.
    origins: Vec<String>,
    is_open: AtomicBool,
    connections: Mutex<Connections>,
}

/// The connections that are open, in the order in which they came.
#[derive(Default)]
struct Connections {
    next: u64,
    open: BTreeMap<u64, Connection>,
}

struct Connection {
    viewer: TcpStream,
    /// The other end; `None` until the request is there and allowed.
    server: Option<TcpStream>,
}

impl Connection {
    fn close(&self) {
        let _ = self.viewer.shutdown(Shutdown::Both);
        self.server.iter().for_each(|server| drop(server.shutdown(Shutdown::Both)));
    }
}

impl Connections {
    fn half_open(&self) -> impl Iterator<Item = u64> {
        self.open.iter().filter(|(_, connection)| connection.server.is_none()).map(|(id, _)| *id)
    }
}

impl OriginProxy {
    /// Passes the connections that `listener` accepts on to `server`.
    pub fn open(listener: TcpListener, server: SocketAddr, origins: &[String]) -> io::Result<Self> {
        let address = listener.local_addr()?;
        let state = Arc::new(ProxyState {
            server,
            origins: origins.to_vec(),
            is_open: AtomicBool::new(true),
            connections: Mutex::default(),
        });
        let of_thread = state.clone();
        std::thread::spawn(move || {
            for viewer in listener.incoming() {
                if !of_thread.is_open.load(Ordering::SeqCst) {
                    break;
                }
                let (state, Ok(viewer)) = (of_thread.clone(), viewer) else {
                    std::thread::sleep(BETWEEN_TRIES);
                    continue;
                };
                // a connection that breaks, or finds no thread, concerns its viewer only
                let _ = std::thread::Builder::new().spawn(move || {
                    let Ok(id) = state.enter(&viewer) else { return };
                    let _ = state.pass(id, viewer);
                    state.connections().open.remove(&id);
                });
            }
        });
        Ok(Self { address, state })
    }

    /// The address of the proxy.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for OriginProxy {
    fn drop(&mut self) {
        self.state.is_open.store(false, Ordering::SeqCst);
        std::mem::take(&mut self.state.connections().open).values().for_each(Connection::close);
        // wakes the thread that waits for connections
        let mut address = self.address;
        if address.ip().is_unspecified() {
            address.set_ip(Ipv4Addr::LOCALHOST.into());
        }
        let _ = TcpStream::connect_timeout(&address, Duration::from_millis(200));
    }
}

impl ProxyState {
    fn connections(&self) -> std::sync::MutexGuard<'_, Connections> {
        self.connections.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes a connection that is to send its request. Where there are many of these, the oldest is closed, so
    /// that nobody can keep others out by sending nothing.
    fn enter(&self, viewer: &TcpStream) -> io::Result<u64> {
        let viewer = viewer.try_clone()?;
        let mut connections = self.connections();
        let (count, oldest) = (connections.half_open().count(), connections.half_open().next());
        if let Some(oldest) = oldest.filter(|_| count >= MAX_HALF_OPEN) {
            connections.open.remove(&oldest).iter().for_each(Connection::close);
        }
        let id = connections.next;
        connections.next += 1;
        connections.open.insert(id, Connection { viewer, server: None });
        Ok(id)
    }

    /// Notes the other end of a connection; an error if there are too many viewers, or it is closed already.
    fn admit(&self, id: u64, server: &TcpStream) -> io::Result<()> {
        let mut connections = self.connections();
        let viewers = connections.open.len() - connections.half_open().count();
        let connection = connections.open.get_mut(&id).filter(|_| viewers < MAX_VIEWERS);
        connection.ok_or(ErrorKind::ConnectionRefused)?.server = Some(server.try_clone()?);
        Ok(())
    }

    /// Passes one connection on, if its origin is allowed, until either side closes it.
    fn pass(&self, id: u64, mut viewer: TcpStream) -> io::Result<()> {
        let head = read_head(&mut viewer)?;
        if let Some(origin) = self.refused(&head) {
            let why = format!("{origin}: not an allowed origin; see --live-origin\n");
            let length = why.len();
            let answer = format!(
                "HTTP/1.1 403 Forbidden\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{why}"
            );
            return viewer.write_all(answer.as_bytes());
        }
        viewer.set_read_timeout(None)?;
        viewer.set_nodelay(true)?;
        let mut server = TcpStream::connect(self.server)?;
        self.admit(id, &server)?;
        server.set_nodelay(true)?;
        server.write_all(&head)?;
        let (mut from, mut to) = (viewer.try_clone()?, server.try_clone()?);
        let ask = std::thread::spawn(move || {
            let _ = io::copy(&mut from, &mut to);
            let _ = to.shutdown(Shutdown::Both);
        });
        let _ = io::copy(&mut server, &mut viewer);
        let _ = viewer.shutdown(Shutdown::Both);
        let _ = ask.join();
        Ok(())
    }

    /// The origin for which a request is refused. Programs other than browsers send none.
    fn refused(&self, head: &[u8]) -> Option<String> {
        let head = String::from_utf8_lossy(head);
        let headers = head.split("\r\n").skip(1).take_while(|line| !line.is_empty());
        let mut origins = headers
            .filter_map(|line| line.split_once(':'))
            .filter(|(name, _)| name.trim().eq_ignore_ascii_case("origin"))
            .map(|(_, origin)| origin.trim().to_owned());
        origins.find(|origin| !self.is_allowed(origin))
    }

    fn is_allowed(&self, origin: &str) -> bool {
        let is_listed = |listed: &str| listed == "*" || listed.eq_ignore_ascii_case(origin);
        is_of_this_computer(origin)
            || VIEWERS.into_iter().any(is_listed)
            || self.origins.iter().any(|origin| is_listed(origin))
    }
}

/// Whether an origin is a page that this computer serves, at any port.
fn is_of_this_computer(origin: &str) -> bool {
    let Some(host) = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://")) else {
        return false;
    };
    ["localhost", "127.0.0.1", "[::1]"].into_iter().any(|own| {
        let rest = host.strip_prefix(own);
        rest.is_some_and(|port| {
            port.is_empty() || port.strip_prefix(':').is_some_and(|port| port.parse::<u16>().is_ok())
        })
    })
}

/// The head of a request, and what follows it so far.
fn read_head(viewer: &mut TcpStream) -> io::Result<Vec<u8>> {
    let until = Instant::now() + HEAD_PATIENCE;
    let mut head = Vec::new();
    let mut part = [0; 1024];
    loop {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() || head.len() > MAX_HEAD_BYTES {
            return Err(ErrorKind::InvalidData.into());
        }
        viewer.set_read_timeout(Some(left))?;
        let read = viewer.read(&mut part)?;
        if read == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        head.extend_from_slice(&part[..read]);
        if head.windows(4).any(|end| end == b"\r\n\r\n") {
            return Ok(head);
        }
    }
}

/// An address of the loopback network for the server behind the proxy. Where the whole network belongs to
/// this computer, it cannot be guessed by a web page.
pub(super) fn hidden_host() -> Ipv4Addr {
    let [a, b, c, ..] = RandomState::new().build_hasher().finish().to_be_bytes();
    if cfg!(target_os = "linux") {
        Ipv4Addr::new(127, a.max(1), b, c.clamp(1, 254))
    } else {
        Ipv4Addr::LOCALHOST
    }
}
