//! Serving of a run's messages to live viewers, paced by a clock.

use super::interrupt::Interrupt;
use super::live::LiveArguments;
use super::output::Failure;
use crate::episode::Episode;
use crate::recording::{Encoder, Ending, LiveError, LiveServer, Message};
use crate::scenario::PreparedScenario;
use std::time::{Duration, Instant};

/// How long nothing is done before looking again.
const LOOK: Duration = Duration::from_millis(20);
/// How often viewers are told the time while nothing moves.
const TELL: Duration = Duration::from_secs(1);
/// How long the end waits, so that viewers get the last messages.
const FAREWELL: Duration = Duration::from_millis(500);

/// An episode that is served.
pub(super) struct Serving<'a> {
    encoder: Encoder<'a>,
    server: LiveServer,
    interrupt: &'a Interrupt,
    /// Whether viewers are waited for, at the beginning and at the end.
    waits: bool,
    /// Simulated seconds in a second.
    rate: f64,
    /// When serving began, and the simulated time then, ns.
    begun: (Instant, u64),
}

impl<'a> Serving<'a> {
    /// Begins to serve an episode from the step at which it is, if that is asked for.
    pub fn begin(
        arguments: &LiveArguments,
        stage: &'a PreparedScenario,
        episode: &Episode,
        interrupt: &'a Interrupt,
    ) -> Result<Option<Self>, Failure> {
        let Some(address) = arguments.live else { return Ok(None) };
        let mut encoder = Encoder::new(stage);
        let mut server = LiveServer::start(address, &encoder.channels(episode)).map_err(failure)?;
        let messages = encoder.begin(episode);
        server.send(messages);
        let (rate, waits) = (arguments.live_rate, arguments.live_wait);
        eprintln!("live: in Foxglove, open the connection ws://{}", server.address());
        let begun = (Instant::now(), time(messages));
        Ok(Some(Self { encoder, server, interrupt, waits, rate, begun }))
    }

    /// Waits until somebody watches, if that is asked for.
    pub fn await_viewer(&mut self) {
        if self.waits {
            eprintln!("live: waiting for a viewer");
            self.wait_while(|serving| !serving.server.is_watched());
            self.begun.0 = Instant::now();
        }
    }

    /// Serves the step that the episode has just taken, when it is due.
    pub fn step(&mut self, episode: &Episode) {
        let messages = self.encoder.step(episode);
        let (begun, from) = self.begun;
        let simulated = Duration::from_nanos(time(messages).saturating_sub(from));
        let due = begun + simulated.div_f64(self.rate);
        while let Some(left) = due.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if self.interrupt.is_set() {
                break;
            }
            std::thread::sleep(left.min(LOOK));
        }
        self.server.send(messages);
    }

    /// Serves the end.
    pub fn end(&mut self, episode: &Episode, ending: Ending) {
        self.server.send(self.encoder.end(episode, ending));
    }

    /// Goes on serving the last state, if viewers are waited for, and stops.
    pub fn stop(self) {
        if self.waits && self.server.viewers() > 0 && !self.interrupt.is_set() {
            eprintln!(
                "live: the episode is over; its last state is served until the last viewer has gone, or Ctrl-C"
            );
            self.wait_while(|serving| serving.server.viewers() > 0);
        } else if self.server.viewers() > 0 {
            std::thread::sleep(FAREWELL);
        }
        self.server.stop();
    }

    /// Waits while something holds, or until Ctrl-C.
    fn wait_while(&self, holds: impl Fn(&Self) -> bool) {
        let mut told = Instant::now();
        while holds(self) && !self.interrupt.is_set() {
            std::thread::sleep(LOOK);
            if told.elapsed() >= TELL {
                self.server.tell_time();
                told = Instant::now();
            }
        }
    }
}

/// Simulated time of the last of some messages, ns.
fn time(messages: &[Message]) -> u64 {
    messages.last().map_or(0, |message| message.time)
}

fn failure(error: LiveError) -> Failure {
    Failure::Output(error.into())
}
