//! The discomfort of eq. (5) along a robot-led walk, and the steps at which each eta switches.

use super::Set;
use crate::paper::EXAMPLE_HUMAN;
use cocarry::Error;
use cocarry::coordination::{self, Mode, is_misaligned};
use cocarry::episode::{EpisodeSettings, prospects};
use cocarry::learning::{self, eta_interval};
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::ChoiceDistribution;
use cocarry::scenario::{PreparedScenario, Scenario};

/// The robot's guidance of a participant through a world, and what it implies for eta.
///
/// phi(k) = phi(0) exp(g(k) / eta) exceeds 1 when g(k) exceeds eta ln(1 / phi(0)). A switch at step k bounds
/// eta by g(k - 1) and g(k). An episode without a switch bounds eta from below by the last g.
#[derive(Clone, Debug)]
pub enum Guidance {
    /// The robot walks one option from start to end, whatever the human prefers. g(k) is the same for
    /// everyone.
    Option {
        /// g(k) by step.
        discomfort: Vec<f64>,
        /// ln(1 / phi(0)).
        discomfort_limit: f64,
    },
    /// The robot chooses by eq. (6) with the human's own phi(k), so that g(k) depends on eta.
    Mutual {
        /// Pieces from 0 to infinity without gaps.
        pieces: Vec<Piece>,
        /// Number of steps of an episode in which the robot leads to the end.
        steps: u64,
    },
}

/// The eta of humans who switch at the same step after the same walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Lower end, included.
    pub lower: f64,
    /// Upper end, excluded.
    pub upper: f64,
    /// The step at which they switch; `None` if they never do.
    pub step: Option<u64>,
}

/// Range of eta times ln(1 / phi(0)): far below the first discomfort and far above the last.
const DISCOMFORT_RANGE: [f64; 2] = [1e-6, 1e6];
/// Ratio of two eta below which they are not distinguished.
const SAME_RATIO: f64 = 1.0 + 1e-12;

impl Guidance {
    /// The guidance of a robot that walks an option (an index) from start to end. `None` where there is no
    /// path.
    pub fn along_option(set: &OptionSet, settings: &EpisodeSettings, option: usize) -> Option<Self> {
        let mut progress = set.begin();
        let path = set.path(&progress, option)?;
        let mut predictor = settings.predictor.clone();
        let mut choice = ChoiceDistribution::default();
        let (mut discomfort, mut g, mut along) = (Vec::new(), 0.0, 0.0);
        loop {
            if !discomfort.is_empty() {
                predictor.predict(&prospects(set, &progress), &mut choice);
                let toward = set.next(&progress, option);
                let misaligned = |o: usize| is_misaligned(toward, set.next(&progress, o));
                let p = choice.probabilities().iter().enumerate();
                g += p.map(|(o, p)| if misaligned(o) { *p } else { 0.0 }).fold(0.0, |sum, p| sum + p);
            }
            discomfort.push(g);
            along += settings.speed * settings.planning_step;
            if along >= path.length() - 1e-9 {
                break;
            }
            set.advance(&mut progress, path.point_at(along)?);
        }
        Some(Self::Option { discomfort, discomfort_limit: discomfort_limit(settings) })
    }

    /// The guidance of a robot that leads by eq. (6) and knows the human's phi(k). Of the scenario, eta, the
    /// method and the human do not matter.
    ///
    /// # Errors
    /// [`Error`]: the scenario has a plant with bodies, which do not fit at its start.
    pub fn mutual(prepared: &PreparedScenario) -> Result<Self, Error> {
        let led = EpisodeSettings { method: Method::ROBOT_LED, ..prepared.scenario().settings.clone() };
        let prepared_led = with(prepared, led)?;
        let mut episode = prepared_led.episode()?;
        while episode.step().is_none() {}
        Ok(Self::Mutual { pieces: pieces(prepared)?, steps: episode.summary().steps })
    }

    /// Number of steps.
    pub fn steps(&self) -> u64 {
        match self {
            Self::Option { discomfort, .. } => discomfort.len() as u64,
            Self::Mutual { steps, .. } => *steps,
        }
    }

    /// All eta that switch at `step`, or never. If nobody switches at `step`, because discomfort did not
    /// grow, the participant is assumed to have reacted late, and the last earlier step with a switch counts.
    /// Empty if there is none, because there was no discomfort so far.
    pub fn etas(&self, step: Option<u64>) -> Set {
        match self {
            Self::Option { discomfort, discomfort_limit } => {
                let bounds = match step {
                    None => discomfort.last().map(|last| eta_interval(*last, None, *discomfort_limit)),
                    Some(step) => discomfort.get(step as usize).and_then(|g| {
                        let before = discomfort.iter().rev().find(|before| *before < g)?;
                        Some(eta_interval(*before, Some(*g), *discomfort_limit))
                    }),
                };
                bounds.into_iter().collect()
            }
            Self::Mutual { pieces, .. } => {
                let steps = pieces.iter().map(|piece| piece.step);
                let noticed = match step {
                    None => Some(None),
                    Some(asked) => steps.flatten().filter(|step| *step <= asked).max().map(Some),
                };
                let Some(noticed) = noticed else { return Set::new() };
                let mut etas = Set::new();
                for piece in pieces.iter().filter(|piece| piece.step == noticed) {
                    match etas.last_mut() {
                        Some(last) if last[1] == piece.lower => last[1] = piece.upper,
                        _ => etas.push([piece.lower, piece.upper]),
                    }
                }
                etas
            }
        }
    }
}

/// The scenario with these settings and the human of the example: while the robot leads, humans differ in eta
/// only.
fn with(prepared: &PreparedScenario, settings: EpisodeSettings) -> Result<PreparedScenario, Error> {
    prepared.prepare(Scenario { settings, human: EXAMPLE_HUMAN, ..prepared.scenario().clone() })
}

/// ln(1 / phi(0)).
fn discomfort_limit(settings: &EpisodeSettings) -> f64 {
    learning::discomfort_limit(settings.coordination.initial_stubbornness)
}

/// The course of a walk while the robot leads a human of a given eta.
#[derive(Clone)]
struct LedWalk {
    eta: f64,
    /// The options that the robot executed before the switch, by step.
    executed: Vec<usize>,
    /// g(k) up to and including the switch.
    discomfort: Vec<f64>,
    /// Whether the human took over, at the step after those executed.
    has_switched: bool,
}

impl LedWalk {
    fn of(prepared: &PreparedScenario, eta: f64) -> Result<Self, Error> {
        let settings = &prepared.scenario().settings;
        let coordination = coordination::StubbornnessSettings { eta, ..settings.coordination };
        let prepared =
            with(prepared, EpisodeSettings { method: Method::MUTUAL, coordination, ..settings.clone() })?;
        let mut episode = prepared.episode()?;
        let mut led = Self { eta, executed: Vec::new(), discomfort: Vec::new(), has_switched: false };
        while episode.step().is_none() {
            let tick = episode.tick();
            led.discomfort.push(tick.discomfort);
            if tick.mode == Mode::HumanLed {
                led.has_switched = true;
                break;
            }
            led.executed.push(tick.executed);
        }
        Ok(led)
    }

    fn switch(&self) -> Option<u64> {
        self.has_switched.then_some(self.executed.len() as u64)
    }

    /// The first step at which two humans see different options or only one takes over; `None` if their walks
    /// are equal.
    fn differs(&self, other: &Self) -> Option<usize> {
        let pairs = self.executed.iter().zip(&other.executed);
        let same = pairs.take_while(|(a, b)| a == b).count();
        ((self.executed.len(), self.has_switched) != (other.executed.len(), other.has_switched)
            || same < self.executed.len())
        .then_some(same)
    }
}

/// The pieces of equal switches over all eta.
///
/// Two humans who saw the same options up to step k have the same g(k), and the one with the larger eta has
/// the smaller phi(k). Eq. (6) minimises costs that are linear in phi, so each option is chosen on one
/// interval of phi. Hence, if both ends of an interval of eta see the same options and switch at the same
/// step, so does every eta between them. An interval whose ends differ is divided where they begin to differ,
/// so no piece is missed.
fn pieces(prepared: &PreparedScenario) -> Result<Vec<Piece>, Error> {
    let discomfort_limit = discomfort_limit(&prepared.scenario().settings);
    let led = |eta: f64| LedWalk::of(prepared, eta);
    let [least, largest] = DISCOMFORT_RANGE.map(|g| g / discomfort_limit);
    let (least, largest) = (led(least)?, led(largest)?);
    let mut pieces: Vec<Piece> = Vec::new();
    // intervals still to be examined, the lowest last
    let mut open = vec![(least, largest)];
    while let Some((low, high)) = open.pop() {
        let differs = low.differs(&high).filter(|_| high.eta > low.eta * SAME_RATIO);
        let Some(at) = differs else {
            pieces.push(Piece { lower: low.eta, upper: high.eta, step: low.switch() });
            continue;
        };
        let is_switch = low.executed.len() == at;
        let is_low = |led: &LedWalk| match is_switch {
            true => led.executed.len() == at,
            false => led.executed.get(at) == low.executed.get(at),
        };
        let (mut below, mut above) = (low.clone(), high.clone());
        let divide = |eta: f64, below: &mut LedWalk, above: &mut LedWalk| -> Result<bool, Error> {
            let is_between = eta > below.eta && eta < above.eta;
            if is_between {
                let tried = led(eta)?;
                let end = if is_low(&tried) { below } else { above };
                *end = tried;
            }
            Ok(is_between)
        };
        if is_switch {
            // both have the same g up to here, so the eta whose phi just exceeds 1 is known
            let reached = low.discomfort[at] / discomfort_limit;
            for eta in [reached / SAME_RATIO, reached * SAME_RATIO] {
                divide(eta, &mut below, &mut above)?;
            }
        }
        while above.eta > below.eta * SAME_RATIO * SAME_RATIO * SAME_RATIO {
            if !divide((below.eta * above.eta).sqrt(), &mut below, &mut above)? {
                break;
            }
        }
        open.push((above, high));
        open.push((low, below));
    }
    // what was not distinguished belongs to the piece below it
    for i in 1..pieces.len() {
        pieces[i - 1].upper = pieces[i].lower;
    }
    let last = pieces.len() - 1;
    pieces[0].lower = 0.0;
    pieces[last].upper = f64::INFINITY;
    Ok(pieces)
}
