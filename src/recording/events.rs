//! What happened in a step, in words.

use super::encoder::Ending;
use super::figures::Names;
use super::motion::timestamp;
use crate::coordination::Mode;
use crate::episode::{Episode, PreferenceChange, Summary, Tick};
use crate::preference::Perception;
use crate::simulation::{BodyKind, Contact, Part};
use foxglove::messages::{Log, log::Level};

/// What was said so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Events {
    /// Mode, option executed, option preferred and option stepped back for in the step before.
    before: Option<(Mode, usize, usize, Option<usize>)>,
    touching: Vec<[Part; 2]>,
}

fn say(level: Level, name: &str, message: String, time: u64) -> Log {
    Log { timestamp: timestamp(time), level: level as i32, message, name: name.to_owned(), ..Log::default() }
}

impl Events {
    /// The human's change of mind with which a step began.
    pub fn changed(change: &PreferenceChange, time: u64) -> Log {
        let Perception { alpha, gamma } = change.perception;
        let words = format!("the human's mind changes: alpha {alpha:.4}, gamma {gamma:.4}");
        say(Level::Info, "human", words, time)
    }

    /// What was decided in a step.
    pub fn decided(&mut self, tick: &Tick, names: Names, time: u64) -> Vec<Log> {
        let mut said = Vec::new();
        let leader = if tick.mode == Mode::RobotLed { "robot" } else { "human" };
        let (executed, preferred) = (names.option(tick.executed), names.option(tick.preferred));
        match self.before {
            None => {
                let words =
                    format!("the {leader} leads on option {executed}; this human prefers option {preferred}");
                said.push(say(Level::Info, "episode", words, time));
            }
            Some((mode, executed_before, preferred_before, back_before)) => {
                if mode != tick.mode {
                    let words =
                        format!("stubbornness passes 1 ({:.3}): the human takes the lead", tick.stubbornness);
                    said.push(say(Level::Warning, "mode", words, time));
                }
                if preferred_before != tick.preferred {
                    let before = names.option(preferred_before);
                    let words = format!("the human prefers option {preferred} to option {before}");
                    said.push(say(Level::Info, "preference", words, time));
                }
                if let (None, Some(option)) = (back_before, tick.steps_back_for) {
                    let words = format!("the team steps back, to turn onto option {}", names.option(option));
                    said.push(say(Level::Info, "option", words, time));
                }
                if executed_before != tick.executed {
                    let before = names.option(executed_before);
                    let words = format!("the {leader} leads from option {before} to option {executed}");
                    said.push(say(Level::Info, "option", words, time));
                }
            }
        }
        self.before = Some((tick.mode, tick.executed, tick.preferred, tick.steps_back_for));
        said
    }

    /// What began to touch during a step.
    pub fn touched(&mut self, contacts: &[Contact], time: u64) -> Vec<Log> {
        let new = contacts.iter().filter(|c| !self.touching.contains(&c.between));
        let said = new.map(|contact| {
            let [first, second] = &contact.between;
            let level = if second.kind == BodyKind::Obstacle { Level::Error } else { Level::Warning };
            let p = contact.point;
            let words = format!(
                "the {}'s {} touched {} at ({:.2}, {:.2}, {:.2}) m, {:.1} mm deep, {:.0} N",
                first.kind.name(),
                first.name,
                second.name,
                p.x,
                p.y,
                p.z,
                1e3 * contact.depth,
                contact.force
            );
            say(level, "contact", words, time)
        });
        let said = said.collect();
        self.touching = contacts.iter().map(|c| c.between.clone()).collect();
        said
    }

    /// How the episode ended.
    pub fn ended(episode: &Episode, ending: Ending, names: Names, time: u64) -> Log {
        let Summary { last_option, walked, accumulated_cost, .. } = *episode.summary();
        let words = format!(
            "{} on option {} after {walked:.2} m; accumulated objective cost {accumulated_cost:.2} m",
            ending.name(),
            names.option(last_option)
        );
        let level = if ending.name() == "arrived" { Level::Info } else { Level::Error };
        say(level, "end", words, time)
    }
}
