//! Live viewing of a run: its arguments, and the viewers that get its messages.

use super::interrupt::Interrupt;
use super::output::Failure;
use clap::Args;
use cocarry::episode::Episode;
use cocarry::scenario::PreparedScenario;
use cocarry_recording::recording::Ending;
use std::net::SocketAddr;

/// The viewers of a run, who get its messages while it goes on.
pub(super) trait Viewers {
    /// Waits for the first one, with --live-wait.
    fn await_first(&mut self);

    /// Sends the last step of the episode, at its time.
    fn step(&mut self, episode: &Episode);

    /// Sends the end of the episode.
    fn end(&mut self, episode: &Episode, ending: Ending);

    /// Ends the service; with --live-wait, once the last viewer has left.
    fn stop(self: Box<Self>);
}

impl LiveArguments {
    /// The viewers of the episode from its present step on; `None` without --live.
    pub fn begin<'a>(
        &self,
        prepared: &'a PreparedScenario,
        episode: &Episode,
        interrupt: &'a Interrupt,
    ) -> Result<Option<Box<dyn Viewers + 'a>>, Failure> {
        let Some(address) = self.live else { return Ok(None) };
        #[cfg(feature = "live")]
        return super::serving::begin(self, address, prepared, episode, interrupt).map(Some);
        #[cfg(not(feature = "live"))]
        {
            let _ = (address, prepared, episode, interrupt);
            Err(super::output::input(anyhow::anyhow!(
                "--live: this program was built without the feature `live`; build it with `cargo install --path \
                 crates/program --features live`"
            )))
        }
    }
}

/// The address of the live server, and the rate of the run.
#[derive(Args, Debug)]
pub(super) struct LiveArguments {
    /// Serve the messages that --record writes over WebSocket while the episode runs, for Foxglove [default
    /// address: 127.0.0.1:8765, for programs on this computer]; 0.0.0.0:8765 serves every computer that can
    /// reach this one. Programs that reach the address can watch, and web pages of allowed origins; viewers
    /// cannot change anything. Needs the cargo feature `live`
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "127.0.0.1:8765",
        value_parser = address
    )]
    pub live: Option<SocketAddr>,
    /// Allow web pages of this origin to watch, such as `https://viewer.example.org`; `*` allows all. Pages of
    /// this computer, <https://app.foxglove.dev> and desktop programs always may
    #[arg(long, value_name = "ORIGIN", requires = "live", value_parser = origin)]
    pub live_origin: Vec<String>,
    /// Simulated seconds per second of real time, from 0.01 to 1000
    #[arg(long, value_name = "R", requires = "live", default_value_t = 1.0, value_parser = rate)]
    pub live_rate: f64,
    /// Wait for a viewer before the first step; after the episode, serve its last state until the last viewer
    /// disconnects, or until Ctrl-C
    #[arg(long, requires = "live")]
    pub live_wait: bool,
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let wanted =
        "must be an IP address and a port, such as 127.0.0.1:8765 or [::1]:8765; port 0 selects a free port";
    text.parse().map_err(|_| wanted.to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.01..=1000.0).contains(rate));
    rate.ok_or_else(|| "must be a number from 0.01 to 1000".to_owned())
}

fn origin(text: &str) -> Result<String, String> {
    let host = text.split_once("://").map(|(_, host)| host);
    let is_origin =
        text == "*" || host.is_some_and(|host| !host.is_empty() && !host.contains(['/', ' ', '*']));
    is_origin.then(|| text.to_owned()).ok_or_else(|| {
        "must be a scheme and a host without a path, such as https://viewer.example.org, or *".to_owned()
    })
}
