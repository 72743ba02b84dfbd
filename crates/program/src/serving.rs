//! The server of a run's messages to live viewers, paced by a clock.

use super::interrupt::Interrupt;
use super::live::{LiveArguments, Viewers};
use super::output::Failure;
use cocarry::episode::Episode;
use cocarry::scenario::PreparedScenario;
use cocarry_recording::recording::{Encoder, Ending, LiveError, LiveServer, Message};
use std::net::SocketAddr;
use std::time::{Duration, Instant};

/// The interval between two checks while waiting.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// The interval at which viewers receive the time while the simulation waits.
const TIME_INTERVAL: Duration = Duration::from_secs(1);
/// The delay before the server stops, so that viewers receive the last messages.
const CLOSING_DELAY: Duration = Duration::from_millis(500);

/// The live server of an episode.
struct Serving<'a> {
    encoder: Encoder<'a>,
    server: LiveServer,
    interrupt: &'a Interrupt,
    /// Whether to wait for a viewer at the beginning, and for the viewers to disconnect at the end.
    waits: bool,
    /// Simulated seconds per second of real time.
    rate: f64,
    /// The time at which serving began, and the simulated time then, ns.
    begun: (Instant, u64),
}

/// A server at this address of the episode from its present step on.
pub(super) fn begin<'a>(
    arguments: &LiveArguments,
    address: SocketAddr,
    prepared: &'a PreparedScenario,
    episode: &Episode,
    interrupt: &'a Interrupt,
) -> Result<Box<dyn Viewers + 'a>, Failure> {
    let mut encoder = Encoder::new(prepared);
    let mut server =
        LiveServer::start(address, &arguments.live_origin, &encoder.channels(episode)).map_err(failure)?;
    let messages = encoder.begin(episode);
    server.send(messages);
    let (rate, waits) = (arguments.live_rate, arguments.live_wait);
    eprintln!("live: in Foxglove, open the connection ws://{}", server.address());
    let begun = (Instant::now(), time(messages));
    Ok(Box::new(Serving { encoder, server, interrupt, waits, rate, begun }))
}

impl Viewers for Serving<'_> {
    fn await_first(&mut self) {
        if self.waits {
            eprintln!("live: waiting for a viewer");
            self.wait_while(|serving| !serving.server.is_watched());
            self.begun.0 = Instant::now();
        }
    }

    fn step(&mut self, episode: &Episode) {
        let messages = self.encoder.step(episode);
        let (begun, from) = self.begun;
        let simulated = Duration::from_nanos(time(messages).saturating_sub(from));
        let due = begun + simulated.div_f64(self.rate);
        while let Some(left) = due.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if self.interrupt.is_set() {
                break;
            }
            std::thread::sleep(left.min(POLL_INTERVAL));
        }
        self.server.send(messages);
    }

    fn end(&mut self, episode: &Episode, ending: Ending) {
        self.server.send(self.encoder.end(episode, ending));
    }

    fn stop(self: Box<Self>) {
        if self.waits && self.server.viewers() > 0 && !self.interrupt.is_set() {
            eprintln!(
                "live: the episode is over; its last state is served until the last viewer disconnects, or until Ctrl-C"
            );
            self.wait_while(|serving| serving.server.viewers() > 0);
        } else if self.server.viewers() > 0 {
            std::thread::sleep(CLOSING_DELAY);
        }
        self.server.stop();
    }
}

impl Serving<'_> {
    /// Waits while `holds` is true, or until Ctrl-C.
    fn wait_while(&self, holds: impl Fn(&Self) -> bool) {
        let mut sent = Instant::now();
        while holds(self) && !self.interrupt.is_set() {
            std::thread::sleep(POLL_INTERVAL);
            if sent.elapsed() >= TIME_INTERVAL {
                self.server.broadcast_time();
                sent = Instant::now();
            }
        }
    }
}

/// The simulated time of the last message, ns.
fn time(messages: &[Message]) -> u64 {
    messages.last().map_or(0, |message| message.time)
}

fn failure(error: LiveError) -> Failure {
    Failure::Output(error.into())
}
