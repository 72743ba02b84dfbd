//! The messages of `/log`.

use super::frames::timestamp;
use cocarry::episode::{Episode, Tick};
use cocarry::options::OptionSet;
use cocarry::quantities::{Event, Severity, View};
use cocarry::simulation::{Contact, Part};
use foxglove::messages::{Log, log::Level};

/// The state of earlier steps that the log depends on.
#[derive(Clone, Debug, Default)]
pub(super) struct Events {
    before: Option<Tick>,
    touching: Vec<[Part; 2]>,
}

fn log(event: Event, time: u64) -> Log {
    let level = match event.severity {
        Severity::Info => Level::Info,
        Severity::Warning => Level::Warning,
        Severity::Error => Level::Error,
    };
    Log {
        timestamp: timestamp(time),
        level: level as i32,
        message: event.sentence,
        name: event.about.to_owned(),
        ..Log::default()
    }
}

impl Events {
    /// The decisions of the last step.
    pub fn decided(&mut self, episode: &Episode, options: &OptionSet, time: u64) -> Vec<Log> {
        let (tick, change) = (episode.tick(), episode.change());
        let events = Event::decided(self.before.as_ref(), tick, change, options);
        self.before = Some(tick.clone());
        events.into_iter().map(|event| log(event, time)).collect()
    }

    /// The contacts that began during a step.
    pub fn touched(&mut self, step: u64, contacts: &[Contact], time: u64) -> Vec<Log> {
        let new = contacts.iter().filter(|c| !self.touching.contains(&c.between));
        let logs = new.map(|contact| log(Event::contact(step, contact), time)).collect();
        self.touching = contacts.iter().map(|c| c.between.clone()).collect();
        logs
    }

    /// The end of the episode.
    pub fn ended(view: &View, time: u64) -> Vec<Log> {
        let loss = view.episode.summary().loss.as_ref().map(Event::loss);
        loss.into_iter().chain([Event::end(view)]).map(|event| log(event, time)).collect()
    }
}
