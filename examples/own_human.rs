//! A custom human: prefers the safest way, and takes over as soon as the robot leads elsewhere for five
//! seconds.
//!
//! ```text
//! cargo run --release --example own_human
//! ```

use cocarry::coordination::Mode;
use cocarry::episode::{Episode, EpisodeSettings};
use cocarry::human::{Human, HumanDecision, HumanView, Stance};
use cocarry::options::OptionSet;
use cocarry_studies::paper;

/// Counts the time that the team goes another way.
#[derive(Clone, Debug, Default)]
struct Cautious {
    led_elsewhere_s: f64,
    before_s: f64,
}

impl Human for Cautious {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let risk = |&option: &usize| view.prospects[option].risk;
        let safest = (0..view.prospects.len()).min_by(|a, b| risk(a).total_cmp(&risk(b))).unwrap_or(0);
        if view.mode == Mode::RobotLed && view.executed.is_some_and(|executed| executed != safest) {
            self.led_elsewhere_s += view.time - self.before_s;
        }
        self.before_s = view.time;
        HumanDecision {
            option: safest,
            stance: if self.led_elsewhere_s > 5.0 { Stance::TakeOver } else { Stance::Follow },
            stubbornness: (self.led_elsewhere_s / 5.0).min(1.0),
            discomfort: self.led_elsewhere_s,
            perception: None,
            hand: None,
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = paper::ENVIRONMENTS[3].world()?;
    let settings = EpisodeSettings::default();
    let options = OptionSet::new(&world, settings.predictor.risk_weight())?;
    let mut episode = Episode::builder(&options, &settings, paper::EXAMPLE_HUMAN)
        .with_human(Cautious::default())
        .begin()?;
    while episode.step().is_none() {}
    let end = episode.summary();
    let name = |option: usize| &options.options()[option].name;
    println!(
        "{}: option {} first, {} last",
        end.outcome.name(),
        name(end.first_option),
        name(end.last_option)
    );
    Ok(())
}
