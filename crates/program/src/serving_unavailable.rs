//! The replacement of `serving` in a program without the feature `live`: it refuses `--live`.

use super::interrupt::Interrupt;
use super::live::LiveArguments;
use super::output::{Failure, input};
use anyhow::anyhow;
use cocarry::episode::Episode;
use cocarry::scenario::PreparedScenario;
use cocarry_recording::recording::Ending;
use std::convert::Infallible;

/// A server that does not exist.
pub(super) struct Serving(Infallible);

impl Serving {
    /// An error with --live; `None` without.
    pub fn begin(
        arguments: &LiveArguments,
        _: &PreparedScenario,
        _: &Episode,
        _: &Interrupt,
    ) -> Result<Option<Self>, Failure> {
        match arguments.live {
            None => Ok(None),
            Some(_) => Err(input(anyhow!(
                "--live: this program was built without the feature `live`; build it with `cargo install --path . --features live`"
            ))),
        }
    }

    pub fn await_viewer(&mut self) {
        match self.0 {}
    }

    pub fn step(&mut self, _: &Episode) {
        match self.0 {}
    }

    pub fn end(&mut self, _: &Episode, _: Ending) {
        match self.0 {}
    }

    pub fn stop(self) {
        match self.0 {}
    }
}
