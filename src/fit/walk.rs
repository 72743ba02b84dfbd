//! The discomfort of eq. (5) along a robot-led walk, and which eta switches at which step.

use super::Set;
use crate::coordination::{self, Mode, is_misaligned};
use crate::episode::{Episode, Settings, prospects};
use crate::math;
use crate::options::OptionSet;
use crate::paper::EXAMPLE_HUMAN;
use crate::policy::Method;
use crate::preference::ChoiceDistribution;

/// How a robot leads a participant through a world, and what that tells of eta.
///
/// phi(k) = phi(0) exp(g(k) / eta) passes 1 when g(k) passes eta ln(1 / phi(0)): a switch at step k says that eta lies between what g(k - 1) and
/// what g(k) allow, and none that it is at least what the last g allows.
#[derive(Clone, Debug)]
pub enum Guidance {
    /// The robot walks one option from start to end, whatever the human thinks: g(k) is the same for everyone.
    Option {
        /// g(k) by step.
        discomfort: Vec<f64>,
        /// ln(1 / phi(0)).
        patience: f64,
    },
    /// The robot chooses by eq. (6) with the human's own phi(k), so that g(k) depends on eta.
    Mutual {
        /// From 0 to infinity without gaps.
        pieces: Vec<Piece>,
        /// Steps of an episode in which the robot leads to the end.
        steps: u64,
    },
}

/// The eta of humans who switch at the same step after the same walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// From here, which belongs to it.
    pub lower: f64,
    /// To here, which does not.
    pub upper: f64,
    /// The step at which they switch; none if they never do.
    pub step: Option<u64>,
}

/// The least and the largest eta tried, times ln(1 / phi(0)): far below the first discomfort and far above the last.
const DISCOMFORTS: [f64; 2] = [1e-6, 1e6];
/// Two eta whose ratio is nearer to 1 than this are not told apart.
const RATIO: f64 = 1.0 + 1e-12;

impl Guidance {
    /// The robot walks an option (an index) from start to end. `None` where there is no way.
    pub fn along_option(set: &OptionSet, settings: &Settings, option: usize) -> Option<Self> {
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
            along += settings.speed * settings.period;
            if along >= path.length() - 1e-9 {
                break;
            }
            set.advance(&mut progress, path.point_at(along)?);
        }
        Some(Self::Option { discomfort, patience: patience(settings) })
    }

    /// The robot leads by eq. (6), knowing the human's phi(k).
    pub fn mutual(set: &OptionSet, settings: &Settings) -> Self {
        let led = Settings { method: Method::ROBOT_LED, ..settings.clone() };
        let mut episode = Episode::new(set, &led, EXAMPLE_HUMAN);
        while episode.step().is_none() {}
        Self::Mutual { pieces: pieces(set, settings), steps: episode.summary().steps }
    }

    /// How many steps there are.
    pub fn steps(&self) -> u64 {
        match self {
            Self::Option { discomfort, .. } => discomfort.len() as u64,
            Self::Mutual { steps, .. } => *steps,
        }
    }

    /// All eta that switch at `step`, or never. Who asks at a step that switches nobody, since discomfort did not grow, is taken to have noticed
    /// late: the last step before that does. Empty if there is none: no discomfort so far.
    pub fn etas(&self, step: Option<u64>) -> Set {
        match self {
            Self::Option { discomfort, patience } => {
                let bounds = match step {
                    None => discomfort.last().map(|last| [last / patience, f64::INFINITY]),
                    Some(step) => discomfort.get(step as usize).and_then(|g| {
                        let before = discomfort.iter().rev().find(|before| *before < g)?;
                        Some([before / patience, g / patience])
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

/// ln(1 / phi(0)).
fn patience(settings: &Settings) -> f64 {
    -math::ln(settings.coordination.initial_stubbornness)
}

/// What happens while the robot leads a human of some eta.
#[derive(Clone)]
struct Led {
    eta: f64,
    /// The options that the robot executed before the switch, by step.
    executed: Vec<usize>,
    /// g(k) up to and with the switch.
    discomfort: Vec<f64>,
    /// Whether the human took over, at the step after those executed.
    has_switched: bool,
}

impl Led {
    fn of(set: &OptionSet, settings: &Settings, eta: f64) -> Self {
        let coordination = coordination::Settings { eta, ..settings.coordination };
        let settings = Settings { method: Method::MUTUAL, coordination, ..settings.clone() };
        let mut episode = Episode::new(set, &settings, EXAMPLE_HUMAN);
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
        led
    }

    fn switch(&self) -> Option<u64> {
        self.has_switched.then_some(self.executed.len() as u64)
    }

    /// The first step at which two humans see another option or only one takes over; none if they see the same.
    fn differs(&self, other: &Self) -> Option<usize> {
        let pairs = self.executed.iter().zip(&other.executed);
        let same = pairs.take_while(|(a, b)| a == b).count();
        ((self.executed.len(), self.has_switched) != (other.executed.len(), other.has_switched)
            || same < self.executed.len())
        .then_some(same)
    }
}

/// Who switches when, over all eta.
///
/// Two humans who saw the same options up to step k have the same g(k), and the larger eta the smaller phi(k). Eq. (6) is the least of costs
/// that are linear in phi, so that each option is chosen on one interval of phi. Hence, if the ends of an interval of eta see the same options and
/// switch at the same step, so do all between them. An interval whose ends differ is divided where they begin to, so that none is missed.
fn pieces(set: &OptionSet, settings: &Settings) -> Vec<Piece> {
    let patience = patience(settings);
    let led = |eta: f64| Led::of(set, settings, eta);
    let [least, largest] = DISCOMFORTS.map(|g| led(g / patience));
    let mut pieces: Vec<Piece> = Vec::new();
    // intervals still to be looked at, the lowest last
    let mut open = vec![(least, largest)];
    while let Some((low, high)) = open.pop() {
        let differs = low.differs(&high).filter(|_| high.eta > low.eta * RATIO);
        let Some(at) = differs else {
            pieces.push(Piece { lower: low.eta, upper: high.eta, step: low.switch() });
            continue;
        };
        let is_switch = low.executed.len() == at;
        let is_low = |led: &Led| match is_switch {
            true => led.executed.len() == at,
            false => led.executed.get(at) == low.executed.get(at),
        };
        let (mut below, mut above) = (low.clone(), high.clone());
        let divide = |eta: f64, below: &mut Led, above: &mut Led| {
            let is_between = eta > below.eta && eta < above.eta;
            if is_between {
                let tried = led(eta);
                let end = if is_low(&tried) { below } else { above };
                *end = tried;
            }
            is_between
        };
        if is_switch {
            // both have the same g up to here, so that the eta whose phi just passes 1 is known
            let reached = low.discomfort[at] / patience;
            for eta in [reached / RATIO, reached * RATIO] {
                divide(eta, &mut below, &mut above);
            }
        }
        while above.eta > below.eta * RATIO * RATIO * RATIO {
            if !divide((below.eta * above.eta).sqrt(), &mut below, &mut above) {
                break;
            }
        }
        open.push((above, high));
        open.push((low, below));
    }
    // what was not told apart belongs to the piece below it
    for i in 1..pieces.len() {
        pieces[i - 1].upper = pieces[i].lower;
    }
    let last = pieces.len() - 1;
    pieces[0].lower = 0.0;
    pieces[last].upper = f64::INFINITY;
    pieces
}
