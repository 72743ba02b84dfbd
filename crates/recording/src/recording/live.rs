//! A live server: the messages of a running episode for viewers over WebSocket.
//!
//! Only this file uses Foxglove's server, behind a proxy that checks where web pages come from. The server
//! has its own threads, which only wait for viewers and send queued messages: viewers do not influence the
//! episode.

use super::origin_proxy::{OriginProxy, hidden_host};
use super::{Channel, Message};
use foxglove::websocket::{Capability, ChannelView, Client, ServerListener};
use foxglove::{Context, FoxgloveError, PartialMetadata, RawChannel, SinkId, WebSocketServerHandle};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Duration;
use thiserror::Error;

/// The length of the message queue of a viewer. A slow viewer loses the oldest messages. A simulated second
/// has about 50 messages.
const BACKLOG: usize = 4096;
/// The time to wait for viewers that do not answer when the server stops.
const VIEWER_TIMEOUT: Duration = Duration::from_secs(1);

/// The error of a server that cannot start.
#[derive(Debug, Error)]
pub enum LiveError {
    /// The port is in use.
    #[error("{address}: another program listens there; choose another port, or 0 for a free one")]
    InUse {
        /// Where.
        address: SocketAddr,
    },
    /// The address does not belong to this computer, or the port is reserved.
    #[error("{address}: cannot be listened at")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
}

/// A server of an episode's messages. On every topic, a late subscriber first receives the latest message,
/// then all later ones.
///
/// Programs that can reach the address may read the messages. Of web pages in a browser there, only those of
/// this computer, of Foxglove and of the origins that are given may. Viewers cannot change anything.
pub struct LiveServer {
    topics: Arc<Topics>,
    server: WebSocketServerHandle,
    proxy: OriginProxy,
    time: u64,
    /// The context, which keeps the server's channels alive.
    _context: Arc<Context>,
}

/// The latest messages by channel, shared with the server's threads.
struct Topics(Mutex<BTreeMap<Channel, Topic>>);

struct Topic {
    channel: Arc<RawChannel>,
    last: Option<Message>,
    viewers: Vec<SinkId>,
}

impl LiveServer {
    /// A server of these channels at an address of this computer. Port 0 selects a free port. Web pages from
    /// `origins`, such as `https://viewer.example.org`, may connect; `*` allows all.
    ///
    /// # Errors
    /// [`LiveError`]: the address is not available.
    pub fn start(address: SocketAddr, origins: &[String], channels: &[Channel]) -> Result<Self, LiveError> {
        let refused = |error: std::io::Error| match error.kind() {
            ErrorKind::AddrInUse => LiveError::InUse { address },
            _ => LiveError::Listen { address, source: error },
        };
        let listen =
            |error: FoxgloveError| LiveError::Listen { address, source: std::io::Error::other(error) };
        let listener = TcpListener::bind(address).map_err(refused)?;
        let context = Context::new();
        let mut topics = BTreeMap::new();
        for channel in channels {
            let builder = context.channel_builder(channel.topic());
            let builder = builder.message_encoding(channel.encoding()).schema(channel.schema());
            let topic =
                Topic { channel: builder.build_raw().map_err(listen)?, last: None, viewers: Vec::new() };
            topics.insert(*channel, topic);
        }
        let topics = Arc::new(Topics(Mutex::new(topics)));
        let host = hidden_host();
        let server = context
            .websocket_server()
            .name("cocarry")
            .capabilities([Capability::Time])
            .message_backlog_size(BACKLOG)
            .listener(topics.clone())
            .bind(host.to_string(), 0)
            .start_blocking()
            .map_err(listen)?;
        let proxy = OriginProxy::open(listener, (host, server.port()).into(), origins).map_err(refused)?;
        Ok(Self { topics, server, proxy, time: 0, _context: context })
    }

    /// The address of the server.
    pub fn address(&self) -> SocketAddr {
        self.proxy.address()
    }

    /// The number of connected viewers.
    pub fn viewers(&self) -> usize {
        self.server.client_count()
    }

    /// Whether any viewer has subscribed to a topic.
    pub fn is_watched(&self) -> bool {
        self.topics.lock().values().any(|topic| !topic.viewers.is_empty())
    }

    /// Sends messages. The time of the last one is the present time. Never waits for a viewer.
    pub fn send(&mut self, messages: &[Message]) {
        self.time = messages.last().map_or(self.time, |message| message.time);
        // the time comes first, since viewers file messages under the time of their clock
        self.broadcast_time();
        let mut topics = self.topics.lock();
        for message in messages {
            let Some(topic) = topics.get_mut(&message.channel) else { continue };
            topic.last = Some(message.clone());
            topic.viewers.iter().for_each(|viewer| topic.send_latest(*viewer));
        }
    }

    /// Sends the time again, for new viewers: their clock is the simulation's.
    pub fn broadcast_time(&self) {
        self.server.broadcast_time(self.time);
    }

    /// Closes all connections. Viewers do not receive messages that are still queued.
    pub fn stop(self) {
        let stopping = self.server.stop();
        let (say, stopped) = mpsc::channel();
        // a stalled viewer does not close its connection: the program must not wait for it
        std::thread::spawn(move || {
            stopping.wait_blocking();
            say.send(())
        });
        // the viewers have disconnected, or the time is over
        let _ = stopped.recv_timeout(VIEWER_TIMEOUT);
    }
}

impl Topics {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Channel, Topic>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Topic {
    /// Sends the latest message to one viewer.
    fn send_latest(&self, viewer: SinkId) {
        if let Some(Message { time, data, .. }) = &self.last {
            self.channel.log_with_meta_to_sink(data, PartialMetadata::with_log_time(*time), Some(viewer));
        }
    }
}

/// The messages are under the same lock as in [`LiveServer::send`]: no message is sent twice or lost during a
/// subscription.
impl ServerListener for Topics {
    fn on_subscribe(&self, client: Client, view: ChannelView) {
        let channel = Channel::of_topic(view.topic());
        let mut topics = self.lock();
        let topic = channel.and_then(|channel| topics.get_mut(&channel));
        if let (Some(topic), Some(viewer)) = (topic, client.sink_id()) {
            topic.send_latest(viewer);
            topic.viewers.push(viewer);
        }
    }

    fn on_unsubscribe(&self, client: Client, view: ChannelView) {
        let channel = Channel::of_topic(view.topic());
        let mut topics = self.lock();
        if let Some(topic) = channel.and_then(|channel| topics.get_mut(&channel)) {
            topic.viewers.retain(|viewer| Some(*viewer) != client.sink_id());
        }
    }
}
