//! An inference: what the answers of participants say about alpha and gamma of each.
//!
//! ```text
//! cargo run --release --example inference
//! ```

use cocarry::options::OptionSet;
use cocarry::preference::{Belief, RISK_WEIGHT};
use cocarry::world::World;
use cocarry_studies::fit::{AnswerFile, InferenceModel, InferenceSettings, Situation, infer};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = AnswerFile::read(Path::new("docs/data/table-1-humans.csv"))?;
    let mut situations = Vec::new();
    for (name, _) in file.worlds() {
        let world = World::load(&Path::new("worlds").join(format!("{name}.toml")))?;
        situations.push(Situation::new(name, &OptionSet::new(&world, RISK_WEIGHT)?));
    }
    let answers = file.matched(situations, true)?;
    let model = InferenceModel { belief: Belief::default(), risk_weight: RISK_WEIGHT };
    let settings = InferenceSettings { lapse_rate: 0.05, draws: 100, ..Default::default() };
    let inference = infer(Some(&answers), None, &[], &model, &settings, &|| ())?;
    for person in &inference.people {
        let [alpha, gamma] = [&person.alpha, &person.gamma].map(|figure| figure.mean);
        println!(
            "{}: alpha {alpha:.3}, gamma {gamma:.3}, from {} answers",
            person.participant, person.answers
        );
    }
    Ok(())
}
