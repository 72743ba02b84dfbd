//! The state of a running episode as plain data. With the same inputs it continues with the same bits.

use super::evaluated::Prediction;
use super::step::Begun;
use super::{Episode, Summary, Tick};
use crate::human::HumanDecision;
use crate::learning;
use crate::options::Progress;
use crate::policy::Decision;
use crate::preference::{Prospect, Ways};
use crate::saved::{RestoreError, Saved};
use crate::team::Route;
use serde::{Deserialize, Serialize};

/// The state of an episode after a number of steps, without borrowed data.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EpisodeState {
    human: Saved,
    policy: Saved,
    controller: Saved,
    walk: Saved,
    plant: Saved,
    progress: Progress,
    route: Route,
    tick: Tick,
    summary: Summary,
    steps_without_progress: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    learned: Option<Learned>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    begun: Option<BegunState>,
}

/// A step that has begun: the human has decided, and the robot's policy has not. The rest follows from where
/// the team is.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct BegunState {
    human: HumanDecision,
    stubbornness: f64,
    /// By what the robot had learned before the human's response.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    learned: Option<Prediction>,
}

/// The part of the state that only a robot that learns has.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Learned {
    learner: learning::LearnerState,
    /// The options of the last step, from which the next one learns.
    prospects: Vec<Prospect>,
    ways: Ways,
    decided: Option<(HumanDecision, Decision)>,
}

impl EpisodeState {
    /// Number of steps taken.
    pub fn steps(&self) -> u64 {
        self.summary.steps
    }

    /// A digest of the team's motion so far, its bodies, and the robot's memory (FNV-1a, 64 bits, of their
    /// CBOR). Human and policy are left out: one who decided and one who repeats those decisions have the same
    /// digest.
    pub fn digest(&self) -> u64 {
        let Self { human: _, policy: _, controller, walk, plant, progress, route, tick, summary, .. } = self;
        let Self { steps_without_progress, learned, .. } = self;
        let moving = (controller, walk, plant, progress, route, tick);
        fnv_1a(Saved::of(&(moving, summary, steps_without_progress, learned)).bytes())
    }
}

/// FNV-1a, 64 bits.
fn fnv_1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

impl Episode<'_> {
    /// The present state, between steps or once a step has [begun](Episode::begin_step).
    pub fn state(&self) -> EpisodeState {
        #[rustfmt::skip]
        let Self {
            human, policy, controller, walk, plant, progress, route, tick, summary, steps_without_progress,
            // inputs
            options: _, settings: _, manipulator: _, tick_limit: _, ignores_loss: _,
            // memory that every step fills again
            predictor: _, places: _, place_key: _, memory: _, perceived: _, body_poses: _, hand_from: _, hands: _,
            // of a step that is carried out
            carried: _, carried_robot: _,
            begun,
            // for a robot that learns
            learner, prospects, ways, decided,
        } = self;
        let learned = learner.as_ref().map(|learner| Learned {
            learner: learner.state(),
            prospects: prospects.clone(),
            ways: ways.clone(),
            decided: *decided,
        });
        EpisodeState {
            human: human.save(),
            policy: policy.save(),
            controller: controller.save(),
            walk: walk.save(),
            plant: plant.save(),
            progress: progress.clone(),
            route: route.clone(),
            tick: tick.clone(),
            summary: summary.clone(),
            steps_without_progress: *steps_without_progress,
            learned,
            begun: begun.as_ref().map(|begun| BegunState {
                human: begun.human,
                stubbornness: begun.stubbornness,
                learned: begun.predicted.learned.clone(),
            }),
        }
    }

    /// This episode, which must not have begun, continued from `state`. It continues with the same bits if
    /// options, settings, human, policy, controller and plant are the same.
    ///
    /// # Errors
    /// [`RestoreError`] if the state does not fit.
    pub fn resume(mut self, state: EpisodeState) -> Result<Self, RestoreError> {
        let n = self.options.options().len();
        let Summary { first_option, last_option, ref human, .. } = state.summary;
        let Tick { executed, preferred, reverses_for, .. } = state.tick;
        let indices = [executed, preferred, first_option, last_option, human.preferred_at_start];
        let indices = indices.into_iter().chain(reverses_for);
        let parts = [
            ("place", self.options.knows(&state.progress)),
            ("path", state.route.is_finite()),
            ("option", indices.into_iter().all(|option| option < n)),
            ("option", state.tick.options.len() <= n),
        ];
        if let Some((part, _)) = parts.into_iter().find(|(_, belongs)| !belongs) {
            return Err(RestoreError { part });
        }
        let no_learner = RestoreError { part: "learner" };
        match (self.learner.as_deref_mut(), &state.learned) {
            (None, None) => {}
            (Some(learner), Some(learned)) if learned.prospects.len() <= n && learned.ways.fits(n) => {
                if !learner.restore(&learned.learner) {
                    return Err(no_learner);
                }
                self.prospects.clone_from(&learned.prospects);
                self.ways.clone_from(&learned.ways);
                self.decided = learned.decided;
            }
            _ => return Err(no_learner),
        }
        self.human.restore(&state.human)?;
        self.policy.restore(&state.policy)?;
        self.plant.restore(&state.plant)?;
        self.walk.restore(&state.walk)?;
        self.controller.restore(&state.controller)?;
        let EpisodeState { progress, route, tick, summary, steps_without_progress, begun, .. } = state;
        let resumed = Self { progress, route, tick, summary, steps_without_progress, ..self };
        match begun {
            None => Ok(resumed),
            Some(begun) => resumed.with_begun(begun),
        }
    }

    /// The same episode in a step that has begun.
    fn with_begun(mut self, begun: BegunState) -> Result<Self, RestoreError> {
        let BegunState { human, stubbornness, learned } = begun;
        let now = self.now();
        let (evaluated, mut predicted) = self.evaluate(now, Default::default());
        let belongs = match (&predicted.learned, &learned) {
            (None, None) => true,
            (Some(one), Some(other)) => one.is_like(other),
            _ => false,
        };
        if !belongs || human.option >= evaluated.prospects.len() {
            return Err(RestoreError { part: "step" });
        }
        predicted.learned = learned;
        self.begun = Some(Begun { evaluated, predicted, human, stubbornness });
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_fnv_1a_has_its_published_values() {
        assert_eq!(fnv_1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv_1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv_1a(b"foobar"), 0x8594_4171_f739_67e8);
    }
}
