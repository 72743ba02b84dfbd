//! A live server: the messages of a running episode for viewers over WebSocket.
//!
//! The only file that knows Foxglove's server. The server has threads of its own; they only wait for viewers and send what is queued, so that an
//! episode does not depend on who watches.

use super::{Channel, Message};
use foxglove::websocket::{Capability, ChannelView, Client, ServerListener};
use foxglove::{Context, FoxgloveError, PartialMetadata, RawChannel, SinkId, WebSocketServerHandle};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Duration;
use thiserror::Error;

/// The most messages that wait for a slow viewer, who then loses the oldest. A simulated second has about 50 messages.
const BACKLOG: usize = 4096;
/// How long the end waits for viewers who do not answer.
const PATIENCE: Duration = Duration::from_secs(1);

/// Nobody can be served.
#[derive(Debug, Error)]
pub enum LiveError {
    /// Somebody else serves there.
    #[error("{address}: another program listens there; choose another port, or 0 for any that is free")]
    InUse {
        /// Where.
        address: SocketAddr,
    },
    /// It is no address of this computer, or the port is reserved.
    #[error("{address}: cannot be listened at")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
}

/// Serves an episode's messages. A viewer gets, on every topic that it subscribes to, first what was said there last, then all that is said from then on.
pub struct LiveServer {
    topics: Arc<Topics>,
    server: WebSocketServerHandle,
    address: SocketAddr,
    time: u64,
    /// The server's channels live as long as this.
    _context: Arc<Context>,
}

/// What is served: by channel, shared with the server's threads.
struct Topics(Mutex<BTreeMap<Channel, Topic>>);

struct Topic {
    channel: Arc<RawChannel>,
    last: Option<Message>,
    viewers: Vec<SinkId>,
}

impl LiveServer {
    /// Serves these channels at an address of this computer; port 0 is any that is free.
    ///
    /// # Errors
    /// [`LiveError`]: that address cannot be had.
    pub fn start(address: SocketAddr, channels: &[Channel]) -> Result<Self, LiveError> {
        let listen = |error| match error {
            FoxgloveError::Bind(error) if error.kind() == ErrorKind::AddrInUse => {
                LiveError::InUse { address }
            }
            FoxgloveError::Bind(source) => LiveError::Listen { address, source },
            other => LiveError::Listen { address, source: std::io::Error::other(other) },
        };
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
        let host = match address {
            SocketAddr::V4(address) => address.ip().to_string(),
            SocketAddr::V6(address) => format!("[{}]", address.ip()),
        };
        let server = context
            .websocket_server()
            .name("cocarry")
            .capabilities([Capability::Time])
            .message_backlog_size(BACKLOG)
            .listener(topics.clone())
            .bind(host, address.port())
            .start_blocking()
            .map_err(listen)?;
        let address = SocketAddr::new(address.ip(), server.port());
        Ok(Self { topics, server, address, time: 0, _context: context })
    }

    /// Where it serves.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many are connected.
    pub fn viewers(&self) -> usize {
        self.server.client_count()
    }

    /// Whether anyone subscribes to anything.
    pub fn is_watched(&self) -> bool {
        self.topics.lock().values().any(|topic| !topic.viewers.is_empty())
    }

    /// Says these messages, the last of which tells what time it is. Never waits for a viewer.
    pub fn send(&mut self, messages: &[Message]) {
        self.time = messages.last().map_or(self.time, |message| message.time);
        // before the messages, which viewers file under what their clock says
        self.tell_time();
        let mut topics = self.topics.lock();
        for message in messages {
            let Some(topic) = topics.get_mut(&message.channel) else { continue };
            topic.last = Some(message.clone());
            topic.viewers.iter().for_each(|viewer| topic.tell(*viewer));
        }
    }

    /// Says again what time it is, for viewers who came meanwhile: their clock is the simulation's.
    pub fn tell_time(&self) {
        self.server.broadcast_time(self.time);
    }

    /// Says goodbye to all viewers. What they have not been sent by then, they do not get.
    pub fn stop(self) {
        let stopping = self.server.stop();
        let (say, stopped) = mpsc::channel();
        // one who has stalled takes no goodbye: that must not keep the program
        std::thread::spawn(move || {
            stopping.wait_blocking();
            say.send(())
        });
        // either they have gone, or patience has
        let _ = stopped.recv_timeout(PATIENCE);
    }
}

impl Topics {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Channel, Topic>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Topic {
    /// Tells one viewer what was said last.
    fn tell(&self, viewer: SinkId) {
        if let Some(Message { time, data, .. }) = &self.last {
            self.channel.log_with_meta_to_sink(data, PartialMetadata::with_log_time(*time), Some(viewer));
        }
    }
}

/// Under the same lock as [`LiveServer::send`]: nothing is said twice, or left out, while somebody subscribes.
impl ServerListener for Topics {
    fn on_subscribe(&self, client: Client, view: ChannelView) {
        let channel = Channel::of_topic(view.topic());
        let mut topics = self.lock();
        let topic = channel.and_then(|channel| topics.get_mut(&channel));
        if let (Some(topic), Some(viewer)) = (topic, client.sink_id()) {
            topic.tell(viewer);
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
