//! Replays: the scenario of a recording is run again and compared message by message.

use super::decisions::{self, DECISIONS};
use super::encoder::Encoder;
use super::ending::Ending;
use super::provenance::{ARITHMETIC, METADATA, RECOVERED, scenario};
use super::{Channel, Difference, Entry, Message, ReadError, Reader, decode};
use cocarry::episode::Episode;
use cocarry::robot::Robot;
use cocarry::scenario::{Decisions, Scenario};
use std::io::Read;

/// The result of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The number of equal messages before the first difference.
    pub same: u64,
    /// The time of the last equal message, ns.
    pub until: u64,
    /// The last step k that was run again; `None` before the first.
    pub step: Option<u64>,
    /// The [stamp](cocarry::arithmetic::stamp) of the arithmetic that it was recorded with; `None` if it says
    /// none, as earlier versions' do.
    pub arithmetic: Option<String>,
    /// The verdict.
    pub verdict: Verdict,
}

/// The verdict of a replay.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// All messages are equal.
    Identical,
    /// All messages are equal, but the recording was recovered from an incomplete one.
    IdenticalUntilCut,
    /// A message differs.
    Different(Difference),
}

/// Runs a recording's scenario again, with the logged decisions of custom partners, and compares its messages
/// with those recorded, up to the first difference.
///
/// `first` and `second` are the same file, each from its beginning.
///
/// # Errors
/// [`ReadError`], also if the recording's scenario is not valid.
pub fn replay<R: Read>(mut first: Reader<R>, second: Reader<R>) -> Result<Replay, ReadError> {
    let file = first.name().to_owned();
    let invalid = |source| ReadError::Scenario { file: file.clone(), source };
    let prepared = scenario(&mut first)?.prepare().map_err(invalid)?;
    let Known { stopped, team, decisions } = known(&mut first)?;
    let mut episode = prepared.episode_of(decisions.partners(&prepared)).map_err(invalid)?;
    // a recording holds the files of a robot's meshes, the scenario does not
    let has_meshes = prepared.robot().is_some_and(Robot::has_visual_meshes);

    let mut recorded = Compared { reader: second, replay: Replay::default(), is_recovered: false };
    let mut encoder = Encoder::new(&prepared).with_team(team.filter(|_| has_meshes));
    if recorded.differs(encoder.begin(&episode))? {
        return Ok(recorded.replay);
    }
    let ending = loop {
        if stopped == Some(episode.summary().steps) {
            break Ending::Interrupted;
        }
        if let Some(outcome) = episode.step() {
            break Ending::Over(outcome);
        }
        recorded.replay.step = Some(episode.tick().step);
        if recorded.differs(encoder.step(&episode))? {
            return Ok(recorded.replay);
        }
    };
    if !recorded.differs(encoder.end(&episode, ending))? {
        recorded.end()?;
    }
    Ok(recorded.replay)
}

/// Runs a recording's scenario again, with the logged decisions of custom partners, and calls `on_step` after
/// every step. Returns the scenario. Nothing is compared.
///
/// # Errors
/// As [`replay`].
pub fn rerun<R: Read>(
    reader: &mut Reader<R>,
    mut on_step: impl FnMut(&Episode),
) -> Result<Scenario, ReadError> {
    let file = reader.name().to_owned();
    let invalid = |source| ReadError::Scenario { file: file.clone(), source };
    let prepared = scenario(reader)?.prepare().map_err(invalid)?;
    let Known { stopped, decisions, .. } = known(reader)?;
    let mut episode = prepared.episode_of(decisions.partners(&prepared)).map_err(invalid)?;
    while stopped != Some(episode.summary().steps) && episode.step().is_none() {
        on_step(&episode);
    }
    drop(episode);
    Ok(prepared.scenario().clone())
}

/// The parts of the recording that a replay uses.
#[derive(Default)]
struct Known {
    /// The number of steps after which the user interrupted the run, if any.
    stopped: Option<u64>,
    /// The shapes of the team.
    team: Option<Vec<u8>>,
    /// The decisions of custom partners.
    decisions: Decisions,
}

fn known<R: Read>(reader: &mut Reader<R>) -> Result<Known, ReadError> {
    let (mut known, mut log) = (Known::default(), None);
    while let Some(entry) = reader.next()? {
        if let Entry::Attachment(attachment) = &entry {
            if attachment.name == DECISIONS {
                log = Some(attachment.clone());
            }
            continue;
        }
        let Some(message) = entry.message() else { continue };
        match Channel::of_topic(&message.channel.topic) {
            Some(Channel::Team) => known.team = Some(message.data.to_vec()),
            Some(Channel::Outcome) => {
                let outcome = decode(message.channel, message.data).unwrap_or_default();
                known.stopped = outcome["steps"].as_u64().filter(|_| outcome["outcome"] == "interrupted");
            }
            _ => {}
        }
    }
    if let Some(log) = log {
        known.decisions = decisions::read(reader, &log)?;
    }
    Ok(known)
}

impl Default for Replay {
    fn default() -> Self {
        Self { same: 0, until: 0, step: None, arithmetic: None, verdict: Verdict::Identical }
    }
}

/// The state of a comparison with a recording.
struct Compared<R> {
    reader: Reader<R>,
    replay: Replay,
    is_recovered: bool,
}

impl<R: Read> Compared<R> {
    /// Compares the next messages. Returns whether the recording differs.
    fn differs(&mut self, expected: &[Message]) -> Result<bool, ReadError> {
        for message in expected {
            if self.differs_from(Some(message))? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The check that the recording has no further messages.
    fn end(&mut self) -> Result<(), ReadError> {
        self.differs_from(None).map(drop)
    }

    fn differs_from(&mut self, expected: Option<&Message>) -> Result<bool, ReadError> {
        let recorded = loop {
            match self.reader.next()? {
                None => break None,
                Some(Entry::Metadata { name, .. }) if name == RECOVERED => self.is_recovered = true,
                Some(Entry::Metadata { name, mut entries }) if name == METADATA => {
                    self.replay.arithmetic = entries.remove(ARITHMETIC);
                }
                Some(entry) => {
                    if let Some(message) = entry.message() {
                        break Some((message.time, Difference::between(Some(&message), expected)));
                    }
                }
            }
        };
        let difference = match recorded {
            None if self.is_recovered && expected.is_some() => {
                self.replay.verdict = Verdict::IdenticalUntilCut;
                return Ok(true);
            }
            None => Difference::between(None, expected),
            Some((time, None)) => {
                self.replay.same += 1;
                self.replay.until = time;
                None
            }
            Some((_, difference)) => difference,
        };
        let Some(difference) = difference else { return Ok(false) };
        self.replay.verdict = Verdict::Different(difference);
        Ok(true)
    }
}
