//! The people of H4: of the model that the robot learns with, and others.

use cocarry::human::{Boltzmann, Human, HumanDecision, HumanView, Participant, PreferenceHuman};
use cocarry::preference::{Belief, Perception};
use cocarry::scenario::PreparedScenario;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

/// beta of the Boltzmann humans, per cost unit.
pub const RATIONALITY: f64 = 1.0;
/// Steps for which a lapse lasts: 1 m of path.
const LAPSE_STEPS: u64 = 10;

/// How the humans decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum HumanKind {
    /// Eqs. (3) and (5), drawn from the prior.
    Model,
    /// [`Boltzmann`] humans of rationality [`RATIONALITY`].
    Boltzmann,
    /// As the model, but for one metre in ten the human prefers any option.
    Lapses10,
    /// The same for three metres in ten.
    Lapses30,
    /// alpha and gamma beyond the prior's ranges, by up to half of them.
    OutsidePrior,
    /// alpha and gamma are drawn anew after half of the tasks; until then they are those of the model's humans.
    ChangeOfMind,
}

impl HumanKind {
    /// All kinds, those of the model first.
    pub const ALL: [Self; 6] = [
        Self::Model,
        Self::Boltzmann,
        Self::Lapses10,
        Self::Lapses30,
        Self::OutsidePrior,
        Self::ChangeOfMind,
    ];

    /// Name, as in `--json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Boltzmann => "boltzmann",
            Self::Lapses10 => "lapses10",
            Self::Lapses30 => "lapses30",
            Self::OutsidePrior => "outside-prior",
            Self::ChangeOfMind => "change-of-mind",
        }
    }

    fn lapse_rate(self) -> f64 {
        match self {
            Self::Lapses10 => 0.1,
            Self::Lapses30 => 0.3,
            _ => 0.0,
        }
    }
}

/// One person.
pub(super) struct Person {
    pub kind: HumanKind,
    pub eta: f64,
    /// alpha and gamma in each task.
    pub perceptions: Vec<Perception>,
    /// The seed of each task, of disturbances and lapses.
    pub seeds: Vec<u64>,
}

/// A human beyond one end of the range of alpha and of that of gamma.
pub(super) fn outside(belief: &Belief, rng: &mut ChaCha8Rng) -> Perception {
    let [alpha, gamma] = belief.ranges().map(|[lower, upper]| {
        let beyond = 0.5 * (upper - lower) * rng.random::<f64>();
        if rng.random_bool(0.5) { upper + beyond } else { (lower - beyond).max(0.1 * lower) }
    });
    Perception { alpha, gamma }
}

impl Person {
    /// The person in a task.
    pub fn human(&self, prepared: &PreparedScenario, task: usize) -> Box<dyn Human> {
        let (perception, seed) = (self.perceptions[task], self.seeds[task]);
        let stubbornness = prepared.scenario().settings.coordination;
        match (self.kind, self.kind.lapse_rate()) {
            (HumanKind::Boltzmann, _) => {
                let options = prepared.options();
                let participant = Participant { perception, changes: &[], stubbornness, seed, options };
                Box::new(Boltzmann::new(&participant, RATIONALITY))
            }
            (_, 0.0) => Box::new(PreferenceHuman::new(perception, stubbornness)),
            (_, rate) => Box::new(Lapsing {
                human: PreferenceHuman::new(perception, stubbornness),
                rate,
                rng: ChaCha8Rng::seed_from_u64(seed),
                option: None,
            }),
        }
    }
}

/// The paper's human, who now and then prefers any option for [`LAPSE_STEPS`] steps.
#[derive(Clone, Debug)]
struct Lapsing {
    human: PreferenceHuman,
    rate: f64,
    rng: ChaCha8Rng,
    option: Option<usize>,
}

impl Human for Lapsing {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        if view.step.is_multiple_of(LAPSE_STEPS) {
            let (lapses, any) =
                (self.rng.random_bool(self.rate), self.rng.random_range(0..view.prospects.len()));
            self.option = lapses.then_some(any);
        }
        let decision = self.human.decide(view);
        HumanDecision { option: self.option.unwrap_or(decision.option), ..decision }
    }
}
