//! H3, Table III: control cost of following a human with preference changes, with and without pose
//! optimisation, and with the alternatives that the paper rejects without measuring them.
//!
//! The human leads from the start. (alpha, gamma) is drawn from a setting's sub-range, and redrawn once or
//! twice at random steps of the first half; the robot only knows the full ranges. Every method meets the same
//! humans: all comparisons are paired.

pub mod elsewhere;
pub mod guide;
pub mod guide_section;
pub mod section;

use super::{ENVIRONMENTS, Environment, SETTINGS};
use super::{Route, prepared, route};
use crate::parallel::{OnDone, in_parallel};
use crate::statistics::{self, Paired, mean_and_std};
use cocarry::Error;
use cocarry::control;
use cocarry::control::{Avoid, CandidateSet, PoseCriterion};
use cocarry::episode::{ControlSummary, Episode, EpisodeSettings, Outcome, PreferenceChange};
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::{Belief, Perception};
use cocarry::scenario::{Plant, PlantKind, PreferenceChanges, Scenario};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;
use std::collections::BTreeSet;

/// Random episodes per cell, as in the paper.
pub const EPISODES: usize = 100;
/// Default number of them with bodies.
pub const EPISODES_WITH_BODIES: usize = 6;

/// A method of choosing the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseMethod {
    /// The paper's baseline: no pose optimisation, only the inputs of eq. (7).
    WithoutPo,
    /// The paper's method: eq. (8) over 15 arm configurations.
    WithPo,
    /// Eq. (8) over 15 configurations of base and arm.
    WithPoWholeBody,
    /// The most manipulable of the 15 arm configurations.
    Manipulability,
    /// Eq. (8) with equal weights for all options.
    UniformWeights,
    /// Eq. (8) for the tracked option alone.
    TrackedOption,
    /// Eq. (8) with the base kept out of obstacles.
    WithPoObstacles,
    /// The paper's baseline with the base kept out of obstacles.
    WithoutPoObstacles,
}

impl PoseMethod {
    /// All methods, the paper's two first.
    pub const ALL: [Self; 8] = [
        Self::WithoutPo,
        Self::WithPo,
        Self::WithPoWholeBody,
        Self::Manipulability,
        Self::UniformWeights,
        Self::TrackedOption,
        Self::WithoutPoObstacles,
        Self::WithPoObstacles,
    ];

    /// The methods on the physical plant, where the robot always avoids obstacles and the base follows the
    /// path.
    const PHYSICAL: [Self; 5] =
        [Self::WithoutPo, Self::WithPo, Self::Manipulability, Self::UniformWeights, Self::TrackedOption];

    /// The methods compared on a plant.
    pub fn on(plant: PlantKind) -> &'static [Self] {
        if plant == PlantKind::Rapier { &Self::PHYSICAL } else { &Self::ALL }
    }

    /// Name, as in `--json`.
    pub fn name(self) -> &'static str {
        self.entry().0
    }

    /// The name, the candidates and criterion of eq. (8), and the parts of the robot that avoid obstacles.
    fn entry(self) -> (&'static str, CandidateSet, PoseCriterion, Avoid) {
        use {Avoid as A, CandidateSet as C, PoseCriterion as P};
        match self {
            Self::WithoutPo => ("without-po", C::None, P::Expected, A::Nothing),
            Self::WithPo => ("with-po", C::Arm, P::Expected, A::Nothing),
            Self::WithPoWholeBody => ("with-po-whole-body", C::WholeBody, P::Expected, A::Nothing),
            Self::Manipulability => ("manipulability", C::Arm, P::Manipulability, A::Nothing),
            Self::UniformWeights => ("uniform-weights", C::Arm, P::Uniform, A::Nothing),
            Self::TrackedOption => ("tracked-option", C::Arm, P::Tracked, A::Nothing),
            Self::WithPoObstacles => ("with-po-obstacles", C::Arm, P::Expected, A::Base),
            Self::WithoutPoObstacles => ("without-po-obstacles", C::None, P::Expected, A::Base),
        }
    }

    /// The baseline of the method.
    pub fn baseline(self) -> Self {
        match self {
            Self::WithPoObstacles | Self::WithoutPoObstacles => Self::WithoutPoObstacles,
            _ => Self::WithoutPo,
        }
    }

    /// The controller with this choice of configurations.
    pub(super) fn choosing(self, settings: &control::ControlSettings) -> control::ControlSettings {
        let (_, candidates, criterion, _) = self.entry();
        control::ControlSettings { candidates, criterion, ..*settings }
    }

    /// The controller on a plant. On the physical plant it always avoids obstacles.
    fn control(self, plant: PlantKind, settings: &control::ControlSettings) -> control::ControlSettings {
        let (.., avoid) = self.entry();
        let avoid = if plant == PlantKind::Rapier { Avoid::Robot } else { avoid };
        control::ControlSettings { avoid, ..self.choosing(settings) }
    }
}

/// The study of Table III.
#[derive(Clone, Copy, Debug)]
pub struct PoseStudy<'a> {
    /// The plant, kinematic as in the paper or physical, with the controller settings that the methods do not
    /// replace.
    pub plant: &'a Plant,
    /// The postures at the start, by name.
    pub starts: &'a [&'a str],
    /// The methods, by default those of [`PoseMethod::on`] the plant. Without a method's baseline, the first
    /// one takes its place.
    pub methods: &'a [PoseMethod],
    /// Random episodes per cell.
    pub episodes: usize,
    /// Seed of the humans.
    pub seed: u64,
    /// The episode's settings; the method is replaced by human-led.
    pub settings: &'a EpisodeSettings,
}

/// One method in one cell of Table III, from one start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseRow {
    /// Environment, 1 to 4.
    pub environment: u32,
    /// S1 to S4.
    pub setting: &'static str,
    /// The method of choosing the configuration.
    pub method: PoseMethod,
    /// The posture at the start.
    pub start: String,
    /// The paper's mean; `None` for methods that the paper does not report.
    pub paper_mean: Option<f64>,
    /// Mean control cost C of the episodes that arrived both with this method and with its baseline.
    pub ours_mean: f64,
    /// Standard deviation of C over the humans.
    pub ours_std: f64,
    /// The ratio of the mean to the baseline's mean.
    pub ratio: f64,
    /// C minus that of the baseline with the same human; corrected for all comparisons from this start.
    /// `None` for the baselines.
    pub against_baseline: Option<Paired>,
    /// The number of different routes of the compared humans: first and last option, and number of option
    /// changes.
    pub ways: usize,
    /// Episodes run.
    pub episodes: usize,
    /// Episodes that cost less than the baseline with the same human.
    pub wins: usize,
    /// Mean parts of C, of the same episodes: tracking, the effort of the base's inputs, that of the arm's,
    /// pose.
    pub parts: [f64; 4],
    /// Mean effort of these episodes, of wheels and arm.
    pub effort: f64,
    /// Mean tracking of these episodes against a human who walks on without waiting for the robot. With it in
    /// place of tracking, C is against the human's intended walk, the paper's s.
    pub intended_tracking: f64,
    /// The ratio of that C to the baseline's.
    pub intended_ratio: f64,
    /// Smallest distance between the base and an obstacle, m; negative where they overlap.
    #[serde(rename = "least_clearance_m")]
    pub least_clearance: f64,
    /// Episodes that ended because something touched an obstacle.
    pub collided: usize,
    /// Root mean square distance between grasp and reference, m.
    pub position_error_rms: f64,
    /// Share of the steps in which a limit was active.
    pub constrained_share: f64,
    /// Steps without a solution of eq. (7).
    pub fallback_steps: u64,
    /// Episodes in which the base overlapped an obstacle.
    pub overlapping_episodes: usize,
    /// Episodes in which the object was lost: the grasp was off, or on the physical plant a grip yielded, by
    /// more than 10 cm.
    pub lost_object: usize,
    /// Episodes that did not arrive. On the kinematic plant, the episode continues when the object is lost,
    /// since the paper simulates no object.
    pub not_arrived: usize,
}

/// Units of work of [`PoseStudy::table`], for a progress bar.
pub fn units(methods: &[PoseMethod], starts: usize, episodes: usize) -> usize {
    ENVIRONMENTS.len() * SETTINGS.len() * starts * methods.len() * episodes
}

impl PoseRow {
    /// Mean C against the human's intended walk.
    pub fn intended_cost(&self) -> f64 {
        let [_, wheels, arm, pose] = self.parts;
        self.intended_tracking + wheels + arm + pose
    }
}

impl PoseStudy<'_> {
    /// Table III, by environment, setting, start and method.
    ///
    /// # Errors
    /// If a built-in world is not valid.
    pub fn table(&self, on_done: OnDone) -> Result<Vec<PoseRow>, Error> {
        let mut rows = Vec::new();
        for environment in &ENVIRONMENTS {
            rows.extend(self.environment(environment, on_done)?);
        }
        for start in self.starts {
            let from_there = rows.iter_mut().filter(|row| row.start == *start);
            statistics::correct(from_there.filter_map(|row| row.against_baseline.as_mut()));
        }
        Ok(rows)
    }

    fn environment(&self, environment: &Environment, on_done: OnDone) -> Result<Vec<PoseRow>, Error> {
        let settings = EpisodeSettings { method: Method::HUMAN_LED, ..self.settings.clone() };
        let prepared = prepared(environment.world()?, &settings, self.plant)?;
        let humans = self.humans_of(environment, prepared.options())?;
        let is_physical = self.plant.kind() == PlantKind::Rapier;
        // all episodes of the environment; the last index varies fastest
        let (starts, methods, n) = (self.starts, self.methods, self.episodes);
        let cells = SETTINGS.len() * starts.len() * methods.len();
        let ends = in_parallel(cells * n, on_done, |i| {
            let (cell, episode) = (i / n, i % n);
            let (method, start) =
                (methods[cell % methods.len()], starts[cell / methods.len() % starts.len()]);
            let human = &humans[cell / methods.len() / starts.len() * n + episode];
            let mut scenario = Scenario {
                seed: human.gait_seed,
                human: human.first,
                changes: human.changes.clone(),
                ..prepared.scenario().clone()
            };
            if let Some(robot) = scenario.plant.robot_setup_mut() {
                robot.posture = start.to_owned();
                robot.control = method.control(self.plant.kind(), &robot.control);
            }
            let begun = prepared.prepare(scenario)?;
            let episode = begun.episode()?;
            Ok(follow(if is_physical { episode } else { episode.ignoring_loss() }))
        });
        let ends = ends.into_iter().collect::<Result<Vec<_>, Error>>()?;
        Ok((0..SETTINGS.len() * starts.len())
            .flat_map(|group| {
                let all = &ends[group * methods.len() * n..][..methods.len() * n];
                let (setting, start) = (group / starts.len(), starts[group % starts.len()]);
                (0..methods.len())
                    .map(move |m| row(environment, setting, start, (methods, m), all, (n, is_physical)))
                    .collect::<Vec<_>>()
            })
            .collect())
    }

    /// All humans, by environment, setting and episode: the same for every method and start.
    ///
    /// # Errors
    /// If a built-in world is not valid.
    pub fn humans(&self) -> Result<Vec<Human>, Error> {
        let mut humans = Vec::new();
        for environment in &ENVIRONMENTS {
            let options = OptionSet::new(&environment.world()?, self.settings.predictor.risk_weight())?;
            humans.extend(self.humans_of(environment, &options)?);
        }
        Ok(humans)
    }

    fn humans_of(
        &self,
        environment: &Environment,
        options: &OptionSet,
    ) -> Result<Vec<Human>, cocarry::Error> {
        let range = |[center, half]: [f64; 2]| (center - half, center + half);
        let mut humans = Vec::with_capacity(SETTINGS.len() * self.episodes);
        for (s, setting) in SETTINGS.iter().enumerate() {
            let belief = Belief::uniform(range(setting.alpha), range(setting.gamma))?;
            humans.extend((0..self.episodes).map(|episode| {
                let stream = ((u64::from(environment.number) * 16 + s as u64) << 32) + episode as u64;
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
                rng.set_stream(stream);
                let first = belief.sample(&mut rng);
                let changes =
                    PreferenceChanges::OnceOrTwice.draw(&belief, first, options, self.settings, &mut rng);
                let gait_seed = self.seed.wrapping_add(episode as u64);
                let (environment, setting) = (environment.number, setting.name);
                Human { environment, setting, episode, stream, gait_seed, first, changes }
            }));
        }
        Ok(humans)
    }
}

/// A human with preference changes. The generator is ChaCha8 with the study's seed
/// ([`SeedableRng::seed_from_u64`]) and the stream 2^32 (16 environment + s) + episode, s from 0 for S1. It
/// draws alpha and gamma at the start, then the changes ([`PreferenceChanges::draw`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Human {
    /// Environment, 1 to 4.
    pub environment: u32,
    /// S1 to S4.
    pub setting: &'static str,
    /// The episode within the cell, from 0.
    pub episode: usize,
    /// The generator's stream.
    pub stream: u64,
    /// The seed of the gait on the physical plant: the study's seed plus the episode.
    pub gait_seed: u64,
    /// Perception at the start.
    pub first: Perception,
    /// Preference changes.
    pub changes: Vec<PreferenceChange>,
}

/// The results of one episode.
struct EpisodeResult {
    control: ControlSummary,
    steps: u64,
    lost_object: bool,
    arrived: bool,
    collided: bool,
    route: Route,
}

fn follow(mut episode: Episode) -> EpisodeResult {
    let outcome = loop {
        if let Some(outcome) = episode.step() {
            break outcome;
        }
    };
    let summary = episode.summary();
    let control = summary.control.expect("a plant of Table III has a robot");
    EpisodeResult {
        control,
        steps: summary.steps,
        lost_object: summary.has_lost_object(),
        arrived: outcome == Outcome::Arrived,
        collided: outcome == Outcome::Collided,
        route: route(summary),
    }
}

/// One method's row; `all` are the episodes of all methods of the cell, `n` each. Where bodies sway
/// (`is_noisy`), humans who all take the same route differ by noise only.
fn row(
    environment: &Environment,
    setting: usize,
    start: &str,
    (methods, method): (&[PoseMethod], usize),
    all: &[EpisodeResult],
    (n, is_noisy): (usize, bool),
) -> PoseRow {
    let ends = |m: usize| &all[m * n..(m + 1) * n];
    let this = methods[method];
    let baseline = methods.iter().position(|m| *m == this.baseline()).unwrap_or(0);
    // an episode that ends early costs less, so only pairs of which both arrived count
    let both = |i: usize| ends(method)[i].arrived && ends(baseline)[i].arrived;
    let costs = |m: usize| (0..n).filter(|&i| both(i)).map(|i| ends(m)[i].control.cost()).collect::<Vec<_>>();
    let (ours, theirs) = (costs(method), costs(baseline));
    let (ours_mean, ours_std) = mean_and_std(&ours);
    let routes: BTreeSet<_> =
        (0..n).filter(|&i| both(i)).map(|i| (ends(method)[i].route, ends(baseline)[i].route)).collect();
    let of_pairs = |m: usize, part: fn(&ControlSummary) -> f64| {
        let values: Vec<f64> = (0..n).filter(|&i| both(i)).map(|i| part(&ends(m)[i].control)).collect();
        mean_and_std(&values).0
    };
    let parts: [fn(&ControlSummary) -> f64; 4] =
        [|c| c.tracking, |c| c.wheels, ControlSummary::arm, |c| c.pose];
    let steps: u64 = ends(method).iter().map(|e| e.steps).sum();
    let squared: f64 = ends(method).iter().map(|e| e.control.squared_error).sum();
    let constrained: u64 = ends(method).iter().map(|e| e.control.constrained_steps).sum();
    PoseRow {
        environment: environment.number,
        setting: SETTINGS[setting].name,
        method: this,
        start: start.to_owned(),
        paper_mean: match this {
            PoseMethod::WithPo => Some(environment.control_cost_with[setting]),
            PoseMethod::WithoutPo => Some(environment.control_cost_without[setting]),
            _ => None,
        },
        ours_mean,
        ours_std,
        ratio: ours_mean / mean_and_std(&theirs).0,
        against_baseline: (method != baseline)
            .then(|| Paired::of_lists(&ours, &theirs, routes.len() > 1 || !is_noisy))
            .flatten(),
        ways: routes.len(),
        episodes: n,
        wins: ours.iter().zip(&theirs).filter(|(a, b)| a < b).count(),
        parts: parts.map(|part| of_pairs(method, part)),
        effort: of_pairs(method, |c| c.effort),
        intended_tracking: of_pairs(method, |c| c.intended_tracking),
        intended_ratio: of_pairs(method, ControlSummary::intended_cost)
            / of_pairs(baseline, ControlSummary::intended_cost),
        least_clearance: ends(method).iter().map(|e| e.control.least_clearance).fold(f64::INFINITY, f64::min),
        collided: ends(method).iter().filter(|e| e.collided).count(),
        position_error_rms: (squared / steps as f64).sqrt(),
        constrained_share: constrained as f64 / steps as f64,
        fallback_steps: ends(method).iter().map(|e| e.control.fallback_steps).sum(),
        overlapping_episodes: ends(method).iter().filter(|e| e.control.overlapping_steps > 0).count(),
        lost_object: ends(method).iter().filter(|e| e.lost_object).count(),
        not_arrived: ends(method).iter().filter(|e| !e.arrived).count(),
    }
}
