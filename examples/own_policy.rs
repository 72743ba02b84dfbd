//! A custom robot policy: eq. (6) written anew, which gives the same episode as the built-in `mutual`.
//!
//! ```text
//! cargo run --release --example own_policy
//! ```

use cocarry::coordination::Mode;
use cocarry::episode::{Episode, EpisodeSettings};
use cocarry::human::Stance;
use cocarry::options::OptionSet;
use cocarry::policy::{Decision, RobotPolicy, RobotView};
use cocarry_studies::paper;

/// Leads on the option of least (1 - phi) J_o + phi J~_o until the human takes over, then follows.
#[derive(Clone, Debug)]
struct OwnPolicy;

impl RobotPolicy for OwnPolicy {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        if view.mode == Mode::HumanLed || view.stance == Stance::TakeOver {
            return Decision::follow();
        }
        let phi = view.stubbornness;
        let mut best = (0, f64::INFINITY);
        for (option, seen) in view.evaluated.iter().enumerate() {
            let cost = (1.0 - phi) * seen.objective + phi * seen.expected;
            if cost < best.1 || (cost == best.1 && view.executed == Some(option)) {
                best = (option, cost);
            }
        }
        Decision::lead(best.0)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = paper::ENVIRONMENTS[3].world()?;
    let settings = EpisodeSettings::default();
    let options = OptionSet::new(&world, settings.predictor.risk_weight())?;
    let mut own =
        Episode::builder(&options, &settings, paper::EXAMPLE_HUMAN).with_policy(OwnPolicy).begin()?;
    let mut mutual = Episode::new(&options, &settings, paper::EXAMPLE_HUMAN);
    while own.step().is_none() & mutual.step().is_none() {
        let walked = |episode: &Episode| (episode.tick().executed, episode.tick().accumulated_cost.to_bits());
        assert_eq!(walked(&own), walked(&mutual), "the same option at the same place");
    }
    let end = own.summary();
    println!("{} after {} steps, J accumulated {:.1} m", end.outcome.name(), end.steps, end.accumulated_cost);
    Ok(())
}
