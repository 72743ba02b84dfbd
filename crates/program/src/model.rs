//! The arguments of the human model, shared by commands. Numbers are checked where they are read.

use super::file_kind::{self, FileKind};
use super::output::{Failure, input, warn};
use super::settings::number;
use anyhow::Context;
use clap::Args;
use cocarry::episode::PreferenceChange;
use cocarry::preference::{self, Belief, Marginal, Perception, Predictor, WeightedSample};
use cocarry::scenario::{BELIEF_LAPSE, BELIEF_RATIONALITY, PERCEPTION, RISK_WEIGHT};
use cocarry::world::World;
use cocarry::{bounds, located};
use cocarry_studies::fit::read_csv_text;
use std::path::{Path, PathBuf};

/// The robot's model of humans: risk weight and belief.
#[derive(Args, Debug)]
pub(super) struct ModelArguments {
    #[arg(long, value_name = "M", help = RISK_WEIGHT.about, default_value_t = preference::RISK_WEIGHT, value_parser = number(&RISK_WEIGHT), allow_negative_numbers = true)]
    pub risk_weight: f64,
    #[arg(long, value_name = "RATE", help = BELIEF_LAPSE.about, default_value_t = 0.0, value_parser = number(&BELIEF_LAPSE), allow_negative_numbers = true)]
    pub belief_lapse: f64,
    #[arg(long, value_name = "BETA", help = BELIEF_RATIONALITY.about, value_parser = number(&BELIEF_RATIONALITY), allow_negative_numbers = true)]
    pub belief_rationality: Option<f64>,
    #[command(flatten)]
    pub belief: BeliefArguments,
}

/// The robot's belief: the distribution of (alpha, gamma).
#[derive(Args, Debug)]
pub(super) struct BeliefArguments {
    /// Distribution of alpha that the robot assumes: uniform(LOWER,UPPER) or normal(MEAN,STD,LOWER,UPPER)
    #[arg(long, value_name = "DIST", default_value = "uniform(0.55,0.95)")]
    pub belief_alpha: Marginal,
    /// Distribution of gamma that the robot assumes, in the same form
    #[arg(long, value_name = "DIST", default_value = "uniform(0.5,1.1)")]
    pub belief_gamma: Marginal,
    /// Samples of (alpha, gamma) as the robot's belief: CSV with columns alpha, gamma and optionally weight
    #[arg(long, value_name = "FILE", conflicts_with_all = ["belief_alpha", "belief_gamma"])]
    pub belief_samples: Option<PathBuf>,
}

#[derive(serde::Deserialize)]
struct SampleRow {
    alpha: f64,
    gamma: f64,
    weight: Option<f64>,
}

impl ModelArguments {
    pub fn predictor(&self) -> Result<Predictor, Failure> {
        let mut predictor = self.belief.predictor(self.risk_weight)?;
        predictor.set_lapse_rate(self.belief_lapse).map_err(input)?;
        predictor.set_rationality(self.belief_rationality).map_err(input)?;
        Ok(predictor)
    }
}

impl BeliefArguments {
    /// The predictor of this belief with `risk_weight` c_r (m).
    pub fn predictor(&self, risk_weight: f64) -> Result<Predictor, Failure> {
        let belief = match &self.belief_samples {
            None => Belief::Independent { alpha: self.belief_alpha, gamma: self.belief_gamma },
            Some(file) => samples(file).map_err(Failure::Input)?,
        };
        Predictor::new(belief, risk_weight).map_err(input)
    }
}

fn samples(file: &Path) -> anyhow::Result<Belief> {
    let name = || file.display().to_string();
    let (text, delimiter) = read_csv_text(file)?;
    // numbers only: commas are decimal points where they do not separate
    let text = if delimiter == b',' { text } else { text.replace(',', ".") };
    let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).from_reader(text.as_bytes());
    let samples = reader
        .deserialize()
        .map(|row: Result<SampleRow, csv::Error>| {
            row.map(|row| WeightedSample {
                perception: Perception { alpha: row.alpha, gamma: row.gamma },
                weight: row.weight.unwrap_or(1.0),
            })
        })
        .collect::<Result<Vec<_>, _>>()
        .with_context(name)?;
    Belief::samples(samples).with_context(name)
}

/// The world in a file, which may name a map, in a folder of `cocarry new`, a built-in world by its name, or,
/// for `-`, the world on standard input.
pub(super) fn load_world(path: &Path) -> Result<World, Failure> {
    if path == Path::new("-") {
        let world = located::read_input(&bounds::WORLD)
            .and_then(|text| cocarry_maps::parse(located::STANDARD_INPUT, &text, Path::new("")));
        let world = world.map_err(input)?;
        world.warnings().iter().for_each(warn);
        return Ok(world);
    }
    load_world_file(path)
}

/// As [`load_world`], but never from standard input: of a name in a file.
fn load_world_file(path: &Path) -> Result<World, Failure> {
    let path = &file_kind::within(path, FileKind::World);
    let world = cocarry_maps::find(path, &path.to_string_lossy());
    let world = world.map_err(|error| file_kind::refused(path, FileKind::World, error.into()))?;
    world.warnings().iter().for_each(warn);
    Ok(world)
}

/// The world that a file in `folder` names: a world file relative to that folder, otherwise as in
/// [`load_world`].
pub(super) fn load_world_near(folder: &Path, name: &str) -> Result<World, Failure> {
    let sibling = folder.join(name);
    if sibling.is_file() { load_world_file(&sibling) } else { load_world_file(Path::new(name)) }
}

/// The value of alpha or gamma in `text`.
pub(super) fn perception(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| PERCEPTION.contains(*number));
    number.ok_or_else(|| format!("must be {PERCEPTION}"))
}

/// The preference change in `text`, STEP:ALPHA,GAMMA.
pub(super) fn change(text: &str) -> Result<PreferenceChange, String> {
    let form = "must be STEP:ALPHA,GAMMA, as in 40:0.6,0.9";
    let parts = text.split_once(':').and_then(|(step, rest)| Some((step, rest.split_once(',')?)));
    let (step, (alpha, gamma)) = parts.ok_or(form)?;
    let step = step.parse().map_err(|_| format!("{form}: STEP {step:?} must be a whole number of steps"))?;
    let number =
        |name: &str, text: &str| perception(text).map_err(|e| format!("{form}: {name} {text:?} {e}"));
    let perception = Perception { alpha: number("ALPHA", alpha)?, gamma: number("GAMMA", gamma)? };
    Ok(PreferenceChange { step, perception })
}
