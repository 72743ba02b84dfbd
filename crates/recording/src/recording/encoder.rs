//! The messages of an episode, step by step, for files, viewers and replays.

use super::channel::{Channel, Message};
use super::ending::Ending;
use super::events::Events;
use super::meshes::Meshes;
use super::{motion, scene};
use cocarry::episode::Episode;
use cocarry::geometry::Point;
use cocarry::learning::Learner;
use cocarry::preference::Learned;
use cocarry::quantities::{Record, View};
use cocarry::scenario::PreparedScenario;

/// An encoder of an episode's messages. Equal episodes give equal bytes.
#[derive(Clone, Debug)]
pub struct Encoder<'a> {
    prepared: &'a PreparedScenario,
    /// The lines of the options, as they were last sent.
    options: scene::OptionLines,
    /// The `/scene/team` message of another recording of the episode, if it is used in place of a new one.
    team: Option<Vec<u8>>,
    events: Events,
    /// The line that the team has walked; the points inside straight parts are left out.
    walked: Vec<Point>,
    /// What the last `/learned` message was made from.
    learned: Option<Known>,
    /// The messages of the last call.
    messages: Vec<Message>,
}

/// The values that a learned belief depends on. A new message is sent only where they changed.
#[derive(Clone, Debug, PartialEq)]
struct Known {
    perception: Learned,
    tasks: Vec<[f64; 2]>,
}

impl Known {
    fn of(learner: &Learner) -> Self {
        Self { perception: learner.perception().learned(), tasks: learner.tolerance().tasks().to_vec() }
    }
}

impl<'a> Encoder<'a> {
    /// An encoder before the first step.
    pub fn new(prepared: &'a PreparedScenario) -> Self {
        Self {
            options: scene::OptionLines::new(prepared.options()),
            prepared,
            team: None,
            events: Events::default(),
            walked: Vec::new(),
            learned: None,
            messages: Vec::new(),
        }
    }

    /// An encoder whose `/scene/team` message is this one, as it is in a recording. It may hold the files of a
    /// robot's meshes, which the scenario does not.
    pub(super) fn with_team(self, team: Option<Vec<u8>>) -> Self {
        Self { team, ..self }
    }

    /// The channels of an episode.
    pub fn channels(&self, episode: &Episode) -> Vec<Channel> {
        let is_used = |channel: &Channel| match channel {
            Channel::Transforms
            | Channel::Team
            | Channel::Joints
            | Channel::Control
            | Channel::Preparation => self.prepared.robot().is_some(),
            Channel::Base => self.has_free_base(),
            Channel::Learned => episode.learner().is_some(),
            Channel::Interaction => episode.observation().is_some(),
            _ => true,
        };
        Channel::ALL.into_iter().filter(is_used).collect()
    }

    /// The messages before the first step, or before the next step of a resumed episode: scene and state.
    pub fn begin(&mut self, episode: &Episode) -> &[Message] {
        self.messages.clear();
        let (world, robot) = (self.prepared.world(), self.prepared.robot());
        let time = self.time(episode.summary().steps);
        self.messages.push(Message::of(
            Channel::World,
            time,
            &scene::world(world, self.prepared.options(), time),
        ));
        if let Some(robot) = robot {
            self.messages.push(match &self.team {
                Some(data) => Message { channel: Channel::Team, time, data: data.clone() },
                None => {
                    Message::of(Channel::Team, time, &scene::team(robot, world, &Meshes::of(robot), time))
                }
            });
        }
        self.walked.push(episode.position());
        self.state(episode, time);
        &self.messages
    }

    /// The messages of a step: decisions at its beginning, motion and forces at its end.
    pub fn step(&mut self, episode: &Episode) -> &[Message] {
        self.messages.clear();
        let (tick, view) = (episode.tick(), View::new(self.prepared, episode));
        let (from, to) = (self.time(tick.step), self.time(tick.step + 1));
        let decided = self.events.decided(episode, self.prepared.options(), from);
        self.messages.extend(decided.iter().map(|log| Message::of(Channel::Log, from, log)));
        self.json(Channel::Options, from, &view);
        self.json(Channel::Coordination, from, &view);
        if let Some(options) = self.options.update(tick, from) {
            self.messages.push(Message::of(Channel::OptionLines, from, &options));
        }
        let has_robot = self.prepared.robot().is_some();
        if has_robot && episode.decision_basis().is_some() {
            self.json(Channel::Preparation, from, &view);
        }
        self.learned(episode, from);
        self.state(episode, to);
        if has_robot && tick.robot.is_some() {
            self.json(Channel::Control, to, &view);
            if self.has_free_base() {
                self.json(Channel::Base, to, &view);
            }
        }
        if let Some(seen) = episode.observation() {
            self.json(Channel::Interaction, to, &view);
            let events = self.events.touched(tick.step, &seen.contacts, to);
            self.messages.extend(events.iter().map(|log| Message::of(Channel::Log, to, log)));
        }
        self.json(Channel::Cost, to, &view);
        self.walk(episode.position());
        let path = scene::path(&self.walked, episode.path(), to);
        self.messages.push(Message::of(Channel::Path, to, &path));
        &self.messages
    }

    /// The messages of the end.
    pub fn end(&mut self, episode: &Episode, ending: Ending) -> &[Message] {
        self.messages.clear();
        let time = self.time(episode.summary().steps);
        let view = View { outcome: ending.outcome(), ..View::new(self.prepared, episode) };
        let ended = Events::ended(&view, time);
        self.messages.extend(ended.iter().map(|log| Message::of(Channel::Log, time, log)));
        self.json(Channel::Outcome, time, &view);
        &self.messages
    }

    /// Whether there is an omnidirectional base.
    fn has_free_base(&self) -> bool {
        self.prepared.robot().is_some_and(|robot| robot.drive.is_omnidirectional())
    }

    /// The simulated time at the beginning of a step, ns.
    fn time(&self, step: u64) -> u64 {
        (step as f64 * self.prepared.scenario().settings.planning_step * 1e9).round() as u64
    }

    /// Adds the message with a channel's quantities.
    fn json(&mut self, channel: Channel, time: u64, view: &View) {
        let record: Record = channel.quantities().iter().flat_map(|table| view.read(table)).collect();
        self.messages.push(Message::json(channel, time, record));
    }

    /// Adds what was learned, where that changed.
    fn learned(&mut self, episode: &Episode, time: u64) {
        let known = episode.learner().map(Known::of);
        if known.is_some() && known != self.learned {
            self.json(Channel::Learned, time, &View::new(self.prepared, episode));
            self.learned = known;
        }
    }

    /// Adds the poses and joints, unless the team is a point.
    fn state(&mut self, episode: &Episode, time: u64) {
        let Some(robot) = self.prepared.robot() else { return };
        let transforms = motion::transforms(episode, self.prepared, time);
        self.messages.push(Message::of(Channel::Transforms, time, &transforms));
        let joints = motion::joints(episode, robot, time);
        self.messages.push(Message::of(Channel::Joints, time, &joints));
    }

    /// Extends the walked line. On a straight part its last point moves.
    fn walk(&mut self, to: Point) {
        if let [.., a, b] = self.walked[..]
            && scene::is_between(a, b, to)
        {
            self.walked.pop();
        }
        self.walked.push(to);
    }
}
