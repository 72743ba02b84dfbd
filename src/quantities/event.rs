//! The events of an episode as sentences, for `/log` in recordings and for `cocarry run`.

use super::View;
use crate::coordination::Mode;
use crate::episode::{Loss, Outcome, PreferenceChange, Summary, Tick, Transition};
use crate::geometry::Point;
use crate::options::OptionSet;
use crate::preference::Perception;
use crate::simulation::{BodyKind, Contact};

/// The severity of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// A normal event.
    Info,
    /// An event to check.
    Warning,
    /// An event that ends the episode.
    Error,
}

/// An event of an episode.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The step k in which it happened.
    pub step: u64,
    /// The position of the team, m, world frame; `None` where it is unknown or not relevant.
    pub position: Option<Point>,
    /// Its severity.
    pub severity: Severity,
    /// Its subject: episode, human, preference, mode, option, contact or end.
    pub about: &'static str,
    /// A sentence without time and position.
    pub sentence: String,
}

/// The name of an option.
fn name(options: &OptionSet, option: usize) -> &str {
    &options.options()[option].name
}

impl Event {
    fn of_tick(tick: &Tick, about: &'static str, sentence: String) -> Self {
        Self { step: tick.step, position: Some(tick.position), severity: Severity::Info, about, sentence }
    }

    fn of_step(step: u64, severity: Severity, about: &'static str, sentence: String) -> Self {
        Self { step, position: None, severity, about, sentence }
    }

    /// The decisions of a step. `before` is the step before it, `change` the preference change with which it
    /// began, if any.
    pub fn decided(
        before: Option<&Tick>,
        tick: &Tick,
        change: Option<&PreferenceChange>,
        options: &OptionSet,
    ) -> Vec<Self> {
        let name = |option| name(options, option);
        let of_tick = |about, sentence| Self::of_tick(tick, about, sentence);
        let leader = if tick.mode == Mode::RobotLed { "robot" } else { "human" };
        let (executed, preferred) = (name(tick.executed), name(tick.preferred));
        let mut events = Vec::new();
        if before.is_none() {
            let sentence =
                format!("the {leader} leads on option {executed}; this human prefers option {preferred}");
            events.push(of_tick("episode", sentence));
        }
        events.extend(change.map(|change| Self::preference_change(change, Some(tick), options)));
        let Some(before) = before else { return events };
        if before.preferred != tick.preferred && change.is_none() {
            let from = name(before.preferred);
            let sentence = format!("this human now prefers option {preferred} to option {from}");
            events.push(of_tick("preference", sentence));
        }
        if before.mode != tick.mode {
            let transition = Transition { step: tick.step, position: tick.position };
            events.push(Self::transition(&transition, Some(tick.stubbornness)));
        }
        if before.executed != tick.executed {
            let from = name(before.executed);
            events.push(of_tick(
                "option",
                format!("the {leader} leads from option {from} to option {executed}"),
            ));
        }
        if let (None, Some(option)) = (before.reverses_for, tick.reverses_for) {
            let sentence = format!("the team reverses, to turn onto option {}", name(option));
            events.push(of_tick("option", sentence));
        }
        events
    }

    /// A preference change. `tick` is its step, if known.
    pub fn preference_change(change: &PreferenceChange, tick: Option<&Tick>, options: &OptionSet) -> Self {
        let Perception { alpha, gamma } = change.perception;
        let sentence = format!("the human's preferences change: alpha {alpha:.4}, gamma {gamma:.4}");
        match tick {
            None => Self::of_step(change.step, Severity::Info, "human", sentence),
            Some(tick) => {
                let preferred = name(options, tick.preferred);
                Self::of_tick(tick, "human", format!("{sentence}; they prefer option {preferred} from here"))
            }
        }
    }

    /// The mode transition, with phi in that step, if known.
    pub fn transition(transition: &Transition, stubbornness: Option<f64>) -> Self {
        let phi = stubbornness.map_or(String::new(), |phi| format!(" ({phi:.3})"));
        let sentence = format!("stubbornness passes 1{phi}, the human takes the lead");
        let Transition { step, position } = *transition;
        Self { step, position: Some(position), severity: Severity::Warning, about: "mode", sentence }
    }

    /// A contact during a step.
    pub fn contact(step: u64, contact: &Contact) -> Self {
        let ([first, second], at) = (&contact.between, contact.point);
        let severity = if second.kind == BodyKind::Obstacle { Severity::Error } else { Severity::Warning };
        let sentence = format!(
            "the {}'s {} touched {} at ({:.2}, {:.2}, {:.2}) m, {:.1} mm deep, {:.0} N",
            first.kind.name(),
            first.name,
            second.name,
            at.x,
            at.y,
            at.z,
            1e3 * contact.depth,
            contact.force
        );
        Self::of_step(step, severity, "contact", sentence)
    }

    /// The loss of the object.
    pub fn loss(loss: &Loss) -> Self {
        let who = if loss.by == BodyKind::Human { "human" } else { "robot" };
        let sentence =
            format!("the {who}'s grip was off by {:.1} cm: it lost the object", 100.0 * loss.distance);
        Self::of_step(loss.step, Severity::Error, "contact", sentence)
    }

    /// The end of an episode.
    pub fn end(view: &View) -> Self {
        let outcome = view.outcome;
        let Summary { steps, last_option, walked, .. } = *view.episode.summary();
        let end = match outcome {
            None => "interrupted",
            Some(Outcome::Arrived) => "arrived at B",
            Some(Outcome::OutOfTime) => "did not arrive: the step limit is reached",
            Some(Outcome::NoWay) => "did not arrive: no path leads on from here",
            Some(Outcome::Collided) => "did not arrive: collided",
            Some(Outcome::Stuck) => "did not arrive: stuck for ten seconds",
            Some(Outcome::Dropped) => "did not arrive: the object fell",
            Some(Outcome::ObjectLost) => "did not arrive: the object was lost",
            Some(Outcome::NonFinite) => "did not arrive: the physics broke down",
        };
        let severity = if outcome == Some(Outcome::Arrived) { Severity::Info } else { Severity::Error };
        let mut sentence = format!("{end} on option {} after {walked:.2} m", view.option(last_option));
        sentence.extend(view.self_contact().map(|told| format!("; {told}")));
        Self::of_step(steps, severity, "end", sentence)
    }
}
