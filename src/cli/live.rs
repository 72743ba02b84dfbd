//! The arguments of live viewing.

use clap::Args;
use std::net::SocketAddr;

/// Who may watch, and how fast the run goes for them.
#[derive(Args, Debug)]
pub(super) struct LiveArguments {
    /// Serve the episode while it runs, for Foxglove to watch over WebSocket: the messages that --record writes. Only programs on this computer
    /// can connect, unless another address is given: 0.0.0.0:8765 serves everyone who can reach this computer. Needs the cargo feature `live`
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "127.0.0.1:8765",
        value_parser = address
    )]
    pub live: Option<SocketAddr>,
    /// Simulated seconds in a second, from 0.01 to 1000
    #[arg(long, value_name = "R", requires = "live", default_value_t = 1.0, value_parser = rate)]
    pub live_rate: f64,
    /// Wait for a viewer before the first step; and when the episode is over, serve its last state until the last viewer has gone, or Ctrl-C
    #[arg(long, requires = "live")]
    pub live_wait: bool,
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let wanted =
        "must be an IP address and a port, such as 127.0.0.1:8765 or [::1]:8765; port 0 is any that is free";
    text.parse().map_err(|_| wanted.to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.01..=1000.0).contains(rate));
    rate.ok_or_else(|| "must be a number from 0.01 to 1000".to_owned())
}
