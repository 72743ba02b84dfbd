//! What stands in for `serving` where the program is built without the feature `live`: nobody is ever served.

use super::interrupt::Interrupt;
use super::live::LiveArguments;
use super::output::{Failure, input};
use crate::episode::Episode;
use crate::recording::Ending;
use crate::scenario::PreparedScenario;
use anyhow::anyhow;
use std::convert::Infallible;

/// There is none.
pub(super) struct Serving(Infallible);

impl Serving {
    /// Refuses to serve.
    pub fn begin(
        arguments: &LiveArguments,
        _: &PreparedScenario,
        _: &Episode,
        _: &Interrupt,
    ) -> Result<Option<Self>, Failure> {
        match arguments.live {
            None => Ok(None),
            Some(_) => Err(input(anyhow!(
                "--live: this program was built without its feature `live`; `cargo install --path . --features live` builds it with"
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
